#include "common/dds/call_window.h"

namespace periplus::dds::detail {
namespace {
constexpr std::size_t kBytesPerClient = 64U << 20;
}

std::shared_ptr<Call> CallWindow::find(const CallName& name, Time now) {
  const auto client = clients_.find(name.client);
  if (client == clients_.end()) return nullptr;
  client->second.heard = now;
  const auto call = client->second.calls.find(name.number);
  return call == client->second.calls.end() ? nullptr : call->second;
}

void CallWindow::add(const std::shared_ptr<Call>& call, Time now) {
  Client& client = clients_[call->name.client];
  client.heard = now;
  client.calls[call->name.number] = call;
}

void CallWindow::finish(const std::shared_ptr<Call>& call) {
  call->done = true;
  call->request.reset();
  const auto found = clients_.find(call->name.client);
  if (found == clients_.end()) return;
  Client& client = found->second;
  client.finished.push_back(call->name.number);
  client.bytes += call->reply_bytes;
  while (client.finished.size() > 1 &&
         (client.finished.size() > static_cast<std::size_t>(options_.window) || client.bytes > kBytesPerClient)) {
    const auto oldest = client.calls.find(client.finished.front());
    client.bytes -= oldest->second->reply_bytes;
    client.calls.erase(oldest);
    client.finished.pop_front();
  }
}

void CallWindow::expire(Time now) {
  std::erase_if(clients_, [&](const auto& entry) {
    const Client& client = entry.second;
    return now - client.heard > options_.expiry && client.finished.size() == client.calls.size();
  });
}

void CallWindow::cancel_all() {
  for (auto& [guid, client] : clients_) {
    for (auto& [number, call] : client.calls) {
      if (!call->done) call->cancelled = true;
    }
  }
}

std::size_t CallWindow::replies() const {
  std::size_t count = 0;
  for (const auto& [guid, client] : clients_) count += client.finished.size();
  return count;
}

}  // namespace periplus::dds::detail

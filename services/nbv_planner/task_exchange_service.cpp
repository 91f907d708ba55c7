#include "services/nbv_planner/task_exchange_service.h"

#include <algorithm>
#include <chrono>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/codec_impl.h"

namespace periplus::nbv {
namespace {

using namespace std::chrono_literals;
using TasksClient = dds::RpcClient<msg::RunTasksRequest, msg::RunTasksReply>;

// Who leads does a late part again, long before this.
constexpr auto kDeadline = 30s;
constexpr std::uint32_t kMostTasks = 1000000;

struct GivenUp {};

StageNumbers from_wire(const msg::StageNumbers& m) { return {m.sizes(), m.numbers()}; }

msg::StageNumbers to_wire(const StageNumbers& s) {
  msg::StageNumbers m;
  m.sizes(s.sizes);
  m.numbers(s.numbers);
  return m;
}

class RpcInstance : public OtherInstance {
 public:
  RpcInstance(TasksClient& client, const dds::Guid& instance, const msg::PlanViewRequest& plan, const std::string& alike)
      : client_(client), instance_(instance) {
    request_.plan(plan);
    request_.alike(alike);
  }

  std::optional<StageNumbers> run(const StageHistory& done, int first, int last,
                                  const std::function<bool()>& given_up) override {
    for (std::size_t i = request_.done().size(); i < done.size(); ++i) request_.done().push_back(to_wire(*done[i]));
    request_.first(static_cast<std::uint32_t>(first));
    request_.last(static_cast<std::uint32_t>(last));
    msg::RunTasksReply reply;
    dds::CallOptions options;
    options.deadline = kDeadline;
    options.only_on = instance_;
    options.cancelled = [&given_up]() -> bool {
      if (given_up()) throw GivenUp();  // without waiting for it to be confirmed
      return false;
    };
    try {
      const dds::RpcResult result = client_.call(request_, reply, options);
      if (result.ok()) return from_wire(reply.results());
      log::warn("another planner does not help", {{"status", dds::to_string(result.status)}, {"cause", result.error_message}});
    } catch (const GivenUp&) {
    }
    return std::nullopt;
  }

 private:
  TasksClient& client_;
  const dds::Guid instance_;
  msg::RunTasksRequest request_;
};

}  // namespace

struct TaskExchange::Impl {
  Impl(service::Service& service, std::string like, int most_threads, SearchOf search)
      : alike(std::move(like)), threads(most_threads), search_of(std::move(search)), client(service.node(), "nbv/tasks") {
    server = service.serve<msg::RunTasksRequest, msg::RunTasksReply>(
        "nbv/tasks", [this](const msg::RunTasksRequest& q, msg::RunTasksReply& r, dds::RpcContext&) { run(q, r); });
  }

  void run(const msg::RunTasksRequest& q, msg::RunTasksReply& r) const {
    require(q.alike().to_string() == alike, ErrorCode::bad_input,
            "this planner's version or settings differ from the asking one's: it would compute something else");
    require(q.first() < q.last() && q.last() <= kMostTasks, ErrorCode::bad_input, "tasks are asked for as first < last");
    StageHistory done;
    for (const msg::StageNumbers& stage : q.done()) done.push_back(std::make_shared<const StageNumbers>(from_wire(stage)));
    r.results(to_wire(run_part(search_of(q.plan()), done, static_cast<int>(q.first()), static_cast<int>(q.last()), threads)));
  }

  const std::string alike;
  const int threads;
  const SearchOf search_of;
  TasksClient client;
  std::shared_ptr<dds::RpcServer<msg::RunTasksRequest, msg::RunTasksReply>> server;  // last: stops first
};

TaskExchange::TaskExchange(service::Service& service, const std::string& alike, int threads, SearchOf search_of)
    : impl_(std::make_unique<Impl>(service, alike, threads, std::move(search_of))) {}
TaskExchange::~TaskExchange() = default;

std::vector<std::unique_ptr<OtherInstance>> TaskExchange::others(const msg::PlanViewRequest& request, int most) {
  msg::PlanViewRequest plan = request;
  plan.header({});
  std::vector<std::unique_ptr<OtherInstance>> all;
  for (const dds::Guid& instance : impl_->client.others()) {
    if (static_cast<int>(all.size()) >= most) break;
    all.push_back(std::make_unique<RpcInstance>(impl_->client, instance, plan, impl_->alike));
  }
  return all;
}

}  // namespace periplus::nbv

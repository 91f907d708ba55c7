// Why a run ends before its time. Thread-safe: the bus and the program's end speak, the state machine listens.
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "services/supervisor/modeling_machine.h"

namespace periplus::supervisor {

class Interruption {
 public:
  void abort();                             // the user's wish
  void lose(const std::string& what);       // a service is gone: "simulator was ended by signal 9"
  void stop();                              // this program ends
  void clear();                             // a new run begins

  // The first reason that was given, as what the present state comes to; nothing while there is none.
  std::optional<Outcome> outcome() const;
  // Whether nothing more is to be waited for: a service is gone, or this program ends.
  bool hasty() const;

 private:
  void interrupt(Outcome outcome, bool hasty);

  mutable std::mutex mutex_;
  std::optional<Outcome> outcome_;
  bool hasty_ = false;
};

}  // namespace periplus::supervisor

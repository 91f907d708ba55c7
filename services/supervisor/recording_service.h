// Catches what passes by on the topics (images, perceptions, object grids, model files, the truth if there is any) and hands
// it to the recorder. Nothing of it goes through the state machine.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "common/dds/node.h"
#include "common/object_model/perception.h"
#include "common/wire/knowledge.h"
#include "services/supervisor/run_recorder.h"

namespace periplus::supervisor {

class Recording {
 public:
  explicit Recording(dds::Node& node);
  ~Recording();

  // Begins a new run: forgets what was caught before. The truth is read anew, from the simulator that runs now.
  void clear();
  // Writes left, right and wide image of this stamp; false (and a log line) if one did not arrive within `timeout`.
  bool save_images(const RunRecorder& recorder, int look, std::int64_t stamp_ns, std::chrono::milliseconds timeout);
  bool save_perception(const RunRecorder& recorder, int look, const std::string& view_id, std::chrono::milliseconds timeout);
  // Writes the model file with this SHA-256 as `name`; false if it did not arrive.
  bool save_model(const RunRecorder& recorder, const std::string& name, const std::string& sha256, std::chrono::milliseconds timeout);
  // Writes truth.json and truth.ply if the simulator published the truth; false if nothing of it arrived since clear().
  bool save_truth(const RunRecorder& recorder);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::supervisor

// What the model server knows, as its readers see it: the newest environments (each with its robot) and the newest revisions
// of objects, from the topics periplus/environment, periplus/object and periplus/object/chunk.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "common/core/error.h"
#include "common/dds/node.h"
#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "common/wire/object_assembler.h"

namespace periplus::wire {

// Immutable once published here.
struct KnownEnvironment {
  std::string scene_id, revision;
  scene::Scene scene;
  std::shared_ptr<const scene::CollisionWorld> collision;
  std::shared_ptr<const robot::RobotModel> robot;
};

// Thread-safe. Bad samples are logged and dropped. What is kept is bounded: kEnvironmentsKept environments, kObjectsKept objects
// (those heard of last), of each kRevisionsKept revisions, kMostOctets of grids in all: more than as many of the model server's take.
class Knowledge {
 public:
  static constexpr std::size_t kEnvironmentsKept = 4, kObjectsKept = 8, kRevisionsKept = 4;
  static constexpr std::size_t kMostOctets = std::size_t{256} << 20;

  explicit Knowledge(dds::Node& node);
  ~Knowledge();

  // The environment of that very revision (SHA-256 of its texts), waiting up to `timeout`; nullptr if it did not arrive.
  std::shared_ptr<const KnownEnvironment> environment(const std::string& revision,
                                                      std::chrono::milliseconds timeout = std::chrono::seconds(2)) const;
  // As above, but throws Error(not_here) with a sentence that says what to do.
  std::shared_ptr<const KnownEnvironment> environment_or_throw(const std::string& revision, ErrorCode not_here,
                                                               std::chrono::milliseconds timeout = std::chrono::seconds(2)) const;
  // That very revision; nullptr if it did not arrive in time.
  std::shared_ptr<const KnownObject> object(const std::string& object_id, std::uint32_t revision,
                                            std::chrono::milliseconds timeout = std::chrono::seconds(2)) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::wire

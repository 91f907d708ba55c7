// Objects on the topics periplus/object and periplus/object/chunk, for Knowledge to read: what changed of each since it was published
// last. What the topics keep is the whole of the newest revisions, for those who come late.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "common/dds/node.h"
#include "common/object_model/perception.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::wire {

// Thread-safe.
class ObjectPublisher {
 public:
  explicit ObjectPublisher(dds::Node& node);
  ~ObjectPublisher();

  struct Sent {
    std::size_t chunks = 0;  // that changed
    std::size_t octets = 0;  // of these and the revision that names them, as serialised
  };
  // `views`: left eyes X_WC, in the order of integration. `all`: also what did not change. Throws Error(bad_input | bad_size) as
  // ObjectSplitter does; Error(internal) where the bus takes a sample not: all goes out the next time.
  Sent publish(std::string_view object_id, const voxel::OccupancyGrid& grid, const std::vector<object_model::Landmark>& landmarks = {},
               const std::vector<Pose>& views = {}, bool all = false);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::wire

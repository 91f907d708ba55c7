// Objects put together again from what ObjectSplitter made of them, in whatever order it comes. No DDS. Not thread-safe.
//
// A revision is given only when a chunk of each digest it names is here: never a mixture of two. One of which a chunk was lost is
// given up when a later one is whole, which needs no more than what came since. What is kept is bounded: kObjects objects (those heard
// of last) and kMostOctets in all; of each object the revision that was whole last, kRevisions that wait, and kVersions of each chunk,
// kMostWaiting octets together. What was forgotten comes again with model/publish.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/object_model/perception.h"
#include "common/voxel/occupancy_grid.h"
#include "common/wire/object_chunks.h"
#include "idl/model.h"

namespace periplus::wire {

// Immutable once it is given.
struct KnownObject {
  std::string object_id;
  std::uint32_t revision = 0;
  std::shared_ptr<const voxel::OccupancyGrid> grid;
  std::vector<object_model::Landmark> landmarks;
  std::vector<Pose> views;  // left eyes X_WC of the views in the grid, in the order of integration; the last kViewsOnWire
};

class ObjectAssembler {
 public:
  // Late joiners hear of all objects before the first is whole: kObjects is more than a server is likely to know.
  static constexpr std::size_t kObjects = 64, kRevisions = 4, kVersions = 4;
  static constexpr std::size_t kMostWaiting = std::size_t{128} << 20;  // twice and a half what 512 voxels along each axis take
  static constexpr std::size_t kMostOctets = std::size_t{256} << 20;

  // The revisions that became whole by it, in the order in which they came. One that came again unchanged is given again. Throw
  // Error(bad_input | bad_size | not_finite) with the cause and change nothing; but where more waits than kMostWaiting, what waits of
  // this object is dropped.
  using Whole = std::vector<std::shared_ptr<const KnownObject>>;
  Whole take(const msg::ObjectRevision& revision);
  Whole take(const msg::ObjectChunk& chunk);

 private:
  struct Header {
    msg::ObjectRevision message;               // checked
    std::shared_ptr<KnownObject> object;       // while it waits without grid and landmarks
    std::vector<std::size_t> landmark_ends{};  // of each chunk in the object's landmarks
    std::size_t missing = 0;                   // chunks
  };
  struct Version {
    std::uint64_t digest = 0;
    ChunkContent content;
  };
  using Place = std::pair<ChunkPart, std::size_t>;
  struct Object {
    std::uint64_t heard = 0;     // count of samples when it was last heard of
    Header whole;                // the last; at first none
    std::deque<Header> waiting;  // in the order in which they came
    std::map<Place, std::deque<Version>> chunks;  // that came since; the newest at the end
    std::size_t octets = 0;                       // of these
    std::size_t octets_with_whole() const;
  };

  Object& hear(const std::string& object_id);
  static const ChunkContent* find(const Object& object, const Place& place, std::uint64_t digest);
  static void count_missing(Object& object);
  static Whole complete(Object& object);
  static void assemble(const Object& object, Header& header);
  static void drop_what_came_before(Object& object);

  std::map<std::string, Object> objects_;
  std::uint64_t samples_ = 0;
};

}  // namespace periplus::wire

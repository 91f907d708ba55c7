#include "common/wire/object_assembler.h"

#include <algorithm>

#include "common/core/error.h"
#include "common/wire/common_wire.h"

namespace periplus::wire {

namespace {

// Calls visit(place, digest) for each chunk of a revision.
template <class Visit>
void for_each_chunk(const msg::ObjectRevision& m, Visit&& visit) {
  for (std::size_t n = 0; n < m.voxel_chunks().size(); ++n) visit(std::pair(ChunkPart::voxels, n), m.voxel_chunks()[n]);
  for (std::size_t n = 0; n < m.landmark_chunks().size(); ++n) visit(std::pair(ChunkPart::landmarks, n), m.landmark_chunks()[n]);
}

// True if that chunk of a revision has that digest.
bool names(const msg::ObjectRevision& m, const std::pair<ChunkPart, std::size_t>& place, std::uint64_t digest) {
  const auto& digests = place.first == ChunkPart::voxels ? m.voxel_chunks() : m.landmark_chunks();
  return place.second < digests.size() && digests[place.second] == digest;
}

voxel::GridGeometry geometry_of(const msg::ObjectRevision& m) {
  require(m.nx() <= 512 && m.ny() <= 512 && m.nz() <= 512, ErrorCode::bad_size, "a grid has at most 512 voxels along each axis");
  voxel::GridGeometry g;
  g.X_WG = from_wire(m.pose_world_grid());
  g.voxel_size = m.voxel_m();
  g.size = Eigen::Vector3i(static_cast<int>(m.nx()), static_cast<int>(m.ny()), static_cast<int>(m.nz()));
  g.check();
  return g;
}

// Checked; without grid and landmarks.
std::shared_ptr<KnownObject> object_of(const msg::ObjectRevision& m) {
  auto object = std::make_shared<KnownObject>();
  object->object_id = id_from_wire(m.object_id(), "the object's id");
  object->revision = m.revision();
  const std::size_t chunks = voxel_chunk_count(geometry_of(m));
  require(m.voxel_chunks().size() == chunks, ErrorCode::bad_size,
          "a grid of this size has " + std::to_string(chunks) + " chunks, not " + std::to_string(m.voxel_chunks().size()));
  require(m.landmark_chunks().size() <= kMostLandmarkChunks, ErrorCode::bad_size,
          "an object has at most " + std::to_string(kMostLandmarkChunks) + " chunks of landmarks");
  require(m.views().size() <= kViewsOnWire, ErrorCode::bad_size, "an object takes at most " + std::to_string(kViewsOnWire) + " views");
  object->views.reserve(m.views().size());
  for (const msg::Pose& X_WC : m.views()) object->views.push_back(from_wire(X_WC));
  return object;
}

}  // namespace

std::size_t ObjectAssembler::Object::octets_with_whole() const {
  if (!whole.object) return octets;
  return octets + 3 * sizeof(std::uint64_t) * whole.object->grid->occupied().size() + sizeof(object_model::Landmark) * whole.object->landmarks.size();
}

ObjectAssembler::Object& ObjectAssembler::hear(const std::string& object_id) {
  Object& object = objects_[object_id];
  object.heard = ++samples_;
  std::size_t octets = 0;
  for (const auto& [id, o] : objects_) octets += o.octets_with_whole();
  while (objects_.size() > 1 && (objects_.size() > kObjects || octets > kMostOctets)) {
    const auto last = std::min_element(objects_.begin(), objects_.end(), [](const auto& a, const auto& b) { return a.second.heard < b.second.heard; });
    octets -= last->second.octets_with_whole();
    objects_.erase(last);
  }
  return object;
}

// Null if it did not come since the last whole revision.
const ChunkContent* ObjectAssembler::find(const Object& object, const Place& place, std::uint64_t digest) {
  const auto at = object.chunks.find(place);
  if (at == object.chunks.end()) return nullptr;
  const auto version = std::find_if(at->second.begin(), at->second.end(), [&](const Version& v) { return v.digest == digest; });
  return version == at->second.end() ? nullptr : &version->content;
}

void ObjectAssembler::count_missing(Object& object) {
  for (Header& header : object.waiting) {
    header.missing = 0;
    for_each_chunk(header.message, [&](const Place& place, std::uint64_t digest) {
      header.missing += !names(object.whole.message, place, digest) && !find(object, place, digest);
    });
  }
}

ObjectAssembler::Whole ObjectAssembler::take(const msg::ObjectRevision& m) {
  const auto fresh = object_of(m);
  Object& object = hear(fresh->object_id);
  if (object.whole.object && object.whole.message == m) return {object.whole.object};
  object.waiting.push_back({.message = m, .object = fresh});
  if (object.waiting.size() > kRevisions) object.waiting.pop_front();
  count_missing(object);
  return complete(object);
}

ObjectAssembler::Whole ObjectAssembler::take(const msg::ObjectChunk& m) {
  const std::string object_id = id_from_wire(m.object_id(), "the object's id");
  ChunkContent content = content_from_wire(m);
  Object& object = hear(object_id);
  const Place place(content.part, m.index());
  std::deque<Version>& versions = object.chunks[place];
  const bool in_whole = names(object.whole.message, place, m.digest());
  if (in_whole && versions.empty() && object.waiting.empty()) return {};  // as it is already, and stays
  const auto same = std::find_if(versions.begin(), versions.end(), [&](const Version& v) { return v.digest == m.digest(); });
  if (same != versions.end()) {
    std::rotate(same, same + 1, versions.end());
    return {};
  }
  object.octets += content.octets();
  versions.push_back({m.digest(), std::move(content)});
  if (!in_whole)
    for (Header& header : object.waiting) header.missing -= names(header.message, place, m.digest());
  if (versions.size() > kVersions) {
    object.octets -= versions.front().content.octets();
    versions.pop_front();
    count_missing(object);
  }
  Whole whole = complete(object);
  if (whole.empty() && object.octets > kMostWaiting) {
    object.chunks.clear();
    object.octets = 0;
    count_missing(object);
    throw Error(ErrorCode::bad_size, "over 128 MiB of chunks of object " + object_id +
                                         " wait for a revision that names them; they are dropped: have it published again with model/publish");
  }
  return whole;
}

ObjectAssembler::Whole ObjectAssembler::complete(Object& object) {
  Whole whole;
  for (;;) {
    const auto next = std::find_if(object.waiting.begin(), object.waiting.end(), [](const Header& h) { return h.missing == 0; });
    if (next == object.waiting.end()) return whole;
    assemble(object, *next);
    object.whole = std::move(*next);
    object.waiting.erase(object.waiting.begin(), next + 1);
    whole.push_back(object.whole.object);
    drop_what_came_before(object);
    count_missing(object);
  }
}

// From the chunks that came, and those of the last whole revision where that has them.
void ObjectAssembler::assemble(const Object& object, Header& header) {
  auto grid = std::make_shared<voxel::OccupancyGrid>(geometry_of(header.message));
  grid->revision = header.object->revision;
  std::vector<object_model::Landmark>& landmarks = header.object->landmarks;
  const Header& old = object.whole;
  for_each_chunk(header.message, [&](const Place& place, std::uint64_t digest) {
    const ChunkContent* fresh = find(object, place, digest);
    if (place.first == ChunkPart::voxels) {
      write_chunk(fresh ? fresh->voxels[0] : read_chunk(*old.object->grid, place.second), place.second, *grid);
      return;
    }
    if (fresh) {
      landmarks.insert(landmarks.end(), fresh->landmarks.begin(), fresh->landmarks.end());
    } else {
      const auto begin = old.object->landmarks.begin();
      const std::size_t first = place.second ? old.landmark_ends[place.second - 1] : 0;
      landmarks.insert(landmarks.end(), begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(old.landmark_ends[place.second]));
    }
    header.landmark_ends.push_back(landmarks.size());
  });
  // Clears what contradicts itself or lies beyond the grid.
  grid->adopt(std::move(grid->occupied()), std::move(grid->known()), std::move(grid->environment()));
  header.object->grid = std::move(grid);
}

// Of each place what came up to the chunk that is in the whole revision now, unless another revision waits for it.
void ObjectAssembler::drop_what_came_before(Object& object) {
  object.octets = 0;
  for (auto at = object.chunks.begin(); at != object.chunks.end();) {
    std::deque<Version>& versions = at->second;
    const auto used = std::find_if(versions.begin(), versions.end(), [&](const Version& v) { return names(object.whole.message, at->first, v.digest); });
    std::size_t before = used == versions.end() ? 0 : static_cast<std::size_t>(used - versions.begin()) + 1;
    std::erase_if(versions, [&](const Version& v) {
      if (before == 0) return false;
      --before;
      return std::none_of(object.waiting.begin(), object.waiting.end(), [&](const Header& h) { return names(h.message, at->first, v.digest); });
    });
    for (const Version& v : versions) object.octets += v.content.octets();
    at = versions.empty() ? object.chunks.erase(at) : std::next(at);
  }
}

}  // namespace periplus::wire

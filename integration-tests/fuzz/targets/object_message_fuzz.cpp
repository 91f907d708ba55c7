// Objects on the wire. The first octet says what the others are: R a revision, C a chunk, as they come off the wire (CDR, with its
// encapsulation); S a script of chunks and revisions that hold what they claim, in any order.
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>

#include "common/dds/codec_impl.h"
#include "common/wire/object_assembler.h"
#include "integration-tests/fuzz/expected_refusal.h"

using namespace periplus;

namespace {

using Whole = wire::ObjectAssembler::Whole;
using Versions = std::vector<std::uint8_t>;

template <class Message>
void off_the_wire(const std::uint8_t* data, std::size_t size) {
  Message message;
  if (!dds::codec<Message>().decode(data, size, &message)) return;
  wire::ObjectAssembler assembler;
  const auto whole = fuzz::result_or_refusal([&] { return assembler.take(message); });
  if (whole && !whole->empty()) fuzz::finding("one sample alone is a whole object");
}

// Octets one after the other; zeros where the input has ended.
class Octets {
 public:
  Octets(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  bool empty() const { return left_ == 0; }
  std::uint8_t next() { return left_ == 0 ? std::uint8_t{0} : (--left_, *data_++); }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

// A chunk's version is its first word, or where its landmarks lie and how many there are.
std::size_t landmarks_in(std::uint8_t version) { return 1 + version % 3; }

// As the splitter makes it, once for each version.
const msg::ObjectChunk& chunk_of(wire::ChunkPart part, std::uint8_t version) {
  static std::array<std::optional<msg::ObjectChunk>, 512> made;
  std::optional<msg::ObjectChunk>& chunk = made[2 * static_cast<std::size_t>(version) + static_cast<std::size_t>(part)];
  if (chunk) return *chunk;
  voxel::GridGeometry g;
  g.voxel_size = 0.01;
  g.size = {8, 8, 8};
  voxel::OccupancyGrid grid(g);
  std::fill(grid.occupied().begin(), grid.occupied().end(), 0);
  grid.occupied()[0] = version;
  const std::vector<object_model::Landmark> landmarks(landmarks_in(version), {Eigen::Vector3d(version, 0, 0), Eigen::Vector3d::UnitZ(), 0.01});
  for (const msg::ObjectChunk& m : wire::ObjectSplitter().split("a", grid, landmarks).chunks)
    if (m.part() == static_cast<std::uint8_t>(part)) chunk = m;
  return *chunk;
}

struct Sent {
  std::string object_id;
  Eigen::Vector3i chunks;
  Versions voxels, landmarks;
};

class Script {
 public:
  void run(Octets in) {
    while (!in.empty() && sent_.size() < kMostRevisions) {
      const std::uint8_t what = in.next();
      const std::string object_id(1, static_cast<char>('a' + (what >> 2 & 1)));
      if ((what & 3) == 0) {
        revision(object_id, in);
      } else {
        const std::uint8_t place = in.next();
        chunk(object_id, (what & 3) == 1 ? wire::ChunkPart::landmarks : wire::ChunkPart::voxels, place & 7, in.next());
      }
    }
    // Whatever came before: published again, the newest of each is here.
    std::map<std::string, std::uint32_t> newest;
    for (std::uint32_t n = 0; n < sent_.size(); ++n) newest[sent_[n].object_id] = n;
    for (const auto& [object_id, n] : newest) {
      const Sent sent = sent_[n];
      for (std::size_t i = 0; i < sent.voxels.size(); ++i) chunk(object_id, wire::ChunkPart::voxels, i, sent.voxels[i]);
      for (std::size_t i = 0; i < sent.landmarks.size(); ++i) chunk(object_id, wire::ChunkPart::landmarks, i, sent.landmarks[i]);
      const Whole whole = announce(n);
      if (whole.empty() || whole.back()->revision != n) fuzz::finding("an object that was published again is not here");
    }
  }

 private:
  static constexpr std::size_t kMostRevisions = 200;

  void revision(const std::string& object_id, Octets& in) {
    const std::uint8_t shape = in.next();
    Sent sent{object_id, {1 + (shape & 1), 1 + (shape >> 1 & 1), 1 + (shape >> 2 & 1)}, {}, {}};
    for (int n = sent.chunks.prod(); n > 0; --n) sent.voxels.push_back(in.next());
    for (int n = shape >> 3 & 3; n > 0; --n) sent.landmarks.push_back(in.next());
    sent_.push_back(std::move(sent));
    announce(static_cast<std::uint32_t>(sent_.size() - 1));
  }

  Whole announce(std::uint32_t n) {
    const Sent& sent = sent_[n];
    msg::ObjectRevision m;
    m.object_id(sent.object_id);
    m.revision(n);
    m.pose_world_grid().qw(1);
    m.voxel_m(0.01);
    const Eigen::Vector3i size = 64 * (sent.chunks.array() - 1) + 8;
    m.nx(static_cast<std::uint32_t>(size.x()));
    m.ny(static_cast<std::uint32_t>(size.y()));
    m.nz(static_cast<std::uint32_t>(size.z()));
    for (const std::uint8_t v : sent.voxels) m.voxel_chunks().push_back(chunk_of(wire::ChunkPart::voxels, v).digest());
    for (const std::uint8_t v : sent.landmarks) m.landmark_chunks().push_back(chunk_of(wire::ChunkPart::landmarks, v).digest());
    return checked(fuzz::must_read("a revision", [&] { return assembler_.take(m); }));
  }

  void chunk(const std::string& object_id, wire::ChunkPart part, std::size_t index, std::uint8_t version) {
    msg::ObjectChunk m = chunk_of(part, version);
    m.object_id(object_id);
    m.index(static_cast<std::uint32_t>(index));
    checked(fuzz::must_read("a chunk", [&] { return assembler_.take(m); }));
  }

  // What is given is what its revision named, of no other.
  Whole checked(Whole whole) const {
    for (const auto& object : whole) {
      const Sent& sent = sent_.at(object->revision);
      Versions voxels, landmarks;
      if (object->object_id != sent.object_id || wire::voxel_chunk_count(object->grid->geometry()) != sent.voxels.size()) fuzz::finding("a revision of another object or size");
      for (std::size_t i = 0; i < sent.voxels.size(); ++i) voxels.push_back(static_cast<std::uint8_t>(wire::read_chunk(*object->grid, i)[0]));
      for (const std::uint8_t version : sent.landmarks) landmarks.insert(landmarks.end(), landmarks_in(version), version);
      const bool same = std::equal(landmarks.begin(), landmarks.end(), object->landmarks.begin(), object->landmarks.end(),
                                   [](std::uint8_t version, const object_model::Landmark& l) { return l.p_W.x() == version; });
      if (voxels != sent.voxels || !same) fuzz::finding("revisions are mixed up");
    }
    return whole;
  }

  wire::ObjectAssembler assembler_;
  std::vector<Sent> sent_;  // by revision
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  switch (fuzz::take_kind(data, size)) {
    case 'R': off_the_wire<msg::ObjectRevision>(data, size); break;
    case 'C': off_the_wire<msg::ObjectChunk>(data, size); break;
    case 'S': Script().run({data, size}); break;
    default: break;
  }
  return 0;
}

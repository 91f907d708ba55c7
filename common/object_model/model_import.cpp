#include "common/object_model/model_import.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "common/core/error.h"

namespace periplus::object_model {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are read as they lie in memory");

constexpr std::size_t kMostPoints = std::size_t{1} << 26;
constexpr int kTreeDepth = 16;  // OctoMap's
constexpr int kMostSide = 512;

[[noreturn]] void refuse(const std::string& why) { throw_error(ErrorCode::bad_input, why); }

// The next line without its end; both "\n" and "\r\n" are met.
std::string_view next_line(std::string_view& rest, const char* what) {
  const std::size_t end = rest.find('\n');
  if (end == std::string_view::npos) refuse(std::string(what) + " ends within its header");
  std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::string_view next_word(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) {
    line = {};
    return {};
  }
  const std::size_t end = std::min(line.find_first_of(" \t\r\n", begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

// Names in a message, whatever they hold.
std::string shown(std::string_view word) {
  std::string out;
  for (const char c : word.substr(0, 32)) out += c >= ' ' && c < 127 ? c : '?';
  return "`" + out + "`";
}

template <class T>
T number(std::string_view word, const char* what) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || error != std::errc{} || end != word.data() + word.size()) refuse(std::string(what) + " is not a number: " + shown(word));
  return value;
}

void check_id(const std::string& object_id) {
  require(!object_id.empty() && object_id.size() <= 64, ErrorCode::bad_input, "the object's id must have 1 to 64 characters");
}

// Bounds of whole cells of a lattice about the world's origin.
struct CellBounds {
  std::array<std::int64_t, 3> least{INT64_MAX, INT64_MAX, INT64_MAX}, most{INT64_MIN, INT64_MIN, INT64_MIN};
  void add(int axis, std::int64_t first, std::int64_t last) {
    const auto n = static_cast<std::size_t>(axis);
    least[n] = std::min(least[n], first);
    most[n] = std::max(most[n], last);
  }
};

// An all unknown model that holds the cells.
ModelState state_of(const CellBounds& bounds, double voxel_size, const std::string& object_id) {
  voxel::GridGeometry g;
  g.voxel_size = voxel_size;
  for (int n = 0; n < 3; ++n) {
    const auto axis = static_cast<std::size_t>(n);
    const std::int64_t side = bounds.most[axis] - bounds.least[axis] + 1;
    require(side <= kMostSide, ErrorCode::bad_input,
            "the contents are " + std::to_string(side) + " voxels long, more than 512; use larger voxels or cut out the object");
    g.size[n] = static_cast<int>(side);
    g.X_WG.translation()[n] = static_cast<double>(bounds.least[axis]) * voxel_size;
  }
  g.check();
  ModelState s;
  s.imported = true;
  s.object_id = object_id;
  s.box.size = g.size.cast<double>() * voxel_size;
  s.box.X_WB.translation() = g.X_WG.translation() + s.box.size / 2;
  s.begun_box = s.box;
  s.grid = voxel::OccupancyGrid(g);
  s.known_solids = s.grid.environment();
  s.evidence = Evidence(g);
  s.log_odds = LogOdds(g);
  s.tsdf = Tsdf(g);
  return s;
}

void mark_known(ModelState& s, const Eigen::Vector3i& v) {
  s.grid.set_state(v, voxel::VoxelState::known);
  VoxelEvidence evidence = s.evidence.at(v);
  evidence.points = std::max<std::uint16_t>(evidence.points, static_cast<std::uint16_t>(CarvingSettings{}.known_points));
  s.evidence.set(v, evidence);
}

void check_voxel_size(double voxel_size) {
  require(std::isfinite(voxel_size) && voxel_size >= 1e-4 && voxel_size <= 1, ErrorCode::bad_input, "the voxel size must lie between 0.0001 and 1 m");
}

// OctoMap's own reader descends as deep as a file says; a file of inner nodes alone would end the stack. Each node is two
// octets, two bits a child: 0 unknown, 1 free, 2 occupied, 3 an inner node, whose octets follow in turn.
class BinaryTree {
 public:
  explicit BinaryTree(std::string_view data) : data_(data) {}

  // Calls visit(least cell, cells a side, occupied) for each leaf; the nodes that were met.
  template <class Visit>
  std::uint64_t walk(Visit&& visit) {
    at_ = 0;
    nodes_ = 1;
    descend({-32768, -32768, -32768}, 1 << kTreeDepth, visit);
    require(at_ == data_.size(), ErrorCode::bad_input, "the OctoMap goes on after its tree's end");
    return nodes_;
  }

 private:
  template <class Visit>
  void descend(const std::array<int, 3>& least, int side, Visit& visit) {
    require(side > 1, ErrorCode::bad_input, "the OctoMap's tree is deeper than 16 levels");
    require(data_.size() - at_ >= 2, ErrorCode::bad_input, "the OctoMap ends within its tree");
    const unsigned children = static_cast<unsigned char>(data_[at_]) | static_cast<unsigned>(static_cast<unsigned char>(data_[at_ + 1])) << 8;
    at_ += 2;
    const int half = side / 2;
    for (int child = 0; child < 8; ++child) {
      const unsigned kind = children >> (2 * child) & 3;
      if (kind == 0) continue;
      ++nodes_;
      const std::array<int, 3> corner{least[0] + (child & 1 ? half : 0), least[1] + (child & 2 ? half : 0), least[2] + (child & 4 ? half : 0)};
      if (kind == 3)
        descend(corner, half, visit);
      else
        visit(corner, half, kind == 2);
    }
  }

  std::string_view data_;
  std::size_t at_ = 0;
  std::uint64_t nodes_ = 0;
};

struct Field {
  std::size_t size = 0, count = 1, offset = 0, word = 0;
  char type = 0;
};

struct PcdHeader {
  std::array<Field, 3> position;
  std::size_t record = 0, words = 0, points = 0;
  bool binary = false;
};

// Splits the header off `rest`.
PcdHeader pcd_header(std::string_view& rest) {
  constexpr std::size_t kMostFields = 64, kMostRecord = 65536;
  std::vector<std::string_view> names;
  std::vector<Field> fields;
  std::size_t width = 0, height = 0;
  bool have_size = false, have_type = false, have_width = false, have_height = false, have_points = false;
  PcdHeader header;
  const auto each = [&](std::string_view line, const char* key, auto&& set) {
    if (fields.empty()) refuse(std::string("the cloud's ") + key + " stands before its FIELDS");
    for (Field& field : fields) set(field, next_word(line));
    if (!next_word(line).empty()) refuse(std::string("the cloud's ") + key + " has more entries than there are FIELDS");
  };
  for (int lines = 0;; ++lines) {
    require(lines < 256, ErrorCode::bad_input, "not a point cloud: no DATA within 256 lines");
    std::string_view line = next_line(rest, "the cloud");
    const std::string_view key = next_word(line);
    if (key.empty() || key.front() == '#') continue;
    if (key == "VERSION") {
      const std::string_view version = next_word(line);
      if (version != "0.7" && version != ".7" && version != "0.6" && version != ".6") refuse("the cloud's VERSION must be 0.7 or 0.6, not " + shown(version));
    } else if (key == "FIELDS" || key == "COLUMNS") {
      names.clear();
      for (std::string_view name = next_word(line); !name.empty(); name = next_word(line)) {
        require(names.size() < kMostFields, ErrorCode::bad_input, "the cloud has more than 64 fields");
        names.push_back(name);
      }
      fields.assign(names.size(), {});
    } else if (key == "SIZE") {
      each(line, "SIZE", [](Field& field, std::string_view word) {
        field.size = number<std::size_t>(word, "an entry of the cloud's SIZE");
        require(field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8, ErrorCode::bad_input, "the cloud's SIZE must be 1, 2, 4 or 8 octets");
      });
      have_size = true;
    } else if (key == "TYPE") {
      each(line, "TYPE", [](Field& field, std::string_view word) {
        require(word == "F" || word == "I" || word == "U", ErrorCode::bad_input, "the cloud's TYPE must be F, I or U");
        field.type = word[0];
      });
      have_type = true;
    } else if (key == "COUNT") {
      each(line, "COUNT", [](Field& field, std::string_view word) {
        field.count = number<std::size_t>(word, "an entry of the cloud's COUNT");
        require(field.count >= 1 && field.count <= 4096, ErrorCode::bad_input, "the cloud's COUNT must be 1 to 4096");
      });
    } else if (key == "WIDTH") {
      width = number<std::size_t>(next_word(line), "the cloud's WIDTH");
      have_width = true;
    } else if (key == "HEIGHT") {
      height = number<std::size_t>(next_word(line), "the cloud's HEIGHT");
      have_height = true;
    } else if (key == "POINTS") {
      header.points = number<std::size_t>(next_word(line), "the cloud's POINTS");
      have_points = true;
    } else if (key == "VIEWPOINT") {
      continue;
    } else if (key == "DATA") {
      const std::string_view kind = next_word(line);
      if (kind == "binary_compressed") refuse("compressed clouds are not read; write it as DATA binary (pcl_convert_pcd_ascii_binary in.pcd out.pcd 1)");
      if (kind != "ascii" && kind != "binary") refuse("the cloud's DATA must be ascii or binary, not " + shown(kind));
      header.binary = kind == "binary";
      break;
    } else {
      refuse("not a point cloud, or its header holds what is unknown: " + shown(key));
    }
  }
  require(!fields.empty() && have_size && have_type && have_width && have_height, ErrorCode::bad_input,
          "the cloud's header needs FIELDS, SIZE, TYPE, WIDTH and HEIGHT");
  require(width <= kMostPoints && height <= kMostPoints && width * height <= kMostPoints, ErrorCode::bad_input, "the cloud claims more than 67108864 points");
  if (!have_points) header.points = width * height;
  require(header.points == width * height, ErrorCode::bad_input, "the cloud's POINTS is not WIDTH times HEIGHT");
  require(header.points > 0, ErrorCode::bad_input, "the cloud holds no points");
  unsigned found = 0;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    fields[i].offset = header.record;
    fields[i].word = header.words;
    header.record += fields[i].size * fields[i].count;
    header.words += fields[i].count;
    require(header.record <= kMostRecord, ErrorCode::bad_input, "a point of the cloud takes more than 65536 octets");
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (names[i].size() == 1 && names[i][0] == "xyz"[axis]) {
        require(!(found >> axis & 1), ErrorCode::bad_input, "the cloud has a field twice: " + shown(names[i]));
        require(fields[i].type == 'F' && fields[i].size >= 4 && fields[i].count == 1, ErrorCode::bad_input, "the cloud's x, y and z must be single F of SIZE 4 or 8");
        header.position[axis] = fields[i];
        found |= 1u << axis;
      }
  }
  require(found == 7, ErrorCode::bad_input, "the cloud has no fields x, y and z");
  return header;
}

double coordinate(const char* record, const Field& field) {
  if (field.size == 8) {
    double value;
    std::memcpy(&value, record + field.offset, 8);
    return value;
  }
  float value;
  std::memcpy(&value, record + field.offset, 4);
  return static_cast<double>(value);
}

// Calls visit(point) for each point that is not a gap.
template <class Visit>
void for_each_point(const PcdHeader& header, std::string_view data, Visit&& visit) {
  for (std::size_t i = 0; i < header.points; ++i) {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    if (header.binary) {
      for (int n = 0; n < 3; ++n) p[n] = coordinate(data.data() + i * header.record, header.position[static_cast<std::size_t>(n)]);
    } else {
      for (std::size_t w = 0; w < header.words; ++w) {
        const std::string_view word = next_word(data);
        require(!word.empty(), ErrorCode::bad_input, "the cloud ends before its last point");
        for (std::size_t n = 0; n < 3; ++n)
          if (header.position[n].word == w) p[static_cast<int>(n)] = number<double>(word, "a coordinate of the cloud");
      }
    }
    if (p.array().isNaN().all()) continue;
    require(p.allFinite(), ErrorCode::bad_input, "point " + std::to_string(i) + " of the cloud is not finite");
    visit(p);
  }
  if (!header.binary) require(next_word(data).empty(), ErrorCode::bad_input, "the cloud holds more than its POINTS");
}

}  // namespace

ObjectModel import_bt(std::string_view file, const std::string& object_id) {
  check_id(object_id);
  std::string_view rest = file;
  if (!file.starts_with("# Octomap OcTree binary file")) refuse("not an OctoMap binary tree: it must begin with \"# Octomap OcTree binary file\"; a .ot is written as .bt by convert_octree");
  std::uint64_t nodes = 0;
  double resolution = 0;
  bool have_id = false, have_size = false, have_resolution = false;
  for (int lines = 0;; ++lines) {
    require(lines < 256, ErrorCode::bad_input, "the OctoMap's header has no `data` within 256 lines");
    std::string_view line = next_line(rest, "the OctoMap");
    const std::string_view key = next_word(line);
    if (key.empty() || key.front() == '#') continue;
    if (key == "data") break;
    if (key == "id") {
      const std::string_view id = next_word(line);
      // A .bt has no colours, whatever it was written from.
      if (id != "OcTree" && id != "ColorOcTree") refuse("the OctoMap must be an OcTree, not " + shown(id));
      have_id = true;
    } else if (key == "size") {
      nodes = number<std::uint64_t>(next_word(line), "the OctoMap's size");
      have_size = true;
    } else if (key == "res") {
      resolution = number<double>(next_word(line), "the OctoMap's resolution");
      have_resolution = true;
    } else {
      refuse("the OctoMap's header holds what is unknown: " + shown(key));
    }
  }
  require(have_id && have_size && have_resolution, ErrorCode::bad_input, "the OctoMap's header needs id, size and res");
  check_voxel_size(resolution);
  require(nodes > 0, ErrorCode::bad_input, "the OctoMap is empty");

  BinaryTree tree(rest);
  CellBounds bounds;
  bool any = false;
  const std::uint64_t met = tree.walk([&](const std::array<int, 3>& least, int side, bool) {
    any = true;
    for (int n = 0; n < 3; ++n) bounds.add(n, least[static_cast<std::size_t>(n)], least[static_cast<std::size_t>(n)] + side - 1);
  });
  require(met == nodes, ErrorCode::bad_input, "the OctoMap's tree has " + std::to_string(met) + " nodes, its header says " + std::to_string(nodes));
  require(any, ErrorCode::bad_input, "the OctoMap is empty");
  ModelState s = state_of(bounds, resolution, object_id);
  tree.walk([&](const std::array<int, 3>& least, int side, bool occupied) {
    for (int x = 0; x < side; ++x)
      for (int y = 0; y < side; ++y)
        for (int z = 0; z < side; ++z) {
          const Eigen::Vector3i v(static_cast<int>(least[0] + x - bounds.least[0]), static_cast<int>(least[1] + y - bounds.least[1]),
                                  static_cast<int>(least[2] + z - bounds.least[2]));
          if (occupied)
            mark_known(s, v);
          else
            s.grid.set_state(v, voxel::VoxelState::empty);
        }
  });
  return ObjectModel(std::move(s));
}

ObjectModel import_pcd(std::string_view file, const std::string& object_id, double voxel_size) {
  check_id(object_id);
  check_voxel_size(voxel_size);
  std::string_view data = file;
  const PcdHeader header = pcd_header(data);
  if (header.binary)
    require(data.size() >= header.points * header.record, ErrorCode::bad_input,
            "the cloud claims " + std::to_string(header.points) + " points of " + std::to_string(header.record) + " octets, but ends after " +
                std::to_string(data.size()) + " octets");
  // Beyond this cells are not told apart in double precision.
  constexpr double kFar = 1e6;  // [m]
  const auto cell = [&](double p) { return static_cast<std::int64_t>(std::floor(p / voxel_size)); };
  CellBounds bounds;
  bool any = false;
  for_each_point(header, data, [&](const Eigen::Vector3d& p) {
    require((p.array().abs() <= kFar).all(), ErrorCode::bad_input, "a point of the cloud lies more than 1000 km from the origin: are these metres?");
    any = true;
    for (int n = 0; n < 3; ++n) bounds.add(n, cell(p[n]), cell(p[n]));
  });
  require(any, ErrorCode::bad_input, "the cloud holds no points but gaps");
  ModelState s = state_of(bounds, voxel_size, object_id);
  for_each_point(header, data, [&](const Eigen::Vector3d& p) {
    Eigen::Vector3i v;
    for (int n = 0; n < 3; ++n) v[n] = static_cast<int>(cell(p[n]) - bounds.least[static_cast<std::size_t>(n)]);
    mark_known(s, v);
  });
  return ObjectModel(std::move(s));
}

}  // namespace periplus::object_model

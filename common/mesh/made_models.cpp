#include "common/mesh/made_models.h"

#include <array>
#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/mesh/assets.h"
#include "common/mesh/part_builder.h"

namespace periplus::mesh {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr std::string_view kPrefix = "made:";

double smooth(double t) { return t * t * (3 - 2 * t); }

// A box that stands upright, turned by `yaw`, by the middle of its lower face.
void stand(PartBuilder& b, const Vector3d& foot, const Vector3d& size, double piece, Material material, double yaw = 0) {
  b.box(make_pose(foot + Vector3d(0, 0, size.z() / 2), rotation_from_yaw_pitch_roll(yaw, 0, 0)), size, piece, material);
}

// A sail that fills towards the bow: between two yards of the given half widths.
void square_sail(PartBuilder& b, double x, double z_low, double z_high, double half_low, double half_high, double belly) {
  constexpr int kRows = 8, kColumns = 10;
  std::vector<Points> front;
  for (int i = 0; i <= kRows; ++i) {
    const double t = static_cast<double>(i) / kRows, half = half_low + t * (half_high - half_low);
    Points row;
    for (int j = 0; j <= kColumns; ++j) {
      const double s = 2.0 * j / kColumns - 1;
      row.emplace_back(x + belly * (1 - s * s) * std::sin(std::numbers::pi * (0.15 + 0.75 * t)), -half * s, z_low + t * (z_high - z_low));
    }
    front.push_back(row);
  }
  b.sheet(front, 0.004, Material::canvas);
}

// A three-cornered sail along the ship: from its tack over the head to the clew, in the plane y = 0, bulging to one side.
void stay_sail(PartBuilder& b, const Vector3d& tack, const Vector3d& head, const Vector3d& clew, double belly) {
  constexpr int kRows = 8, kColumns = 6;
  std::vector<Points> front;
  for (int i = 0; i <= kRows; ++i) {
    const double t = 0.94 * i / kRows;
    const Vector3d from = tack + t * (head - tack), to = clew + t * (head - clew);
    Points row;
    for (int j = 0; j <= kColumns; ++j) {
      const double s = static_cast<double>(j) / kColumns;
      row.push_back(from + s * (to - from) + Vector3d(0, belly * 4 * s * (1 - s) * (1 - t), 0));
    }
    front.push_back(row);
  }
  b.sheet(front, 0.004, Material::canvas);
}

}  // namespace

bool is_made(std::string_view name) { return name.starts_with(kPrefix); }

TriangleMesh make_ship() {
  PartBuilder b(1.0);
  // Hull: sections from the stern (x = -0.18) to the bow (0.19); the keel lies at 0.03 above the table.
  constexpr int kSections = 26, kSide = 9;
  const auto half_beam = [](double t) { return 0.058 * std::pow(std::sin(std::numbers::pi * (0.22 + 0.775 * t)), 0.75); };
  const auto deck = [](double t) { return 0.118 + 0.045 * std::pow(2 * t - 0.9, 2); };
  std::vector<Points> sections;
  for (int i = 0; i <= kSections; ++i) {
    const double t = static_cast<double>(i) / kSections, x = -0.18 + 0.37 * t;
    const double keel = 0.03 + 0.06 * std::pow(std::max(0.0, (t - 0.72) / 0.28), 2) + 0.02 * std::pow(std::max(0.0, (0.2 - t) / 0.2), 2);
    const double top = deck(t), beam = std::max(0.004, half_beam(t));
    Points ring;  // counter-clockwise seen from the bow: deck to starboard (-y) side down, keel, port up
    for (int k = -kSide; k <= kSide; ++k) {
      const double a = static_cast<double>(k) / kSide, side = std::abs(a);
      ring.emplace_back(x, (a < 0 ? -1 : 1) * beam * std::pow(side, 0.45), keel + (top - keel) * std::pow(side, 2.2));
    }
    for (int k = 1; k < 8; ++k) ring.emplace_back(x, beam * (1 - 2 * k / 8.0), top);
    sections.push_back(ring);
  }
  b.loft(sections, Material::dark_wood);
  // Decks fore and aft, cabin, hatch, rudder, cradle.
  b.box(make_pose({-0.135, 0, 0.158}, Eigen::Matrix3d::Identity()), {0.085, 0.086, 0.040}, 0.03, Material::planks);
  b.box(make_pose({-0.155, 0, 0.188}, Eigen::Matrix3d::Identity()), {0.045, 0.072, 0.024}, 0.03, Material::paint);
  b.box(make_pose({0.125, 0, 0.146}, Eigen::Matrix3d::Identity()), {0.060, 0.058, 0.026}, 0.03, Material::planks);
  b.box(make_pose({-0.045, 0, 0.127}, Eigen::Matrix3d::Identity()), {0.035, 0.030, 0.020}, 0.03, Material::paint);
  b.box(make_pose({-0.185, 0, 0.085}, Eigen::Matrix3d::Identity()), {0.020, 0.008, 0.090}, 0.03, Material::dark_wood);
  for (const double x : {-0.09, 0.08}) b.box(make_pose({x, 0, 0.025}, Eigen::Matrix3d::Identity()), {0.022, 0.095, 0.050}, 0.03, Material::paint);
  // Masts with tops, yards and sails.
  struct Mast {
    double x, top;
    std::array<double, 3> yards, half;  // heights and half widths of the yards
  };
  for (const Mast& m : {Mast{0.100, 0.395, {0.190, 0.280, 0.365}, {0.075, 0.062, 0.045}}, Mast{0.000, 0.440, {0.190, 0.300, 0.405}, {0.085, 0.070, 0.048}}}) {
    b.tube({m.x, 0, 0.10}, {m.x, 0, m.top}, 0.008, 0.005, 12, Material::dark_wood);
    b.tube({m.x, 0, m.yards[1] + 0.010}, {m.x, 0, m.yards[1] + 0.018}, 0.018, 0.018, 12, Material::planks);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d p(m.x + 0.011, 0, m.yards[k]), half(0, m.half[k], 0);
      b.tube(p - half, p + half, 0.005, 0.005, 10, Material::dark_wood);
    }
    for (std::size_t k = 0; k < 2; ++k)
      square_sail(b, m.x + 0.013, m.yards[k] + 0.004, m.yards[k + 1] - 0.004, m.half[k] - 0.006, m.half[k + 1] - 0.004, 0.022);
  }
  b.tube({-0.105, 0, 0.10}, {-0.105, 0, 0.36}, 0.007, 0.004, 12, Material::dark_wood);
  b.tube({-0.105, 0, 0.215}, {-0.215, 0, 0.235}, 0.005, 0.004, 10, Material::dark_wood);
  stay_sail(b, {-0.110, 0, 0.225}, {-0.110, 0, 0.345}, {-0.205, 0, 0.243}, 0.012);
  b.tube({0.165, 0, 0.150}, {0.285, 0, 0.205}, 0.007, 0.004, 12, Material::dark_wood);
  stay_sail(b, {0.272, 0, 0.206}, {0.112, 0, 0.365}, {0.150, 0, 0.195}, 0.012);
  // Pennant on the main mast.
  b.box(make_pose({-0.022, 0, 0.428}, Eigen::Matrix3d::Identity()), {0.044, 0.004, 0.016}, 0.03, Material::paint);
  return b.mesh();
}

TriangleMesh make_statue() {
  PartBuilder b(2.0);
  stand(b, {0, 0, 0}, {0.62, 0.62, 0.12}, 0.1, Material::stone);
  stand(b, {0, 0, 0.11}, {0.52, 0.52, 0.16}, 0.1, Material::stone);
  // Body: a trefoil that turns by 150 degrees on its way up; narrow at the waist, wide at the shoulders.
  constexpr int kRings = 40, kSides = 60;
  std::vector<Points> rings;
  for (int i = 0; i <= kRings; ++i) {
    const double t = static_cast<double>(i) / kRings, z = 0.26 + 1.06 * t;
    const double radius = 0.215 - 0.055 * std::sin(std::numbers::pi * std::min(1.0, t / 0.75)) + 0.03 * std::sin(std::numbers::pi * t) - 0.11 * smooth(std::max(0.0, (t - 0.82) / 0.18));
    Points ring;
    for (int j = 0; j < kSides; ++j) {
      const double a = kFullTurn * j / kSides, r = radius * (1 + 0.24 * std::cos(3 * a));
      const double turned = a + t * 150 * std::numbers::pi / 180;
      ring.emplace_back(r * std::cos(turned), r * std::sin(turned), z);
    }
    rings.push_back(ring);
  }
  b.loft(rings, Material::stone);
  // Two rings for arms, leaning outwards.
  for (const double side : {-1.0, 1.0}) {
    constexpr int kPieces = 36;
    Points line;
    for (int k = 0; k < kPieces; ++k) {
      const double a = kFullTurn * k / kPieces;
      line.emplace_back(0.06 * std::sin(a), side * (0.235 + 0.165 * std::cos(a)), 0.98 + 0.23 * std::sin(a));
    }
    b.tube(line, std::vector<double>(kPieces, 0.042), 16, Material::bronze, true);
  }
  // Neck, head with a brow and a nose, collar, spire with a hoop.
  b.tube({0, 0, 1.28}, {0, 0, 1.44}, 0.085, 0.07, 24, Material::stone);
  b.lump({0, 0, 1.57}, {0.135, 0.12, 0.17}, 0.06, 3, Material::stone);
  b.box(make_pose({0.105, 0, 1.62}, rotation_from_yaw_pitch_roll(0, 0.2, 0)), {0.07, 0.17, 0.035}, 0.1, Material::stone);
  b.tube({0.11, 0, 1.60}, {0.165, 0, 1.52}, 0.015, 0.028, 12, Material::stone);
  Points hoop;
  for (int k = 0; k < 36; ++k) hoop.emplace_back(0.165 * std::cos(kFullTurn * k / 36), 0.165 * std::sin(kFullTurn * k / 36), 1.76 + 0.03 * std::sin(kFullTurn * k / 36));
  b.tube(hoop, std::vector<double>(36, 0.026), 12, Material::bronze, true);
  for (int k = 0; k < 3; ++k) {
    const double a = kFullTurn * k / 3;
    b.tube({0.165 * std::cos(a), 0.165 * std::sin(a), 1.76}, {0.02 * std::cos(a), 0.02 * std::sin(a), 1.70}, 0.016, 0.016, 10, Material::bronze);
  }
  b.tube({0, 0, 1.70}, {0, 0, 2.0}, 0.045, 0.02, 16, Material::bronze);
  return b.mesh();
}

TriangleMesh make_treehouse() {
  PartBuilder b(2.0);
  constexpr double kTrunk = -0.16;  // where it stands along x: within the hut
  // Trunk with a flare and roots; it goes on through platform and hut.
  Points line;
  std::vector<double> radii;
  for (int i = 0; i <= 20; ++i) {
    const double t = i / 20.0, z = 2.65 * t;
    line.emplace_back(kTrunk + 0.03 * std::sin(2.2 * t), 0.03 * std::sin(4 * t), z);
    radii.push_back(0.155 - 0.06 * t + 0.09 * std::exp(-z / 0.16));
  }
  b.tube(line, radii, 28, Material::bark);
  for (int k = 0; k < 4; ++k) {
    const double a = 0.5 + kFullTurn * k / 4;
    const Vector3d out(std::cos(a), std::sin(a), 0);
    b.tube(Vector3d(kTrunk, 0, 0.20) + 0.10 * out, Vector3d(kTrunk, 0, 0.035) + 0.36 * out, 0.075, 0.033, 12, Material::bark);
  }
  // Platform with beams and struts.
  stand(b, {-0.03, 0, 1.10}, {0.98, 0.90, 0.06}, 0.1, Material::planks);
  for (const double y : {-0.3, 0.3}) stand(b, {-0.03, y, 1.03}, {0.94, 0.07, 0.08}, 0.1, Material::dark_wood);
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) b.tube({kTrunk + 0.08 * x, 0.07 * y, 0.58}, {-0.03 + 0.36 * x, 0.3 * y, 1.06}, 0.035, 0.035, 12, Material::dark_wood);
  // Hut: its core, and walls around that leave door and window open 7 cm deep.
  constexpr double kFloor = 1.15, kWall = 0.62, x0 = -0.5, x1 = 0.14;  // the hut stands at the back; the veranda in front (+x)
  const double cx = (x0 + x1) / 2, sx = x1 - x0;
  stand(b, {cx - 0.035, 0, kFloor}, {sx - 0.07 - 0.07, 0.80 - 0.14, kWall}, 0.1, Material::dark_wood);
  const auto wall = [&](double ax, double bx, double ay, double by, double az, double bz) {
    stand(b, {(ax + bx) / 2, (ay + by) / 2, kFloor + az}, {bx - ax, by - ay, bz - az}, 0.1, Material::planks);
  };
  wall(x1 - 0.08, x1, -0.40, -0.05, 0, kWall);           // front, right of the door
  wall(x1 - 0.08, x1, 0.23, 0.40, 0, kWall);             // left of it
  wall(x1 - 0.08, x1, -0.06, 0.24, 0.50, kWall);         // above
  wall(x0, x1 - 0.075, 0.33, 0.40, 0, 0.22);             // left, below the window
  wall(x0, x1 - 0.075, 0.33, 0.40, 0.48, kWall);         // above
  wall(x0, x0 + 0.18, 0.33, 0.40, 0.21, 0.49);           // behind
  wall(x1 - 0.26, x1 - 0.075, 0.33, 0.40, 0.21, 0.49);   // before
  wall(x0, x1 - 0.075, -0.40, -0.33, 0, kWall);          // right
  wall(x0, x0 + 0.07, -0.335, 0.335, 0, kWall);          // back
  // Gable roof, its ridge along x.
  {
    const double eave = 0.52, low = kFloor + kWall - 0.06, high = kFloor + kWall + 0.32;
    for (const double side : {-1.0, 1.0}) {
      const double pitch = std::atan2(high - low, eave), length = std::hypot(high - low, eave) + 0.03;
      b.box(make_pose({cx + 0.02, side * (eave / 2 - 0.01), (low + high) / 2}, rotation_from_yaw_pitch_roll(0, 0, -side * pitch)), {sx + 0.24, length, 0.045}, 0.1, Material::paint);
    }
    const auto gable = [&](double x) {
      return Points{{x, -0.36, kFloor + kWall - 0.02}, {x, 0, kFloor + kWall - 0.02}, {x, 0.36, kFloor + kWall - 0.02}, {x, 0.18, kFloor + kWall + 0.12}, {x, 0, kFloor + kWall + 0.26}, {x, -0.18, kFloor + kWall + 0.12}};
    };
    std::vector<Points> rings;
    for (int i = 0; i <= 6; ++i) rings.push_back(gable(x0 + 0.02 + (sx - 0.04) * i / 6));
    b.loft(rings, Material::planks);
  }
  // Railing around the veranda, ladder at its front.
  const double rail = 1.40;
  for (const double y : {-0.42, 0.42}) {
    for (const double x : {0.19, 0.43}) stand(b, {x, y, 1.15}, {0.045, 0.045, rail - 1.15}, 0.1, Material::dark_wood);
    b.box(make_pose({0.31, y, rail}, Eigen::Matrix3d::Identity()), {0.30, 0.05, 0.045}, 0.1, Material::planks);
  }
  for (const double y : {-0.335, 0.22}) b.box(make_pose({0.43, y, rail}, rotation_from_yaw_pitch_roll(std::numbers::pi / 2, 0, 0)), {y < 0 ? 0.21 : 0.44, 0.05, 0.045}, 0.1, Material::planks);
  for (const double y : {-0.25, 0.02}) stand(b, {0.43, y, 1.15}, {0.045, 0.045, rail - 1.15}, 0.1, Material::dark_wood);
  for (const double y : {-0.25, 0.02}) b.tube({0.66, y, 0.0}, {0.45, y, 1.18}, 0.028, 0.028, 12, Material::planks);
  for (int k = 1; k <= 4; ++k) {
    const double t = k / 5.0;
    const Vector3d p(0.66 - 0.21 * t, -0.115, 1.18 * t);
    b.tube(p - Vector3d(0, 0.15, 0), p + Vector3d(0, 0.15, 0), 0.022, 0.022, 10, Material::planks);
  }
  // Crown.
  b.lump({0.02, 0.02, 2.62}, {0.40, 0.42, 0.37}, 0.25, 11, Material::leaves);
  b.lump({0.28, -0.22, 2.45}, {0.30, 0.28, 0.24}, 0.25, 12, Material::leaves);
  b.lump({-0.30, 0.20, 2.48}, {0.30, 0.30, 0.24}, 0.25, 13, Material::leaves);
  b.lump({0.20, 0.30, 2.42}, {0.26, 0.26, 0.21}, 0.25, 14, Material::leaves);
  b.lump({-0.24, -0.26, 2.44}, {0.27, 0.27, 0.22}, 0.25, 15, Material::leaves);
  return b.mesh();
}

namespace {

struct Made {
  const char* name;
  TriangleMesh (*make)();
};
constexpr Made kMade[] = {{"made:ship", make_ship}, {"made:statue", make_statue}, {"made:treehouse", make_treehouse}};

}  // namespace

const std::vector<std::string>& made_models() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Made& m : kMade) all.emplace_back(m.name);
    return all;
  }();
  return names;
}

TriangleMesh make_model(std::string_view name) {
  for (const Made& m : kMade)
    if (name == m.name) return m.make();
  std::string all;
  for (const std::string& n : made_models()) all += (all.empty() ? "" : ", ") + n;
  throw_error(ErrorCode::bad_input, std::string(name) + ": there is no such model; there are " + all);
}

TriangleMesh load_named(const std::string& name, const std::vector<std::string>& folders, std::string& path) {
  path = is_made(name) ? name : find_asset(name, folders);
  return is_made(name) ? make_model(name) : load(path);
}

}  // namespace periplus::mesh

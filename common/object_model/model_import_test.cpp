#include "common/object_model/model_import.h"

#include <gtest/gtest.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/object_model/model_export.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model {
namespace {

using namespace testing;

// A grid whose voxels lie on the lattice of the files.
ObjectModel aligned_model() {
  ObjectBox box = box_around({});
  box.size = {0.48, 0.56, 0.4};
  ObjectModel model("ball", box, 0.02, {});
  for (int n = 0; n < 4; ++n) model.integrate(ideal_view({}, n, 4), {}, {});
  return model;
}

std::string refusal(auto&& read) {
  try {
    read();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input) << error.what();
    return error.what();
  }
  return "";
}
std::string refusal_of_bt(const std::string& file) {
  return refusal([&] { import_bt(file, "thing"); });
}
std::string refusal_of_pcd(const std::string& file, double voxel_size = 0.01) {
  return refusal([&] { import_pcd(file, "thing", voxel_size); });
}

TEST(ModelImport, AnOctoMapComesBackAsTheGridWas) {
  const ObjectModel model = aligned_model();
  const std::string file = export_bt(model);
  const ObjectModel back = import_bt(file, "ball");
  EXPECT_EQ(back.state().object_id, "ball");
  EXPECT_DOUBLE_EQ(back.grid().geometry().voxel_size, 0.02);
  const voxel::GridGeometry& g = model.grid().geometry();
  int known = 0, empty = 0;
  for_each_voxel(g, [&](const Eigen::Vector3i& v) {
    const voxel::GridGeometry& h = back.grid().geometry();
    const Eigen::Vector3i w = h.voxel_of(g.center_world(v));
    // What is unknown at the rim lies beyond the bounds of the file's leaves.
    const voxel::VoxelState read = h.contains(w) ? back.grid().state(w) : voxel::VoxelState::unknown;
    ASSERT_EQ(read, model.grid().state(v)) << v.transpose();
    known += read == voxel::VoxelState::known;
    empty += read == voxel::VoxelState::empty;
  });
  EXPECT_GT(known, 200);
  EXPECT_GT(empty, 1000);
  EXPECT_EQ(export_bt(back), file);
}

TEST(ModelImport, ReadsWhatOctoMapPrunesAndWrites) {
  octomap::OcTree tree(0.05);
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; ++z)
        tree.updateNode(octomap::OcTreeKey(static_cast<octomap::key_type>(32760 + x), static_cast<octomap::key_type>(32768 + y), static_cast<octomap::key_type>(32768 + z)), true);
  tree.updateNode(octomap::point3d(0.43f, 0.03f, 0.03f), false);
  std::ostringstream out;
  ASSERT_TRUE(tree.writeBinary(out));
  const ObjectModel model = import_bt(out.str(), "block");
  EXPECT_EQ(model.grid().geometry().size, Eigen::Vector3i(17, 8, 8));
  EXPECT_TRUE(model.grid().geometry().X_WG.translation().isApprox(Eigen::Vector3d(-0.4, 0, 0)));
  const voxel::Counts counts = model.grid().counts();
  EXPECT_EQ(counts.known, 512u);
  EXPECT_EQ(counts.empty, 1u);
  EXPECT_EQ(model.grid().state({16, 0, 0}), voxel::VoxelState::empty);

  // What convert_octree makes of a .ot with colours.
  octomap::ColorOcTree coloured(0.05);
  coloured.updateNode(octomap::point3d(0.03f, 0.03f, 0.03f), true);
  std::ostringstream converted;
  ASSERT_TRUE(coloured.writeBinary(converted));
  EXPECT_EQ(import_bt(converted.str(), "coloured").grid().counts().known, 1u);
}

TEST(ModelImport, ACloudComesBackAsTheKnownVoxels) {
  const ObjectModel model = aligned_model();
  const ObjectModel back = import_pcd(export_model(model, "pcd"), "ball", 0.02);
  EXPECT_EQ(back.grid().counts().known, model.grid().counts().known);
  EXPECT_EQ(back.grid().counts().empty, 0u);
  for_each_voxel(back.grid().geometry(), [&](const Eigen::Vector3i& v) {
    const Eigen::Vector3d p = back.grid().geometry().center_world(v);
    const voxel::VoxelState there = model.grid().state(model.grid().geometry().voxel_of(p));
    ASSERT_EQ(back.grid().state(v) == voxel::VoxelState::known, there == voxel::VoxelState::known);
  });
}

constexpr const char* kAscii =
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS intensity z x y\nSIZE 4 4 4 8\nTYPE F F F F\nCOUNT 2 1 1 1\nWIDTH 3\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n1 2 0.305 0.105 -0.205\n1 2 nan nan nan\r\n0 0 0.325 0.115 -0.205\n";

TEST(ModelImport, ReadsCloudsAsTextInAnyOrderOfFields) {
  const ObjectModel model = import_pcd(kAscii, "cup", 0.01);
  EXPECT_EQ(model.grid().geometry().size, Eigen::Vector3i(2, 1, 3));
  EXPECT_EQ(model.grid().counts().known, 2u);
  EXPECT_EQ(model.grid().state(model.grid().geometry().voxel_of({0.115, -0.205, 0.325})), voxel::VoxelState::known);
  EXPECT_TRUE(model.is_measured({0, 0, 0}));
}

TEST(ModelImport, AModelOfAnotherProgramGoesOnLearning) {
  ObjectModel model = import_bt(export_bt(aligned_model()), "ball");
  const std::uint64_t known = model.grid().counts().known;
  model.integrate(ideal_view({}, 1, 4), {}, {});
  EXPECT_GE(model.grid().counts().known + 50, known);
  EXPECT_EQ(model.state().views.size(), 1u);
}

TEST(ModelImport, SaysWhatIsWrongWithACloud) {
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = kAscii;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  const std::pair<std::string, const char*> cases[] = {
      {"", "ends within its header"},
      {"ply\n", "holds what is unknown"},
      {with("VERSION 0.7", "VERSION 9"), "VERSION"},
      {with("DATA ascii", "DATA binary_compressed"), "compressed"},
      {with("DATA ascii", "DATA text"), "ascii or binary"},
      {with("POINTS 3", "POINTS 4"), "WIDTH times HEIGHT"},
      {with("WIDTH 3", "WIDTH 4000000000"), "67108864"},
      {with("WIDTH 3", "WIDTH -3"), "not a number"},
      {with("WIDTH 3\n", ""), "needs FIELDS"},
      {with("FIELDS intensity z x y", "FIELDS intensity z x w"), "no fields x, y and z"},
      {with("FIELDS intensity z x y", "FIELDS intensity x x y"), "twice"},
      {with("TYPE F F F F", "TYPE F F I F"), "single F"},
      {with("SIZE 4 4 4 8", "SIZE 4 4 4"), "not a number"},
      {with("SIZE 4 4 4 8", "SIZE 4 4 4 8 8"), "more entries"},
      {with("SIZE 4 4 4 8", "SIZE 4 4 4 3"), "1, 2, 4 or 8"},
      {with("COUNT 2", "COUNT 99999"), "1 to 4096"},
      {with("0.305", "inf"), "not finite"},
      {with("0.305", "nan"), "not finite"},
      {with("0.305", "1e9"), "1000 km"},
      {with("0.305", "99"), "voxels long"},
      {with("0 0 0.325 0.115 -0.205\n", "0 0 0.325"), "before its last point"},
      {std::string(kAscii) + "7", "more than its POINTS"},
  };
  for (const auto& [file, why] : cases) EXPECT_NE(refusal_of_pcd(file).find(why), std::string::npos) << why << ": " << refusal_of_pcd(file);
  std::string claims = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 60000000\nHEIGHT 1\nDATA binary\n";
  EXPECT_NE(refusal_of_pcd(claims).find("ends after 0 octets"), std::string::npos);
  for (const double size : {0.0, -1.0, 1e-9, 50.0, std::nan("")}) EXPECT_NE(refusal_of_pcd(kAscii, size).find("voxel size"), std::string::npos);
  EXPECT_NE(refusal([] { import_pcd(kAscii, "", 0.01); }).find("id"), std::string::npos);
  EXPECT_EQ(refusal_of_pcd(kAscii), "");
}

TEST(ModelImport, SaysWhatIsWrongWithAnOctoMap) {
  const auto tree = [](const std::string& size, const std::string& res, const std::string& data) {
    return "# Octomap OcTree binary file\nid OcTree\nsize " + size + "\nres " + res + "\ndata\n" + data;
  };
  EXPECT_NE(refusal_of_bt("").find("must begin with"), std::string::npos);
  EXPECT_NE(refusal_of_bt("# Octomap OcTree file\n").find("must begin with"), std::string::npos);
  EXPECT_NE(refusal_of_bt("# Octomap OcTree binary file\nid OcTree\n").find("within its header"), std::string::npos);
  EXPECT_NE(refusal_of_bt("# Octomap OcTree binary file\ndata\n").find("needs id, size and res"), std::string::npos);
  EXPECT_NE(refusal_of_bt("# Octomap OcTree binary file\nid SemanticOcTree\n").find("must be an OcTree"), std::string::npos);
  for (const char* res : {"0", "-0.1", "nan", "inf", "1e300", "1e-300"}) EXPECT_NE(refusal_of_bt(tree("2", res, "ab")).find("voxel size"), std::string::npos) << res;
  EXPECT_NE(refusal_of_bt(tree("2", "x", "ab")).find("not a number"), std::string::npos);
  EXPECT_NE(refusal_of_bt(tree("0", "0.1", "")).find("empty"), std::string::npos);
  EXPECT_NE(refusal_of_bt(tree("1", "0.1", std::string(2, '\0'))).find("empty"), std::string::npos);
  EXPECT_NE(refusal_of_bt(tree("2", "0.1", std::string("\2\0", 2))).find("32768 voxels long"), std::string::npos);
  EXPECT_NE(refusal_of_bt(tree("3", "0.1", std::string("\2\0", 2))).find("2 nodes, its header says 3"), std::string::npos);
  EXPECT_NE(refusal_of_bt(tree("2", "0.1", std::string("\2\0x", 3))).find("goes on"), std::string::npos);
  // OctoMap's reader descends into this until its stack ends.
  EXPECT_NE(refusal_of_bt(tree("9", "0.1", std::string(1 << 22, '\xff'))).find("deeper than 16"), std::string::npos);
  EXPECT_NE(refusal_of_bt(tree("9", "0.1", std::string(6, '\xff'))).find("ends within its tree"), std::string::npos);
}

// An error or a sound model, never a crash.
TEST(ModelImport, DamagedFilesAreRefusedOrSound) {
  const std::string bt = export_bt(aligned_model()), pcd = export_model(aligned_model(), "pcd");
  Random random(5);
  for (const std::string& file : {bt, pcd, std::string(kAscii)}) {
    int refused = 0, accepted = 0;
    for (int round = 0; round < 600; ++round) {
      std::string bad = file;
      if (round % 3 == 0) bad.resize(random.below(bad.size()));
      const std::size_t reach = round % 2 ? 300 : bad.size();
      for (int n = 0; n < 1 + round % 3 && !bad.empty(); ++n) bad[random.below(std::min(reach, bad.size()))] ^= static_cast<char>(1 << random.below(8));
      try {
        const ObjectModel model = file == bt ? import_bt(bad, "thing") : import_pcd(bad, "thing", 0.02);
        model.grid().geometry().check();
        EXPECT_FALSE(model.digest().empty());
        ++accepted;
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::bad_input) << error.what();
        ++refused;
      }
    }
    EXPECT_GT(refused, 200);
    EXPECT_GT(accepted, 0);
  }
}

}  // namespace
}  // namespace periplus::object_model

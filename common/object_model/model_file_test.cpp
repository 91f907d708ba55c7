#include "common/object_model/model_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "common/core/error.h"
#include "common/core/hash.h"
#include "common/core/random.h"
#include "common/object_model/compression.h"
#include "common/object_model/model.pb.h"
#include "common/object_model/model_export.h"
#include "common/object_model/testing/older_form.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model {
namespace {

using namespace testing;

template <class T>
void put_array(const std::vector<T>& from, proto::Array& to) {
  to.set_elements(from.size());
  to.set_element_bytes(sizeof(T));
  to.set_deflated(pack_bytes(from.data(), from.size(), sizeof(T)));
}

ObjectModel small_model() {
  const Sphere sphere;
  ObjectModel model("ball", box_around(sphere), 0.025, {.revision = "abc", .collision = nullptr, .occluders = {}});
  for (int n = 0; n < 2; ++n) model.integrate(ideal_view(sphere, n, 4, 80, 60), {}, {});
  return model;
}

void expect_same(const ObjectModel& a, const ObjectModel& b) {
  EXPECT_EQ(a.digest(), b.digest());
  EXPECT_EQ(a.state().object_id, b.state().object_id);
  EXPECT_EQ(a.state().environment_revision, b.state().environment_revision);
  EXPECT_EQ(a.grid().revision, b.grid().revision);
  EXPECT_TRUE(a.state().evidence == b.state().evidence);
  EXPECT_TRUE(a.state().tsdf == b.state().tsdf);
  EXPECT_EQ(a.state().known_solids, b.state().known_solids);
  ASSERT_EQ(a.state().views.size(), b.state().views.size());
  for (std::size_t i = 0; i < a.state().views.size(); ++i) {
    const View &v = *a.state().views[i], &w = *b.state().views[i];
    EXPECT_EQ(v.view_id, w.view_id);
    EXPECT_EQ(v.result, w.result);
    ASSERT_EQ(v.depth.size(), w.depth.size());
    for (std::size_t d = 0; d < v.depth.size(); ++d) {
      EXPECT_EQ(v.depth[d].depth.data, w.depth[d].depth.data);
      EXPECT_EQ(v.depth[d].minimum.data, w.depth[d].minimum.data);
      EXPECT_EQ(v.depth[d].sigma_per_z2, w.depth[d].sigma_per_z2);
      EXPECT_GT(w.depth[d].sigma_per_z2, 0);
      EXPECT_EQ(v.depth[d].X_CM.matrix(), w.depth[d].X_CM.matrix());
    }
    EXPECT_EQ(v.color.data, w.color.data);
    EXPECT_EQ(v.covariance, w.covariance);
    EXPECT_EQ(v.stamp_ns, w.stamp_ns);
  }
}

proto::Model unpacked(const std::string& file) {
  proto::Model m;
  EXPECT_TRUE(m.ParseFromString(file.substr(17 + 64 + 1)));
  return m;
}

std::string packed(const std::string& payload) { return "PERIPLUS-MODEL 2\n" + sha256_hex(payload) + "\n" + payload; }
std::string packed(const proto::Model& m) { return packed(m.SerializeAsString()); }

TEST(ModelFile, ComesBackAsItWas) {
  const ObjectModel model = small_model();
  const std::string file = write_model(model);
  const ObjectModel back = read_model(file);
  expect_same(model, back);
  EXPECT_EQ(write_model(back), file);
  EXPECT_EQ(export_ply(back), export_ply(model));
}

TEST(ModelFile, ComesBackFromItsParts) {
  const ObjectModel model = small_model();
  std::vector<std::string> views;
  for (const auto& v : model.state().views) views.push_back(write_view(*v));
  std::vector<std::string> sums;
  for (const std::string& v : views) sums.push_back(sha256_hex(v));
  const std::string state = write_state(model, sums);
  EXPECT_TRUE(is_current(state));
  expect_same(model, read_parts(state, views));
  // Views missing, changed about, or damaged where protobuf does not notice.
  EXPECT_THROW(read_parts(state, {views[0]}), Error);
  EXPECT_THROW(read_parts(state, {views[1], views[0]}), Error);
  views[0].back() ^= 1;
  EXPECT_THROW(read_parts(state, views), Error);
}

TEST(ModelFile, AModelThatIsReadGoesOnLearning) {
  ObjectModel model = small_model();
  ObjectModel back = read_model(write_model(model));
  const Perception third = ideal_view({}, 2, 4, 80, 60);
  EXPECT_EQ(model.integrate(third, {}, {}), back.integrate(third, {}, {}));
  EXPECT_EQ(model.digest(), back.digest());
}

TEST(ModelFile, LoadsFromDiskAndSaysWhatItCannotRead) {
  const std::string path = ::testing::TempDir() + "model_file_test.periplus";
  const ObjectModel model = small_model();
  std::ofstream(path, std::ios::binary) << write_model(model);
  expect_same(model, load_model(path));
  EXPECT_THROW(load_model(path + ".missing"), Error);
}

TEST(ModelFile, OtherVersionsAreNamed) {
  const auto refusal = [](const std::string& file) -> std::string {
    try {
      read_model(file);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return error.what();
    }
    return "";
  };
  std::string file = write_model(small_model());
  file.replace(0, std::string("PERIPLUS-MODEL 4").size(), "PERIPLUS-MODEL 12");
  EXPECT_NE(refusal(file).find("version 12; this program reads versions 1 to 4"), std::string::npos);
  for (const char* text : {"", "PERIPLUS-MODEL ", "PERIPLUS-MODEL \n", "PERIPLUS-MODEL x\n", "PERIPLUS-MODEL 99999999999999\n", "resolution_px: [640, 480]\n"})
    EXPECT_NE(refusal(text).find("must begin with"), std::string::npos) << text;
}

TEST(ModelFile, DamageIsNoticedByTheChecksum) {
  const std::string file = write_model(small_model());
  EXPECT_THROW(read_model(""), Error);
  EXPECT_THROW(read_model("PLY"), Error);
  EXPECT_THROW(read_model(file.substr(0, 60)), Error);
  EXPECT_THROW(read_model(file.substr(0, file.size() - 1)), Error);
  std::string flipped = file;
  flipped[file.size() / 2] ^= 1;
  EXPECT_THROW(read_model(flipped), Error);
  std::string newer = file;
  newer[15] = '5';
  EXPECT_THROW(read_model(newer), Error);
}

TEST(ModelFile, ReadsVersion2) {
  const ObjectModel model = small_model();
  proto::Model m;
  ASSERT_TRUE(m.ParseFromString(write_model(model).substr(17 + 64 + 1)));
  put_every_voxel(model, m);
  m.set_version(2);
  const std::string payload = m.SerializeAsString();
  expect_same(model, read_model(packed(payload)));
}

TEST(ModelFile, ReadsVersion3) {
  const ObjectModel model = small_model();
  proto::Model m;
  ASSERT_TRUE(m.ParseFromString(write_model(model).substr(17 + 64 + 1)));
  ASSERT_GT(model.state().tsdf.bricks().held(), 10u);
  put_every_sample(model, m);
  m.set_version(3);
  const std::string payload = m.SerializeAsString();
  const ObjectModel old = read_model("PERIPLUS-MODEL 3\n" + sha256_hex(payload) + "\n" + payload);
  expect_same(model, old);
  EXPECT_EQ(write_model(old), write_model(model));
}

// Distinct samples of a brick, and the places of its voxels among them.
TEST(ModelFile, PlacesAmongDistinctSamplesAreChecked) {
  const ObjectModel model = small_model();
  proto::Model m;
  ASSERT_TRUE(m.ParseFromString(write_model(model).substr(17 + 64 + 1)));
  const auto refusal = [&](const std::vector<std::uint16_t>& distinct, std::size_t samples, const std::vector<std::uint64_t>& places) -> std::string {
    proto::Model bad = m;
    std::vector<std::uint32_t> bricks;
    for (std::uint32_t b = 0; b < distinct.size(); ++b) bricks.push_back(b);
    put_array(bricks, *bad.mutable_tsdf_bricks());
    put_array(distinct, *bad.mutable_tsdf_distinct());
    put_array(std::vector<TsdfSample>(samples), *bad.mutable_tsdf());
    put_array(places, *bad.mutable_tsdf_places());
    const std::string payload = bad.SerializeAsString();
    try {
      read_model("PERIPLUS-MODEL 4\n" + sha256_hex(payload) + "\n" + payload);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  const std::vector<std::uint64_t> two_bits(16, 0xaaaaaaaaaaaaaaaa);
  EXPECT_EQ(refusal({1, 3, 1}, 5, two_bits), "");
  EXPECT_NE(refusal({1, 0, 1}, 2, {}).find("between 1 and 512"), std::string::npos);
  EXPECT_NE(refusal({1, 513, 1}, 515, std::vector<std::uint64_t>(128)).find("between 1 and 512"), std::string::npos);
  EXPECT_NE(refusal({1, 3, 1}, 6, two_bits).find("`tsdf`"), std::string::npos);
  EXPECT_NE(refusal({1, 3, 1}, 5, std::vector<std::uint64_t>(15)).find("`tsdf_places`"), std::string::npos);
  EXPECT_NE(refusal({1, 3, 1}, 5, std::vector<std::uint64_t>(16, 0xffffffffffffffff)).find("which its brick has not"), std::string::npos)
      << refusal({1, 3, 1}, 5, std::vector<std::uint64_t>(16, 0xffffffffffffffff));
}

// Bricks that the grid has not, or not in order.
TEST(ModelFile, NamesOfBricksAreChecked) {
  const ObjectModel model = small_model();
  proto::Model m;
  ASSERT_TRUE(m.ParseFromString(write_model(model).substr(17 + 64 + 1)));
  const auto refused = [&](const std::vector<std::uint32_t>& bricks) {
    proto::Model bad = m;
    put_array(bricks, *bad.mutable_tsdf_bricks());
    const std::vector<std::uint16_t> distinct(bricks.size(), 1);
    put_array(distinct, *bad.mutable_tsdf_distinct());
    put_array(std::vector<TsdfSample>(bricks.size()), *bad.mutable_tsdf());
    put_array(std::vector<std::uint64_t>(), *bad.mutable_tsdf_places());
    const std::string payload = bad.SerializeAsString();
    try {
      read_model("PERIPLUS-MODEL 4\n" + sha256_hex(payload) + "\n" + payload);
    } catch (const Error&) {
      return true;
    }
    return false;
  };
  const auto bricks = static_cast<std::uint32_t>(voxel::brick_count(model.grid().geometry()));
  EXPECT_FALSE(refused({0, bricks - 1}));
  EXPECT_TRUE(refused({0, bricks}));
  EXPECT_TRUE(refused({1, 0}));
  EXPECT_TRUE(refused({1, 1}));
}

// As version 1 wrote it: the left eye's depth without its minimum, no version, no references.
TEST(ModelFile, ReadsVersion1) {
  const ObjectModel model = small_model();
  proto::Model m;
  ASSERT_TRUE(m.ParseFromString(write_model(model).substr(17 + 64 + 1)));
  m.clear_version();
  put_every_voxel(model, m);
  for (proto::View& v : *m.mutable_views()) {
    *v.mutable_depth() = v.depth_maps(0).depth();
    v.set_depth_width(v.width());
    v.set_depth_height(v.height());
    v.clear_depth_maps();
  }
  const std::string payload = m.SerializeAsString();
  const ObjectModel old = read_model("PERIPLUS-MODEL 1\n" + sha256_hex(payload) + "\n" + payload);
  EXPECT_EQ(old.digest(), model.digest());
  ASSERT_EQ(old.state().views[1]->depth.size(), 1u);
  EXPECT_EQ(old.state().views[1]->depth[0].depth.data, model.state().views[1]->depth[0].depth.data);
  EXPECT_FALSE(old.can_be_revised());
  EXPECT_TRUE(model.can_be_revised());
  EXPECT_THROW(old.revised({}, {}, {"abc", nullptr, {}}, {}), Error);
  // Written again it is of this version, and still says what it lacks.
  EXPECT_FALSE(read_model(write_model(old)).can_be_revised());
  m.clear_views();
  EXPECT_FALSE(is_current(m.SerializeAsString()));
  m.set_version(5);
  EXPECT_THROW(read_parts(m.SerializeAsString(), {}), Error);
}

// Version 2 had no kinds of descriptors at first: what says none is RootSIFT.
TEST(ModelFile, DescriptorsKeepTheirKind) {
  Perception p = ideal_view(Sphere{}, 0, 4, 80, 60);
  p.features[1].kind = DescriptorKind::akaze;
  p.features[1].descriptor.assign(61, 3);
  ObjectModel model("ball", box_around(Sphere{}), 0.025, {});
  model.integrate(p, {}, {});
  const std::string file = write_model(model);
  const auto read = [](const ObjectModel& m) { return m.state().views[0]->features; };
  const ObjectModel back = read_model(file);
  EXPECT_EQ(read(back)[0].kind, DescriptorKind::root_sift);
  EXPECT_EQ(read(back)[1].kind, DescriptorKind::akaze);
  EXPECT_EQ(read(back)[1].descriptor, p.features[1].descriptor);
  proto::Model m = unpacked(file);
  proto::Feature& f = *m.mutable_views(0)->mutable_features(1);
  f.clear_descriptor_kind();
  EXPECT_EQ(read(read_model(packed(m)))[1].kind, DescriptorKind::root_sift);
  f.set_descriptor_kind(4);
  try {
    read_model(packed(m));
    FAIL() << "an unknown kind was taken";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("kind 4"), std::string::npos) << error.what();
  }
}

TEST(ModelFile, RefusesStandardDeviationsOutOfRange) {
  proto::Model m = unpacked(write_model(small_model()));
  EXPECT_NO_THROW(read_model(packed(m)));
  for (const double sigma : {-0.001, 1.5, std::numeric_limits<double>::quiet_NaN()}) {
    m.mutable_views(0)->mutable_depth_maps(0)->set_sigma_per_z2(sigma);
    EXPECT_THROW(read_model(packed(m)), Error) << sigma;
  }
}

TEST(ModelFile, KeepsItsHistory) {
  ObjectModel model = small_model();
  const std::string digest = model.digest();
  for (int n = 0; n < 5000; ++n) model.note({n, "looked", std::string(300, 'x') + "\xff", static_cast<std::uint32_t>(n), "0.1.0"});
  EXPECT_EQ(write_model(model), write_model(small_model()));  // the file is the same whenever it was made
  std::vector<std::string> views, sums;
  for (const auto& v : model.state().views) {
    views.push_back(write_view(*v));
    sums.push_back(sha256_hex(views.back()));
  }
  const ObjectModel back = read_parts(write_state(model, sums), views);
  ASSERT_EQ(back.state().history.size(), 4096u);
  EXPECT_EQ(back.state().history.back().stamp_ns, 4999);
  EXPECT_EQ(back.state().history.back().what, "looked");
  EXPECT_EQ(back.state().history.back().detail, std::string(256, 'x'));
  EXPECT_EQ(back.state().history.back().program, "0.1.0");
  EXPECT_EQ(back.digest(), digest);
}

// What a state and views claim to hold is refused before memory is taken for it.
TEST(ModelFile, ClaimsBeyondTheLimitsAreRefusedBeforeUnpacking) {
  const auto refusal = [](const std::string& state, const std::vector<std::string>& views) -> std::string {
    try {
      read_parts(state, views);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  const ObjectModel model = small_model();
  const std::string view = write_view(*model.state().views[0]), state = write_state(model, {sha256_hex(view), sha256_hex(view)});

  proto::Model huge;
  ASSERT_TRUE(huge.ParseFromString(state));
  huge.clear_references();
  for (int n = 0; n < 3; ++n) huge.set_size(n, 513);
  EXPECT_NE(refusal(huge.SerializeAsString(), {}).find("1 to 512 voxels along each axis"), std::string::npos) << refusal(huge.SerializeAsString(), {});
  huge.ParseFromString(state);
  huge.clear_references();
  huge.mutable_tsdf_places()->set_elements(std::uint64_t{1} << 28);
  EXPECT_NE(refusal(huge.SerializeAsString(), {}).find("over 2 GiB"), std::string::npos) << refusal(huge.SerializeAsString(), {});

  proto::View large;
  ASSERT_TRUE(large.ParseFromString(view));
  proto::DepthMap& map = *large.mutable_depth_maps(0);
  map.set_width(8192);
  map.set_height(8192);
  map.mutable_depth()->set_elements(8192 * 8192);
  std::vector<std::string> views;
  for (int n = 0; n < 17; ++n) {  // 128 MiB each
    large.set_view_id("view-" + std::to_string(n));
    views.push_back(large.SerializeAsString());
  }
  EXPECT_NE(refusal(state, views).find("over 2 GiB"), std::string::npos) << refusal(state, views);
  map.mutable_depth()->set_elements(std::uint64_t{1} << 63);
  EXPECT_NE(refusal(state, {large.SerializeAsString()}).find("over 2 GiB"), std::string::npos);

  huge.ParseFromString(state);
  for (const std::string& v : views) ASSERT_TRUE(huge.add_views()->ParseFromString(v));
  const std::string payload = huge.SerializeAsString();
  EXPECT_THROW(read_model(packed(payload)), Error);
}

// Hostile contents under a right checksum: an error or a sound model, never a crash.
TEST(ModelFile, HostileContentsAreRefusedOrSound) {
  const std::string file = write_model(small_model());
  const std::size_t header = 17 + 64 + 1;
  const std::string payload = file.substr(header);
  Random random(11);
  int refused = 0, accepted = 0;
  for (int round = 0; round < 400; ++round) {
    std::string bad = payload;
    if (round % 10 == 0) bad.resize(random.below(bad.size()));
    // The first octets hold identifiers, poses and sizes; further on are packed arrays.
    const std::size_t reach = round % 2 ? 400 : bad.size();
    for (int n = 0; n < 1 + round % 4 && !bad.empty(); ++n)
      bad[random.below(std::min(reach, bad.size()))] = static_cast<char>(random.below(256));
    try {
      const ObjectModel model = read_model(packed(bad));
      model.grid().geometry().check();
      EXPECT_FALSE(model.digest().empty());
      ++accepted;
    } catch (const Error& e) {
      EXPECT_NE(e.code(), ErrorCode::internal);
      ++refused;
    }
  }
  EXPECT_GT(refused, 200);
  EXPECT_GT(accepted, 0);
}

}  // namespace
}  // namespace periplus::object_model

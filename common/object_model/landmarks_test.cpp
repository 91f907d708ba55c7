#include "common/object_model/landmarks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/object_model/object_model.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model {
namespace {

using namespace testing;

// Spots on a wall of 0.5 x 0.4 m, each with a descriptor that its views see a little disturbed. Views stand 15 degrees apart; each sees
// most of the spots, and features of its own.
struct Wall {
  std::vector<Eigen::Vector3d> spots;
  std::vector<std::shared_ptr<const View>> views;
  std::vector<std::vector<int>> spot_of;  // of each view's feature; -1: its own
  explicit Wall(int count, std::uint64_t seed, double pose_error = 0) {
    Random random(seed);
    std::vector<std::vector<std::uint8_t>> descriptors;
    for (int i = 0; i < count; ++i) {
      spots.emplace_back(random.uniform(-0.25, 0.25), 0, random.uniform(0.8, 1.2));
      descriptors.push_back(descriptor(random));
    }
    for (int v = 0; v < 5; ++v) {
      View view;
      view.view_id = "view-" + std::to_string(v);
      view.rig = {Pinhole::from_vertical_fov(640, 480, 0.436), 0.144};
      const double angle = (v - 2) * 0.26;
      view.X_WC = look_at({1.2 * std::sin(angle), 1.2 * std::cos(angle), 1 + 0.1 * v}, {0, 0, 1});
      const Eigen::Vector3d off = pose_error * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
      std::vector<int> of;
      const auto see = [&](const Eigen::Vector3d& p, std::vector<std::uint8_t> d, int spot) {
        Feature f;
        const Eigen::Vector2d uv = view.rig.camera.project(view.X_WC.inverse() * p);
        f.u = static_cast<float>(uv.x());
        f.v = static_cast<float>(uv.y());
        f.size = 5;
        f.p_W = p + 0.001 * Eigen::Vector3d(random.normal(), random.normal(), random.normal()) + off;
        f.normal_W = {0, 1, 0};
        f.size_m = 0.006;
        for (auto& octet : d) octet = static_cast<std::uint8_t>(std::clamp(octet + static_cast<int>(random.below(9)) - 4, 0, 255));
        f.descriptor = std::move(d);
        view.features.push_back(std::move(f));
        of.push_back(spot);
      };
      for (int i = 0; i < count; ++i)
        if (random.below(5) != 0) see(spots[static_cast<std::size_t>(i)], descriptors[static_cast<std::size_t>(i)], i);
      for (int i = 0; i < 10; ++i) see({random.uniform(-0.25, 0.25), 0, random.uniform(0.8, 1.2)}, descriptor(random), -1);
      views.push_back(std::make_shared<View>(std::move(view)));
      spot_of.push_back(std::move(of));
    }
  }
  static std::vector<std::uint8_t> descriptor(Random& random) {
    std::vector<std::uint8_t> d(128);
    for (auto& octet : d) octet = static_cast<std::uint8_t>(random.below(90));
    return d;
  }
};

std::size_t observations(const std::vector<SeenLandmark>& landmarks) {
  std::size_t n = 0;
  for (const SeenLandmark& l : landmarks) n += l.seen.size();
  return n;
}

TEST(Landmarks, OneSpotIsOneLandmarkWhateverSeesIt) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Wall wall(60, seed, 0.002);
    const auto landmarks = merge_landmarks(wall.views);
    std::map<int, int> of_spot;
    std::set<Observation> all;
    for (const SeenLandmark& l : landmarks) {
      ASSERT_FALSE(l.seen.empty());
      EXPECT_TRUE(std::is_sorted(l.seen.begin(), l.seen.end()));
      const int spot = wall.spot_of[l.seen[0].view][l.seen[0].feature];
      std::set<std::size_t> from;
      for (const Observation& o : l.seen) {
        EXPECT_EQ(wall.spot_of[o.view][o.feature], spot);  // nothing else is taken for it
        EXPECT_TRUE(all.insert(o).second);
        from.insert(o.view);
      }
      EXPECT_EQ(from.size(), l.seen.size());
      if (spot < 0) {
        EXPECT_EQ(l.seen.size(), 1u);
      } else {
        ++of_spot[spot];
        EXPECT_LT((l.place.p_W - wall.spots[static_cast<std::size_t>(spot)]).norm(), 0.009);
      }
      EXPECT_NEAR(l.place.normal_W.y(), 1, 1e-12);
      EXPECT_NEAR(l.place.size_m, 0.006, 1e-12);
    }
    for (const auto& [spot, count] : of_spot) EXPECT_EQ(count, 1) << spot;
    EXPECT_EQ(of_spot.size(), 60u);
    std::size_t features = 0;
    for (const auto& v : wall.views) features += v->features.size();
    EXPECT_EQ(all.size(), features);
    EXPECT_EQ(observations(landmarks), features);
  }
}

void expect_same(const std::vector<SeenLandmark>& a, const std::vector<SeenLandmark>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].seen, b[i].seen);
    EXPECT_EQ(a[i].place.p_W, b[i].place.p_W);
    EXPECT_EQ(a[i].place.normal_W, b[i].place.normal_W);
    EXPECT_EQ(a[i].place.size_m, b[i].place.size_m);
  }
}

TEST(Landmarks, KeptMatchesGiveTheSameToTheLastBit) {
  const Wall wall(60, 3, 0.002);
  KeptMatches kept;
  std::vector<std::shared_ptr<const View>> views;
  for (const auto& view : wall.views) {
    views.push_back(view);
    expect_same(merge_landmarks(views, {}, &kept), merge_landmarks(views));
    EXPECT_EQ(kept.of.size(), views.size() * (views.size() - 1) / 2);
  }
  // A view that was taken out, one that stands elsewhere, and the others in another order.
  View moved = *views[1];
  moved.X_WC.translation().x() += 0.01;
  for (Feature& f : moved.features) f.p_W.x() += 0.004;
  views = {views[4], views[0], std::make_shared<const View>(std::move(moved)), views[3]};
  expect_same(merge_landmarks(views, {}, &kept), merge_landmarks(views));
  EXPECT_EQ(kept.of.size(), 6u);
  LandmarkSettings strict;
  strict.matching.ratio = 0.6;
  expect_same(merge_landmarks(views, strict, &kept), merge_landmarks(views, strict));
  EXPECT_EQ(kept.settings, strict.matching);
  EXPECT_TRUE(std::ranges::any_of(merge_landmarks(views, strict, &kept), [](const SeenLandmark& l) { return l.seen.size() > 1; }));
  // What is kept is what is used.
  for (auto& [pair, matches] : kept.of) matches.clear();
  for (const SeenLandmark& l : merge_landmarks(views, strict, &kept)) EXPECT_EQ(l.seen.size(), 1u);
  for (auto& [pair, matches] : kept.of) EXPECT_TRUE(matches.empty());
}

// As a box that grows and a revision make them.
TEST(Landmarks, CopiesOfAViewKeepItsMatchesWhileItsFeaturesAreTheSame) {
  const Wall wall(60, 3, 0.002);
  KeptMatches kept;
  merge_landmarks(wall.views, {}, &kept);
  for (auto& [pair, matches] : kept.of) matches.clear();  // whoever is matched anew has some again
  std::vector<std::shared_ptr<const View>> views;
  for (const auto& view : wall.views) {
    auto copy = std::make_shared<View>(*view);
    copy->result.revision += 7;
    copy->X_WC.translation().x() += 0.01;
    views.push_back(copy);
  }
  auto other = std::make_shared<View>(*views[2]);
  other->features.pop_back();
  views[2] = other;
  merge_landmarks(views, {}, &kept);
  ASSERT_EQ(kept.of.size(), 10u);
  for (const auto& [pair, matches] : kept.of) {
    EXPECT_EQ(matches.empty(), pair.first != other && pair.second != other) << pair.first->view_id << " " << pair.second->view_id;
    for (const auto& view : {pair.first, pair.second}) EXPECT_NE(std::ranges::find(views, view), views.end()) << "an old view is held";
  }
}

TEST(Landmarks, ManyObservationsPlaceItBetterThanOne) {
  const Wall wall(80, 11);
  double one = 0, mean = 0;
  for (const SeenLandmark& l : merge_landmarks(wall.views)) {
    const int spot = wall.spot_of[l.seen[0].view][l.seen[0].feature];
    if (spot < 0 || l.seen.size() < 3) continue;
    mean += (l.place.p_W - wall.spots[static_cast<std::size_t>(spot)]).squaredNorm();
    one += (wall.views[l.seen[0].view]->features[l.seen[0].feature].p_W - wall.spots[static_cast<std::size_t>(spot)]).squaredNorm();
  }
  EXPECT_GT(one, 0);
  EXPECT_LT(mean, 0.5 * one);
}

TEST(Landmarks, SpotsThatLookAlikeButLieApartStayTwo) {
  Wall wall(60, 3);
  // By its pose the third view stands 5 cm aside: its distances fit the others', its places do not.
  View moved = *wall.views[2];
  for (Feature& f : moved.features) f.p_W.x() += 0.05;
  wall.views[2] = std::make_shared<View>(std::move(moved));
  for (const SeenLandmark& l : merge_landmarks(wall.views)) {
    if (l.seen.size() > 1) {
      for (const Observation& o : l.seen) EXPECT_NE(o.view, 2u);
    }
  }
  LandmarkSettings wide;
  wide.reach_m = 0.06;
  EXPECT_TRUE(std::ranges::any_of(merge_landmarks(wall.views, wide), [](const SeenLandmark& l) { return l.seen.size() > 2; }));
}

TEST(Landmarks, DirectionsOfOneSpotAreOneObservation) {
  Wall wall(60, 4);
  View twice = *wall.views[0];
  Feature again = twice.features[0];
  again.angle = 2;
  Random random(1);
  again.descriptor = Wall::descriptor(random);
  twice.features.push_back(again);
  wall.views[0] = std::make_shared<View>(std::move(twice));
  const auto landmarks = merge_landmarks(wall.views);
  const Observation last{0, wall.views[0]->features.size() - 1};
  for (const SeenLandmark& l : landmarks) {
    const bool first_here = std::ranges::find(l.seen, Observation{0, 0}) != l.seen.end(), last_here = std::ranges::find(l.seen, last) != l.seen.end();
    EXPECT_EQ(first_here, last_here);
    if (first_here) {
      EXPECT_GE(l.seen.size(), 2u);
    }
  }
}

TEST(Landmarks, ViewsFromTheOtherSideAreNotCompared) {
  const Wall wall(60, 5);
  LandmarkSettings narrow;
  narrow.most_turn = 0.1;
  for (const SeenLandmark& l : merge_landmarks(wall.views, narrow)) EXPECT_EQ(l.seen.size(), 1u);
  EXPECT_TRUE(merge_landmarks({}).empty());
}

TEST(Landmarks, BelongToTheNearestVoxelOfTheObject) {
  voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(Pose::Identity(), {0.16, 0.16, 0.16}, 0.01));
  for (int x = 0; x < 16; ++x)
    for (int y = 0; y < 16; ++y)
      for (int z = 0; z < 16; ++z) grid.set_state({x, y, z}, x < 8 ? voxel::VoxelState::known : voxel::VoxelState::empty);
  grid.set_state({7, 9, 9}, voxel::VoxelState::environment);
  const auto at = [&](const Eigen::Vector3d& voxels, double size) { return landmark_voxel({grid.geometry().X_WG * Eigen::Vector3d(voxels * 0.01), {0, 0, 0}, size}, grid); };
  EXPECT_EQ(*at({7.9, 3.5, 3.5}, 0), Eigen::Vector3i(7, 3, 3));
  EXPECT_EQ(*at({8.2, 3.4, 3.6}, 0), Eigen::Vector3i(7, 3, 3));   // 0.7 voxels from its centre, half a diagonal is 0.87
  EXPECT_FALSE(at({8.6, 3.5, 3.5}, 0));                           // 1.1 voxels
  EXPECT_EQ(*at({8.6, 3.5, 3.5}, 0.01), Eigen::Vector3i(7, 3, 3));  // 1.1 voxels, 1.37 with half its size
  EXPECT_EQ(*at({8.1, 9.4, 9.5}, 0.01), Eigen::Vector3i(7, 8, 9));  // its own neighbour is the table's
  EXPECT_FALSE(at({40, 3.5, 3.5}, 1e300));                        // no further than 8 voxels
  EXPECT_FALSE(at({8.2, 3.5, 3.5}, -1));
}

TEST(Landmarks, OfAModelLieInTheVoxelsTheyBelongTo) {
  const Sphere sphere;
  ObjectModel model("ball", box_around(sphere), 0.01, {});
  for (int n = 0; n < 4; ++n) {
    Perception p = ideal_view(sphere, n, 4);
    for (Feature& f : p.features) f.p_W += 0.012 * f.normal_W;  // as noise of depth may put them: outside
    model.integrate(p, {}, {});
  }
  const auto landmarks = model.landmarks();
  EXPECT_FALSE(landmarks.empty());
  LandmarkSettings wrong;
  wrong.reach_m = -1;
  EXPECT_THROW(model.landmarks(wrong), Error);
  for (const Landmark& l : landmarks) {
    const auto s = model.grid().state(model.grid().geometry().voxel_of(l.p_W));
    EXPECT_TRUE(s == voxel::VoxelState::known || s == voxel::VoxelState::unknown);
  }
}

TEST(Landmarks, SettingsOutOfRangeAreRefused) {
  LandmarkSettings s;
  s.reach_m = 0;
  EXPECT_THROW(merge_landmarks({}, s), Error);
}

}  // namespace
}  // namespace periplus::object_model

// The bricks that carving and labelling mark as changed, and the exposed faces that a model keeps by them, against all looked at anew.
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>

#include "common/object_model/model_file.h"
#include "common/object_model/testing/random_scene.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/scene/scene.h"
#include "common/voxel/visibility.h"

namespace periplus::object_model {
namespace {

using namespace testing;

voxel::BrickMarks differing(const voxel::OccupancyGrid& a, const voxel::OccupancyGrid& b) {
  voxel::BrickMarks marks(voxel::brick_count(a.geometry()));
  for (std::size_t w = 0; w < a.occupied().size(); ++w)
    if (a.occupied()[w] != b.occupied()[w] || a.known()[w] != b.known()[w] || a.environment()[w] != b.environment()[w]) marks[w / 8] = 1;
  return marks;
}

std::size_t count(const voxel::BrickMarks& marks) { return static_cast<std::size_t>(std::count(marks.begin(), marks.end(), 1)); }

// Runs `change` on the grid: it must mark those bricks that it changes and no others, and the faces brought up to date by its marks must be
// those made anew. How many bricks it changed.
template <class Change>
std::size_t expect_marked(voxel::OccupancyGrid& grid, voxel::ExposedFaces& faces, Change&& change) {
  const voxel::OccupancyGrid before = grid;
  voxel::BrickMarks marks(faces.brick_count());
  change(marks);
  EXPECT_EQ(marks, differing(before, grid));
  faces.update(grid, marks);
  EXPECT_TRUE(faces == voxel::ExposedFaces(grid));
  return count(marks);
}

TEST(ExposedFacesProperty, CarvingAndLabellingMarkWhatTheyChange) {
  std::size_t emptied = 0, labelled = 0, weighed = 0, bricks = 0;
  for (int number = 0; number < scene_count(); ++number) {
    SCOPED_TRACE("scene " + std::to_string(number));
    const RandomScene s(number);
    const voxel::GridGeometry& g = s.geometry();
    // A layer of a table that was known before the first look.
    std::vector<std::uint64_t> table(s.grid.occupied().size(), 0);
    for_each_voxel(g, [&](const Eigen::Vector3i& v) { table[s.grid.word(v)] |= v.z() == 0 ? voxel::OccupancyGrid::bit(v) : 0; });
    for (const int votes : {1, 2}) {
      const CarvingSettings settings;
      voxel::OccupancyGrid grid = s.grid;
      Evidence evidence(g);
      voxel::ExposedFaces faces(grid);
      bricks += faces.brick_count();
      for (const DepthMap& map : s.maps) {
        const PixelLimits limits = s.limits(map);
        emptied += expect_marked(grid, faces, [&](auto& marks) { carve_and_count(map, limits, settings.margin_voxels, votes, grid, evidence, &marks); });
        labelled += expect_marked(grid, faces, [&](auto& marks) { label(table, settings, evidence, grid, &marks); });
      }
    }
    CarvingSettings settings;
    settings.mode = CarvingMode::probabilistic;
    voxel::OccupancyGrid grid = s.grid;
    Evidence evidence(g);
    LogOdds log_odds(g);
    voxel::ExposedFaces faces(grid);
    for (const DepthMap& map : s.maps) {
      const PixelLimits limits = s.limits(map);
      log_odds.integrate(map, limits, 50, {}, settings);
      add_points(map, limits, g, settings.margin_voxels, evidence);
      weighed += expect_marked(grid, faces, [&](auto& marks) { log_odds.label(table, settings, evidence, grid, &marks); });
    }
  }
  for (const std::size_t marked : {emptied, labelled, weighed}) EXPECT_GT(marked, bricks / 10);  // else this shows nothing
}

void expect_faces_of_its_grid(const ObjectModel& model) { EXPECT_TRUE(*model.exposed_faces() == voxel::ExposedFaces(model.grid())); }

struct Way {
  const char* name;
  CarvingMode mode;
  double silhouette_valid_share;  // little: cautious maps, which empty by votes
  friend std::ostream& operator<<(std::ostream& to, const Way& way) { return to << way.name; }
};

class KeptFaces : public ::testing::TestWithParam<Way> {};

TEST_P(KeptFaces, AreThoseOfTheGridAfterEachViewOfAModelAndOfItsCopies) {
  const Sphere sphere;
  scene::Scene scene;
  scene::Solid table;
  table.name = "table";
  table.size = {2, 2, 0.86};
  table.X_WS.translation().z() = 0.43;
  scene.solids.push_back(table);
  const Surroundings around{"r1", std::make_shared<const scene::CollisionWorld>(scene), occluders_of(scene)};
  CarvingSettings settings;
  settings.mode = GetParam().mode;
  ObjectModel model("ball", box_around(sphere), 0.0125, around);
  expect_faces_of_its_grid(model);
  std::size_t least = model.exposed_faces()->held(), most = least;
  for (int n = 0; n < 6; ++n) {
    SCOPED_TRACE(n);
    const ObjectModel before = model;
    Perception view = ideal_view(sphere, n, 6, 160, 120);
    view.silhouette_valid_share = GetParam().silhouette_valid_share;
    const voxel::OccupancyGrid grid = model.grid();
    const Integration result = model.integrate(view, around, settings);
    const auto pixels = [&](const voxel::OccupancyGrid& of) {
      voxel::VisibilityWorkspace workspace;
      return static_cast<double>(voxel::VisibilityScene(of, around.occluders).evaluate_pair(view.X_WC, view.rig, {}, workspace).pixels);
    };
    EXPECT_EQ(result.found_gain_px, pixels(grid) - pixels(model.grid()));
    expect_faces_of_its_grid(model);
    EXPECT_NE(count(differing(grid, model.grid())), 0u);
    expect_faces_of_its_grid(before);  // the copy is what it was
    EXPECT_TRUE(before.grid().occupied() == grid.occupied());
    least = std::min(least, model.exposed_faces()->held());
    most = std::max(most, model.exposed_faces()->held());

    const voxel::VisibilityScene kept(model.exposed_faces(), around.occluders), anew(model.grid(), around.occluders);
    EXPECT_EQ(kept.surface(), anew.surface());
    EXPECT_EQ(kept.unknown_face_count(), anew.unknown_face_count());
    const voxel::VisibilityResult a = kept.evaluate(view.X_WC, view.rig.camera), b = anew.evaluate(view.X_WC, view.rig.camera);
    EXPECT_EQ(a.unknown_pixels, b.unknown_pixels);
    EXPECT_EQ(a.known_pixels, b.known_pixels);
    EXPECT_EQ(a.environment_pixels, b.environment_pixels);
  }
  EXPECT_LT(least, most);  // bricks came or went
  expect_faces_of_its_grid(ObjectModel(model.state()));
  expect_faces_of_its_grid(read_model(write_model(model)));
  expect_faces_of_its_grid(model.revised({}, {"view-1"}, around, settings));
  ObjectBox larger = model.state().box;
  larger.size.x() += 0.2;
  expect_faces_of_its_grid(model.within(larger, around, settings));
}

INSTANTIATE_TEST_SUITE_P(Ways, KeptFaces, ::testing::Values(Way{"conservative", CarvingMode::conservative, 1}, Way{"votes", CarvingMode::conservative, 0.3},
                                           Way{"probabilistic", CarvingMode::probabilistic, 1}));

}  // namespace
}  // namespace periplus::object_model

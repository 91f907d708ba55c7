#include "services/model_server/model_keeper.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "common/core/error.h"
#include "common/core/fault_point.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/scene/scene.h"

namespace periplus::model {
namespace {

using namespace object_model::testing;
namespace fs = std::filesystem;

KnownTexts room(const std::string& revision = "r1") {
  auto scene = std::make_shared<scene::Scene>();
  scene::Solid table;
  table.name = "table";
  table.size = {2, 2, 0.8};
  table.X_WS.translation() = Eigen::Vector3d(0, 0, 0.4);
  scene->solids.push_back(table);
  return {{"room", "scene " + revision, "robot", "urdf"}, revision, scene, std::make_shared<scene::CollisionWorld>(*scene)};
}

object_model::Perception view(int n) { return ideal_view({}, n, 6, 80, 60); }

template <class Function>
ErrorCode code_of(Function&& function) {
  try {
    function();
  } catch (const Error& e) {
    return e.code();
  }
  return ErrorCode::ok;
}

class ModelKeeperTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder); }
  void TearDown() override { fs::remove_all(folder); }
  const std::string folder = ::testing::TempDir() + "model_keeper_test." + std::to_string(::getpid());
  const object_model::ObjectBox box = box_around({});
};

TEST_F(ModelKeeperTest, AnswersTwiceTheSame) {
  ModelKeeper keeper(folder, {});
  keeper.set_environment(room());
  const auto first = keeper.begin("ball", box, 0.025, false);
  EXPECT_GT(first->grid().counts().environment, 0u);
  EXPECT_EQ(keeper.begin("ball", box, 0.025, false), first);
  EXPECT_EQ(keeper.begin("ball", box, 0.025, true), first);  // nothing was seen of it yet

  const auto p = view(0);
  const auto result = keeper.integrate("ball", p.view_id, &p);
  EXPECT_EQ(result.revision, 1u);
  EXPECT_TRUE(keeper.has_view("ball", p.view_id));
  const auto seen = keeper.model("ball");
  EXPECT_EQ(keeper.integrate("ball", p.view_id, nullptr), result);
  EXPECT_EQ(keeper.model("ball"), seen);
  EXPECT_EQ(first->grid().revision, 0u);  // what was handed out does not change
}

TEST_F(ModelKeeperTest, ResetBeginsAnewWithTheNextRevision) {
  ModelKeeper keeper(folder, {});
  keeper.set_environment(room());
  keeper.begin("ball", box, 0.025, false);
  const auto p = view(0);
  keeper.integrate("ball", p.view_id, &p);
  const auto anew = keeper.begin("ball", box, 0.025, true);
  EXPECT_EQ(anew->grid().revision, 2u);
  EXPECT_TRUE(anew->state().views.empty());
  EXPECT_EQ(anew->state().history.back().detail, "environment r1, in place of revision 1 of 1 views");
  EXPECT_EQ(keeper.integrate("ball", p.view_id, &p).revision, 3u);
}

TEST_F(ModelKeeperTest, RefusalsCarryTheirCodes) {
  ModelKeeper keeper(folder, {});
  EXPECT_EQ(code_of([&] { keeper.environment(); }), ErrorCode::model_environment_missing);
  EXPECT_EQ(code_of([&] { keeper.begin("ball", box, 0.025, false); }), ErrorCode::model_environment_missing);
  keeper.set_environment(room());
  EXPECT_EQ(code_of([&] { keeper.model("ball"); }), ErrorCode::model_object_unknown);
  EXPECT_EQ(code_of([&] { keeper.integrate("ball", "v", nullptr); }), ErrorCode::model_object_unknown);
  EXPECT_EQ(code_of([&] { keeper.begin("ball", box, 0.0001, false); }), ErrorCode::bad_input);
  keeper.begin("ball", box, 0.025, false);
  EXPECT_EQ(code_of([&] { keeper.begin("ball", box, 0.02, false); }), ErrorCode::model_object_differs);
  keeper.set_environment(room("r2"));
  EXPECT_EQ(code_of([&] { keeper.begin("ball", box, 0.025, false); }), ErrorCode::model_object_differs);
  keeper.set_environment(room());
  EXPECT_EQ(code_of([&] { keeper.integrate("ball", "v", nullptr); }), ErrorCode::model_perception_not_here);
  auto bad = view(0);
  bad.depth.clear();
  EXPECT_EQ(code_of([&] { keeper.integrate("ball", bad.view_id, &bad); }), ErrorCode::bad_size);
  EXPECT_FALSE(keeper.has_view("ball", bad.view_id));
}

TEST_F(ModelKeeperTest, GoesOnWhereItWas) {
  const auto p0 = view(0), p1 = view(1);
  std::string digest;
  object_model::Integration first;
  {
    ModelKeeper keeper(folder, {});
    keeper.set_environment(room());
    keeper.begin("ball", box, 0.025, false);
    first = keeper.integrate("ball", p0.view_id, &p0);
    const auto all = keeper.model("ball");
    digest = all->digest();
  }
  ModelKeeper keeper(folder, {});
  ASSERT_EQ(keeper.stored_environment(), room().texts);
  keeper.set_environment(room());
  ASSERT_EQ(keeper.models().size(), 1u);
  EXPECT_EQ(keeper.model("ball")->digest(), digest);
  EXPECT_EQ(keeper.integrate("ball", p0.view_id, nullptr), first);
  EXPECT_EQ(keeper.integrate("ball", p1.view_id, &p1).revision, 2u);

  // The same two looks without a restart.
  ModelKeeper straight(folder + ".straight", {});
  straight.set_environment(room());
  straight.begin("ball", box, 0.025, false);
  straight.integrate("ball", p0.view_id, &p0);
  straight.integrate("ball", p1.view_id, &p1);
  EXPECT_EQ(straight.model("ball")->digest(), keeper.model("ball")->digest());
  fs::remove_all(folder + ".straight");
}

TEST_F(ModelKeeperTest, ADamagedObjectIsNotReplacedUnasked) {
  {
    ModelKeeper keeper(folder, {});
    keeper.set_environment(room());
    keeper.begin("ball", box, 0.025, false);
    const auto p = view(0);
    keeper.integrate("ball", p.view_id, &p);
  }
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder + "/knowledge.sqlite").c_str(), &db), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(db, "UPDATE objects SET sha256 = ''", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(db);
  ModelKeeper keeper(folder, {});
  keeper.set_environment(room());
  EXPECT_TRUE(keeper.models().empty());
  EXPECT_EQ(code_of([&] { keeper.begin("ball", box, 0.025, false); }), ErrorCode::model_store);
  EXPECT_EQ(KnowledgeStore(folder, KnowledgeStore::Access::read).verify().size(), 1u);
  EXPECT_TRUE(keeper.begin("ball", box, 0.025, true)->state().views.empty());
  EXPECT_TRUE(KnowledgeStore(folder, KnowledgeStore::Access::read).verify().empty());
}

TEST_F(ModelKeeperTest, ADamagedEnvironmentIsNotTakenUpAndIsSetAgain) {
  ModelKeeper(folder, {}).set_environment(room());
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder + "/knowledge.sqlite").c_str(), &db), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(db, "UPDATE environment SET scene_yaml = 'scene r2'", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(db);
  ModelKeeper keeper(folder, {});
  EXPECT_EQ(code_of([&] { keeper.stored_environment(); }), ErrorCode::model_store);
  EXPECT_EQ(code_of([&] { keeper.begin("ball", box, 0.025, false); }), ErrorCode::model_environment_missing);
  keeper.set_environment(room());
  EXPECT_EQ(keeper.stored_environment(), room().texts);
  EXPECT_TRUE(KnowledgeStore(folder, KnowledgeStore::Access::read).verify().empty());
}

TEST_F(ModelKeeperTest, ABoxGrowsWithItsObject) {
  const object_model::ObjectBox tight = box_around({}, 0.2);
  const auto look = [&](ModelKeeper& keeper, int n) {
    const auto p = view(n);
    return keeper.integrate("ball", p.view_id, &p);
  };
  std::string digest;
  {
    ModelKeeper keeper(folder, {});
    keeper.set_environment(room());
    keeper.begin("ball", tight, 0.025, false);
    const auto result = look(keeper, 0);
    const auto grown = keeper.model("ball");
    EXPECT_FALSE(object_model::same_box(grown->state().box, tight));
    EXPECT_EQ(result.revision, grown->grid().revision);
    EXPECT_EQ(result.counts, grown->grid().counts());
    EXPECT_EQ(look(keeper, 0), result);
    EXPECT_EQ(grown->state().history.back().what, "box grown");
    // Begun alike, for whoever asks with the box it was begun with; another is another.
    EXPECT_EQ(keeper.begin("ball", tight, 0.025, false), grown);
    EXPECT_EQ(code_of([&] { keeper.begin("ball", grown->state().box, 0.025, false); }), ErrorCode::model_object_differs);
    for (int n = 1; n < 4; ++n) look(keeper, n);
    const auto all = keeper.model("ball");
    digest = all->digest();
    EXPECT_EQ(code_of([&] { keeper.revise("ball", {}, {"view-3"}); }), ErrorCode::ok);
    EXPECT_TRUE(object_model::same_box(keeper.model("ball")->state().box, all->state().box));
    look(keeper, 3);
  }
  ModelKeeper keeper(folder, {});
  keeper.set_environment(room());
  EXPECT_EQ(keeper.begin("ball", tight, 0.025, false)->digest(), digest);
  EXPECT_TRUE(object_model::same_box(keeper.begin("ball", tight, 0.025, true)->state().box, tight));

  ModelKeeper stays(folder + "/stays", {}, {.enabled = false});
  stays.set_environment(room());
  stays.begin("ball", tight, 0.025, false);
  look(stays, 0);
  EXPECT_TRUE(object_model::same_box(stays.model("ball")->state().box, tight));
}

// What stands on top of the ball in some pictures, and others refute: each such look carves all views in the larger box once.
TEST_F(ModelKeeperTest, ALookThatOthersRefuteCarvesItselfAlone) {
  static int carved = 0;
  ModelKeeper keeper(folder, {});
  keeper.set_environment(room());
  object_model::ObjectBox flat = box;
  flat.size.z() = 2 * Sphere{}.radius;
  keeper.begin("ball", flat, 0.01, false);
  const auto look = [&](const std::string& name, int n, bool needle) {
    auto p = ideal_view({}, n, 6, 160, 120);
    p.view_id = name;
    for (object_model::DepthMap& map : p.depth)
      for (int bead = 0; needle && bead < 4; ++bead) {
        const auto other = ideal_depth({{0, 0, 1.162 + 0.02 * bead}, 0.012}, map.X_WC, map.camera);
        for (std::size_t i = 0; i < other.depth.data.size(); ++i) {
          map.depth.data[i] = std::min(map.depth.data[i], other.depth.data[i]);
          map.depth_minimum.data[i] = std::min(map.depth_minimum.data[i], other.depth.data[i]);
        }
      }
    carved = 0;
    fault_hook() = [](const char* point) { carved += std::string_view(point) == "model.labelled"; };
    keeper.integrate("ball", name, &p);
    fault_hook() = nullptr;
    EXPECT_TRUE(object_model::same_box(keeper.model("ball")->state().box, flat));
    return carved;
  };
  for (int n : {0, 2, 3, 4, 5}) EXPECT_EQ(look("clear-" + std::to_string(n), n, false), 1);
  EXPECT_EQ(look("first", 1, true), 1 + 6);
  EXPECT_EQ(look("second", 1, true), 1 + 1);
  EXPECT_EQ(look("third", 1, true), 1 + 1);
}

// Or the object would be carved with solids that are not those of the environment that it is kept with.
TEST_F(ModelKeeperTest, AViewIsNotIntegratedInAnotherEnvironment) {
  ModelKeeper keeper(folder, {});
  keeper.set_environment(room());
  keeper.begin("ball", box, 0.025, false);
  const auto p0 = view(0), p1 = view(1);
  const auto first = keeper.integrate("ball", p0.view_id, &p0);
  keeper.set_environment(room("r2"));
  EXPECT_EQ(code_of([&] { keeper.integrate("ball", p1.view_id, &p1); }), ErrorCode::model_object_differs);
  EXPECT_FALSE(keeper.has_view("ball", p1.view_id));
  EXPECT_EQ(keeper.integrate("ball", p0.view_id, nullptr), first);  // answered as before
  keeper.set_environment(room());
  EXPECT_EQ(keeper.integrate("ball", p1.view_id, &p1).revision, 2u);
}

TEST_F(ModelKeeperTest, ViewsGetBetterPosesAndAreTakenOut) {
  std::string before, after;
  {
    ModelKeeper keeper(folder, {});
    keeper.set_environment(room());
    keeper.begin("ball", box, 0.025, false);
    for (int n = 0; n < 3; ++n) {
      const auto p = view(n);
      keeper.integrate("ball", p.view_id, &p);
    }
    const auto old = keeper.model("ball");
    before = old->digest();
    object_model::BetterPose better{"view-1", old->view("view-1")->X_WC, old->view("view-1")->covariance};
    EXPECT_EQ(keeper.revise("ball", {better}, {}), old);  // so it is already
    better.X_WC.translation().x() += 0.01;
    const auto moved = keeper.revise("ball", {better}, {});
    EXPECT_GT(moved->grid().revision, old->grid().revision);
    EXPECT_NE(moved->digest(), before);
    EXPECT_EQ(keeper.revise("ball", {better}, {}), moved);  // asked again
    const auto less = keeper.revise("ball", {}, {"view-2"});
    EXPECT_EQ(less->state().views.size(), 2u);
    EXPECT_EQ(keeper.revise("ball", {}, {"view-2"}), less);
    EXPECT_EQ(code_of([&] { keeper.revise("ball", {}, {"view-7"}); }), ErrorCode::bad_input);
    EXPECT_EQ(code_of([&] { keeper.revise("cube", {}, {}); }), ErrorCode::model_object_unknown);
    EXPECT_EQ(keeper.model("ball"), less);
    after = less->digest();
    std::string told;
    for (const auto& e : less->state().history) told += e.what + " " + e.detail + "; ";
    EXPECT_EQ(told, "begun environment r1; view integrated view-0; view integrated view-1; view integrated view-2; "
                    "view integrated again with a better pose view-1; view taken out view-2; ");
    keeper.set_environment(room("r2"));
    EXPECT_EQ(code_of([&] { keeper.revise("ball", {}, {"view-1"}); }), ErrorCode::model_object_differs);
  }
  ModelKeeper keeper(folder, {});
  EXPECT_EQ(keeper.model("ball")->digest(), after);
}

}  // namespace
}  // namespace periplus::model

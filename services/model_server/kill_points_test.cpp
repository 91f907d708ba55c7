// A server that is killed at any named point of an integration leaves a sound database with the view in flight or without it, and goes
// on to the very model of one that was never killed. The same of a copy of database and log (a power cut), with the log cut anywhere.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <tuple>

#include "common/core/error.h"
#include "common/core/fault_point.h"
#include "common/core/random.h"
#include "common/object_model/model_file.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/scene/scene.h"
#include "services/model_server/model_keeper.h"

namespace periplus::model {
namespace {

using namespace object_model::testing;
namespace fs = std::filesystem;

constexpr int kViews = 3, kKillsAPoint = 10;

std::set<std::string> reached;
std::string deadly;
int survived = 0;  // passes at the deadly point before the last

KnownTexts nowhere() {
  auto scene = std::make_shared<scene::Scene>();
  return {{"nowhere", "scene", "robot", "urdf"}, "r", scene, std::make_shared<scene::CollisionWorld>(*scene)};
}

// Takes up what is there and looks until all views are in.
std::string look_at_all(const std::string& folder, int* had = nullptr, double box_side = 0.5) {
  ModelKeeper keeper(folder, {});
  keeper.set_environment(nowhere());
  keeper.begin("ball", box_around({}, box_side), 0.05, false);
  if (had) *had = static_cast<int>(keeper.model("ball")->state().views.size());
  for (int n = 0; n < kViews; ++n) {
    const auto p = ideal_view({}, n, 4, 40, 30);
    keeper.integrate("ball", p.view_id, &p);
  }
  return keeper.model("ball")->digest();
}

// Killed at the point when it is passed for the last time of so many.
void die_at(const std::string& folder, const std::string& point, int passes, double box_side = 0.5) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    deadly = point;
    survived = passes;
    fault_hook() = [](const char* at) {
      if (deadly == at && --survived == 0) ::kill(::getpid(), SIGKILL);
    };
    look_at_all(folder, nullptr, box_side);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << point;
}

class KillPointsTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder); }
  void TearDown() override {
    fault_hook() = nullptr;
    fs::remove_all(folder);
  }
  // A fresh one, for each kill.
  std::string sub(const std::string& name) const {
    const std::string path = folder + "/" + name;
    fs::remove_all(path);
    return path;
  }
  const std::string folder = ::testing::TempDir() + "kill_points_test." + std::to_string(::getpid());
};

TEST_F(KillPointsTest, AtMostTheViewInFlightIsLost) {
  fault_hook() = [](const char* at) { reached.insert(at); };
  const std::string whole = look_at_all(sub("whole"));
  fault_hook() = nullptr;
  EXPECT_GE(reached.size(), 20u);
  Random random(5);
  int without = 0, with = 0;
  for (const std::string& point : reached) {
    for (int kill = 0; kill < kKillsAPoint; ++kill) {
      const int view = kill % kViews;  // of how many passes each is the last but those of begin() and set_environment()
      const std::string here = sub("killed");
      // Every transaction passes the store's commit: environment, model, then the views.
      const bool of_transactions = point == "store.before_commit" || point == "store.committed";
      const bool of_states = point == "store.state_packed" || point == "store.state_written";
      const int passes = view + 1 + (of_transactions ? 3 : of_states ? 1 : 0);
      die_at(here, point, passes);
      if (HasFatalFailure()) return;

      const std::string cut = sub("cut");
      fs::copy(here, cut);
      {
        const KnowledgeStore store(here);
        EXPECT_EQ(store.verify(), std::vector<std::string>()) << point;
        const auto views = static_cast<int>(store.model("ball")->state().views.size());
        EXPECT_TRUE(views == view || views == view + 1) << point << ": " << views << " views after being killed at view " << view + 1;
        (views == view ? without : with) += 1;
      }
      int had = 0;
      EXPECT_EQ(look_at_all(here, &had), whole) << point << " " << had;

      // Power goes while the log is being written: any tail of it is missing.
      const std::string log = cut + "/knowledge.sqlite-wal";
      if (fs::exists(log) && fs::file_size(log) > 0) fs::resize_file(log, random.below(fs::file_size(log)));
      try {
        EXPECT_EQ(KnowledgeStore(cut).verify(), std::vector<std::string>()) << point;
        EXPECT_EQ(look_at_all(cut), whole) << point;
      } catch (const Error& e) {
        ADD_FAILURE() << point << ": " << e.what();
      }
    }
  }
  EXPECT_GT(without, 100);
  EXPECT_GT(with, 10);
}

// The ball does not fit its box: the first view makes it grow, in the view's own transaction.
TEST_F(KillPointsTest, NorIsAModelThatGrows) {
  constexpr double kTight = 0.25;
  const std::string whole = look_at_all(sub("whole"), nullptr, kTight);
  for (const auto& [point, passes, views] : {std::tuple("keeper.grown", 1, 0), std::tuple("store.before_commit", 4, 0), std::tuple("store.committed", 4, 1)}) {
    const std::string here = sub("killed");
    die_at(here, point, passes, kTight);
    if (HasFatalFailure()) return;
    {
      const KnowledgeStore store(here);
      EXPECT_EQ(store.verify(), std::vector<std::string>()) << point;
      const auto model = store.model("ball");
      EXPECT_EQ(model->state().views.size(), static_cast<std::size_t>(views)) << point;
      EXPECT_EQ(object_model::same_box(model->state().box, box_around({}, kTight)), views == 0) << point;
    }
    EXPECT_EQ(look_at_all(here, nullptr, kTight), whole) << point;
  }
}

// Bytes of the file or of its log turned over: what verify() finds sound is what was written.
TEST_F(KillPointsTest, FlippedBytesAreFound) {
  const std::string here = sub("sound");
  object_model::ObjectModel model("ball", box_around({}), 0.02, {});
  for (int n = 0; n < kViews; ++n) model.integrate(ideal_view({}, n, 4, 160, 120), {}, {});
  const std::string whole = object_model::write_model(model);
  {
    KnowledgeStore store(here);
    store.put_environment(nowhere().texts);
    store.put_model(model);
  }
  const std::string file = here + "/knowledge.sqlite";
  Random random(9);
  int refused = 0, found = 0, untouched = 0;
  for (int round = 0; round < 150; ++round) {
    const std::string bad = sub("bad");
    fs::create_directories(bad);
    fs::copy_file(file, bad + "/knowledge.sqlite");
    {
      std::fstream f(bad + "/knowledge.sqlite", std::ios::in | std::ios::out | std::ios::binary);
      const auto at = static_cast<std::streamoff>(random.below(fs::file_size(file)));
      f.seekg(at);
      const char was = static_cast<char>(f.get());
      f.seekp(at);
      f.put(static_cast<char>(was ^ static_cast<char>(1 + random.below(255))));
    }
    try {
      const KnowledgeStore store(bad);
      const auto damaged = store.verify();
      if (!damaged.empty()) {
        ++found;
        store.models();  // must not crash
        continue;
      }
      const auto read = store.model("ball");
      ASSERT_TRUE(read.has_value());
      EXPECT_TRUE(object_model::write_model(*read) == whole) << "damage at round " << round << " was not found";
      ++untouched;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::model_store) << e.what();
      ++refused;
    }
  }
  // The last pages of what is kept are not full.
  EXPECT_GT(found, 100) << refused << " refused, " << untouched << " sound";
}

}  // namespace
}  // namespace periplus::model

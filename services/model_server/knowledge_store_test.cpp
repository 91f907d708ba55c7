#include "services/model_server/knowledge_store.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/core/error.h"
#include "common/object_model/model.pb.h"
#include "common/object_model/model_file.h"
#include "common/object_model/testing/older_form.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::model {
namespace {

using namespace object_model::testing;
namespace fs = std::filesystem;

class KnowledgeStoreTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder); }
  void TearDown() override { fs::remove_all(folder); }
  const std::string folder = ::testing::TempDir() + "knowledge_store_test." + std::to_string(::getpid());
};

object_model::ObjectModel begun(const std::string& id = "ball") { return {id, box_around({}), 0.025, {}}; }
void look(object_model::ObjectModel& model, int n) { model.integrate(ideal_view({}, n, 6, 80, 60), {}, {}); }

TEST_F(KnowledgeStoreTest, KeepsEnvironmentAndModels) {
  const EnvironmentTexts texts{"room", "scene", "robot: é", std::string("urdf\0with nul", 13)};
  object_model::ObjectModel model = begun();
  {
    KnowledgeStore store(folder);
    EXPECT_FALSE(store.environment().has_value());
    store.put_environment(texts);
    store.put_model(model);
    for (int n = 0; n < 3; ++n) {
      look(model, n);
      store.add_view(model);
    }
    store.put_model(begun("other"));
  }
  const KnowledgeStore store(folder);
  EXPECT_EQ(store.environment(), texts);
  const auto models = store.models();
  ASSERT_EQ(models.size(), 2u);
  EXPECT_EQ(models[0].digest(), model.digest());
  EXPECT_EQ(models[0].grid().revision, 3u);
  EXPECT_EQ(models[1].state().object_id, "other");
}

TEST_F(KnowledgeStoreTest, PuttingAModelReplacesTheOldOneWithItsViews) {
  KnowledgeStore store(folder);
  object_model::ObjectModel model = begun();
  store.put_model(model);
  look(model, 0);
  store.add_view(model);
  store.put_model(begun());
  EXPECT_EQ(store.models().at(0).state().views.size(), 0u);
}

TEST_F(KnowledgeStoreTest, AKilledServerLeavesWholeViews) {
  // The child integrates until it is killed in the midst; what is stored is then a whole number of views.
  int pipe_ends[2];
  ASSERT_EQ(::pipe(pipe_ends), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    KnowledgeStore store(folder);
    object_model::ObjectModel model = begun();
    store.put_model(model);
    for (int n = 0;; ++n) {
      auto p = ideal_view({}, n % 6, 6, 80, 60);
      p.view_id = "view-" + std::to_string(n);
      model.integrate(p, {}, {});
      store.add_view(model);
      const char octet = 1;
      if (::write(pipe_ends[1], &octet, 1) != 1) ::_exit(1);
    }
  }
  ::close(pipe_ends[1]);
  char octets[4];
  for (char& octet : octets) ASSERT_EQ(::read(pipe_ends[0], &octet, 1), 1);
  ::usleep(3000);
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  ::close(pipe_ends[0]);

  const KnowledgeStore store(folder);
  const auto models = store.models();
  ASSERT_EQ(models.size(), 1u);
  const auto& state = models[0].state();
  EXPECT_GE(state.views.size(), 4u);
  EXPECT_EQ(state.grid.revision, state.views.size());
  EXPECT_EQ(state.views.back()->result.counts, models[0].grid().counts());
}

TEST_F(KnowledgeStoreTest, ASecondServerIsRefused) {
  const KnowledgeStore store(folder);
  try {
    const KnowledgeStore second(folder);
    FAIL() << "two servers share one database";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::model_store);
  }
}

TEST_F(KnowledgeStoreTest, OthersReadWhileOneWrites) {
  try {
    KnowledgeStore(folder, KnowledgeStore::Access::read);
    ADD_FAILURE() << "nothing is there";
  } catch (const Error& e) {  // says where a run's own store is
    EXPECT_NE(std::string(e.what()).find("`periplus run` and `up`: knowledge"), std::string::npos) << e.what();
  }
  KnowledgeStore store(folder);
  object_model::ObjectModel model = begun();
  store.put_model(model);
  const KnowledgeStore reader(folder, KnowledgeStore::Access::read);
  EXPECT_EQ(reader.model("ball")->state().views.size(), 0u);
  look(model, 0);
  store.add_view(model);
  EXPECT_EQ(reader.model("ball")->digest(), model.digest());
  EXPECT_FALSE(reader.model("other").has_value());
  EXPECT_EQ(reader.verify(), std::vector<std::string>());
  EXPECT_TRUE(store.remove_model("ball"));
  EXPECT_FALSE(store.remove_model("ball"));
  EXPECT_FALSE(reader.model("ball").has_value());
}

TEST_F(KnowledgeStoreTest, WhatCannotBeWrittenIsReadAsItLies) {
  const std::string place = folder + "/100% #1?";
  object_model::ObjectModel model = begun();
  KnowledgeStore(place).put_model(model);
  const fs::path database = place + "/knowledge.sqlite";
  const auto lock = [&](bool writable) {
    const auto how = writable ? fs::perm_options::add : fs::perm_options::remove;
    fs::permissions(place, fs::perms::owner_write, how);
    fs::permissions(database, fs::perms::owner_write, how);
  };
  // As another user: nobody's, where the tests are root's.
  const auto read = [&](const std::string& says) {
    const pid_t child = ::fork();
    if (child == 0) {
      if (::getuid() == 0 && ::setuid(65534) != 0) ::_exit(9);
      try {
        const KnowledgeStore store(place, KnowledgeStore::Access::read);
        ::_exit(says.empty() && store.model("ball")->digest() == model.digest() && store.verify().empty() ? 0 : 1);
      } catch (const Error& e) {
        ::_exit(!says.empty() && std::string(e.what()).find(says) != std::string::npos ? 0 : 2);
      }
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  };
  lock(false);
  EXPECT_EQ(read(""), 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(place), {}), 2);  // database and lock
  lock(true);
  {
    KnowledgeStore server(place);
    server.put_model(model);
    lock(false);
    EXPECT_EQ(read(""), 0);  // the server's own index is used
    lock(true);
    fs::copy_file(place + "/knowledge.sqlite-wal", place + "/kept");
  }
  fs::rename(place + "/kept", place + "/knowledge.sqlite-wal");
  lock(false);
  EXPECT_EQ(read("copy knowledge.sqlite and knowledge.sqlite-wal"), 0);
  lock(true);
}

TEST_F(KnowledgeStoreTest, WhatVersion1WroteIsBroughtToThisForm) {
  object_model::ObjectModel model = begun();
  look(model, 0);
  look(model, 1);
  fs::create_directories(folder);
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder + "/knowledge.sqlite").c_str(), &db), SQLITE_OK);
  const auto run = [&](const std::string& sql, const std::vector<std::string>& blobs = {}) {
    sqlite3_stmt* statement = nullptr;
    ASSERT_EQ(sqlite3_prepare_v2(db, sql.c_str(), -1, &statement, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    for (std::size_t n = 0; n < blobs.size(); ++n) sqlite3_bind_blob(statement, static_cast<int>(n) + 1, blobs[n].data(), static_cast<int>(blobs[n].size()), SQLITE_TRANSIENT);
    EXPECT_EQ(sqlite3_step(statement), SQLITE_DONE) << sqlite3_errmsg(db);
    sqlite3_finalize(statement);
  };
  run("CREATE TABLE environment (one INTEGER PRIMARY KEY CHECK (one = 1), scene_id TEXT, scene_yaml TEXT, robot_yaml TEXT, robot_urdf TEXT)");
  run("CREATE TABLE objects (object_id TEXT PRIMARY KEY, state BLOB NOT NULL)");
  run("CREATE TABLE views (object_id TEXT, number INTEGER, view_id TEXT, view BLOB NOT NULL, PRIMARY KEY (object_id, number), UNIQUE (object_id, view_id))");
  run("INSERT INTO environment VALUES (1, 'room', 'scene', 'robot', 'urdf')");
  // A state without version and references is version 1's.
  proto::Model state;
  ASSERT_TRUE(state.ParseFromString(object_model::write_state(model, {"", ""})));
  state.clear_version();
  object_model::testing::put_every_voxel(model, state);
  state.clear_references();
  run("INSERT INTO objects VALUES ('ball', ?)", {state.SerializeAsString()});
  for (int n = 0; n < 2; ++n) {
    proto::View view;
    ASSERT_TRUE(view.ParseFromString(object_model::write_view(*model.state().views[static_cast<std::size_t>(n)])));
    *view.mutable_depth() = view.depth_maps(0).depth();
    view.set_depth_width(view.width());
    view.set_depth_height(view.height());
    view.clear_depth_maps();
    run("INSERT INTO views VALUES ('ball', " + std::to_string(n) + ", 'view-" + std::to_string(n) + "', ?)", {view.SerializeAsString()});
  }
  run("INSERT INTO objects VALUES ('broken', ?)", {"nonsense"});
  run("PRAGMA user_version = 1");
  sqlite3_close(db);

  EXPECT_THROW(KnowledgeStore(folder, KnowledgeStore::Access::read), Error);
  const KnowledgeStore store(folder);
  EXPECT_EQ(store.environment()->scene_yaml, "scene");
  EXPECT_EQ(store.model("ball")->digest(), model.digest());
  EXPECT_FALSE(store.model("ball")->can_be_revised());
  const auto damaged = store.verify();
  ASSERT_EQ(damaged.size(), 1u);
  EXPECT_NE(damaged[0].find("broken"), std::string::npos);
}

TEST_F(KnowledgeStoreTest, WhatIsNotADatabaseIsRefused) {
  fs::create_directories(folder);
  std::ofstream(folder + "/knowledge.sqlite") << std::string(5000, 'x');
  for (const auto access : {KnowledgeStore::Access::write, KnowledgeStore::Access::read}) {
    try {
      const KnowledgeStore store(folder, access);
      FAIL() << "text is taken for a database";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::model_store);
      EXPECT_NE(std::string(e.what()).find("the file is damaged"), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW(KnowledgeStore{"/proc/nowhere"}, Error);
}

}  // namespace
}  // namespace periplus::model

// periplus-model as a person runs it, on a store that a keeper filled.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/file.h"
#include "common/object_model/model_file.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/scene/scene.h"
#include "services/model_server/model_keeper.h"

namespace periplus::model {
namespace {

using namespace object_model::testing;
namespace fs = std::filesystem;

struct Answer {
  int status = -1;
  std::string out, err;
};

class ModelProgram : public ::testing::Test {
 protected:
  ModelProgram() : folder_(fs::temp_directory_path() / ("periplus_model_program_test_" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    ModelKeeper keeper(store(), {});
    const EnvironmentTexts texts{"room", "schema: periplus-scene-1\nname: room\nsolids:\n  - {name: floor, shape: box, size_m: [4, 4, 0.1], position_m: [0, 0, -0.05]}\n", "robot", "urdf"};
    auto scene = std::make_shared<const scene::Scene>(scene::parse_scene(texts.scene_yaml, "room"));
    keeper.set_environment({texts, scene::environment_revision(texts), scene, std::make_shared<scene::CollisionWorld>(*scene)});
    keeper.begin("ball", box_around({}), 0.025, false);
    for (int n = 0; n < 3; ++n) {
      const auto p = ideal_view({}, n, 4, 80, 60);
      keeper.integrate("ball", p.view_id, &p);
    }
    digest_ = keeper.model("ball")->digest();
  }
  ~ModelProgram() override { fs::remove_all(folder_); }

  std::string store() const { return (folder_ / "store").string(); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  Answer run(const std::string& verb, const std::string& arguments = "") const {
    const std::string command = "cd " + folder_.string() + " && " + PERIPLUS_BIN_DIR + "/periplus-model " + verb + " --store " + store() + " " + arguments + " 2>" + file("err");
    Answer r;
    FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return r;
    char buffer[4096];
    for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) r.out.append(buffer, n);
    const int status = ::pclose(pipe);
    r.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    r.err = read_file(file("err"));
    return r;
  }
  void refused(const Answer& r, const std::string& says) const {
    EXPECT_EQ(r.status, 2) << r.out << r.err;
    EXPECT_NE(r.err.find(says), std::string::npos) << r.err;
  }

  const fs::path folder_;
  std::string digest_;
};

TEST_F(ModelProgram, ListsAndShows) {
  const auto listed = nlohmann::json::parse(run("list", "--json").out);
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0]["object"], "ball");
  EXPECT_EQ(listed[0]["views"], 3);
  EXPECT_EQ(listed[0]["digest"], digest_);
  EXPECT_NE(run("list").out.find("ball"), std::string::npos);
  const auto shown = nlohmann::json::parse(run("show", "ball --json").out);
  EXPECT_EQ(shown["view"].size(), 3u);
  EXPECT_EQ(shown["view"][2]["revision"], shown["revision"]);
  EXPECT_EQ(shown["history"].back()["detail"], "view-2");
  EXPECT_TRUE(shown["can_be_revised"]);
  const std::string text = run("show").out;
  for (const char* word : {"view-0", "view-2", "begun", "20 x 20 x 20 voxels of 25 mm"}) EXPECT_NE(text.find(word), std::string::npos) << word << " not in\n" << text;
  EXPECT_EQ(run("digest").out, digest_ + "  ball\n");
  refused(run("show", "cube"), "no object cube is stored");
}

TEST_F(ModelProgram, WhatGoesOutComesBackIn) {
  EXPECT_EQ(run("export", "ball --format periplus -o " + file("ball.periplus")).status, 0);
  EXPECT_EQ(object_model::load_model(file("ball.periplus")).digest(), digest_);
  for (const char* format : {"ply", "obj", "glb", "bt", "ot", "pcd", "features.csv"}) {
    const Answer r = run("export", std::string("--format ") + format);
    EXPECT_EQ(r.status, 0) << format << r.err;
  }
  EXPECT_TRUE(fs::exists(file("ball.bt")));
  refused(run("export", "--format docx"), "periplus");

  refused(run("import", file("ball.periplus")), "stored already");
  EXPECT_EQ(run("import", file("ball.periplus") + " --name copy").status, 0);
  EXPECT_EQ(run("digest", "copy").out, digest_ + "  copy\n");
  EXPECT_EQ(run("import", file("ball.bt") + " --name tree").status, 0);
  EXPECT_EQ(run("import", file("ball.pcd") + " --name cloud --voxel 0.025").status, 0);
  fs::copy_file(file("ball.bt"), file("OLD.BT"));
  EXPECT_EQ(run("import", "OLD.BT").status, 0);
  EXPECT_EQ(run("delete", "OLD --yes").status, 0);
  refused(run("digest"), "which object?");
  refused(run("import", file("ball.ply")), ".periplus, .bt or .pcd");
  refused(run("import", file("ball.pcd") + " --name no/name"), "--name");
  const auto listed = nlohmann::json::parse(run("list", "--json").out);
  ASSERT_EQ(listed.size(), 4u);
  EXPECT_EQ(listed[3]["object"], "tree");
  EXPECT_TRUE(listed[3]["imported"]);
  EXPECT_GT(listed[1]["counts"]["known"], 100);
  EXPECT_EQ(run("verify").status, 0);
}

TEST_F(ModelProgram, WritesThroughLinksAndIntoPipes) {
  std::ofstream(file("behind.ply")) << "old";
  fs::create_symlink(file("behind.ply"), file("link.ply"));
  EXPECT_EQ(run("export", "-o link.ply").status, 0);
  EXPECT_TRUE(fs::is_symlink(file("link.ply")));
  const std::string written = read_file(file("behind.ply"));
  EXPECT_TRUE(written.starts_with("ply\n"));
  EXPECT_EQ(run("export", "-o /proc/self/fd/1").out, written);  // as /dev/stdout
  fs::create_directories(file("folder"));
  refused(run("export", "-o folder"), "cannot write folder");
  EXPECT_TRUE(fs::is_empty(file("folder")));
}

TEST_F(ModelProgram, ImportsUnderNamesThatServicesTake) {
  EXPECT_EQ(run("export", "--format periplus").status, 0);
  object_model::ModelState state = object_model::load_model(file("ball.periplus")).state();
  fs::copy_file(file("ball.periplus"), file("ball (1).periplus"));
  EXPECT_EQ(run("delete", "ball --yes").status, 0);
  EXPECT_EQ(run("import", "'ball (1).periplus'").status, 0);
  EXPECT_EQ(run("digest").out, digest_ + "  ball\n");
  // A stranger's file may say any name; one that is a path would be written to by `export`.
  state.object_id = "../ball";
  std::ofstream(file("other.periplus"), std::ios::binary) << object_model::write_model(object_model::ObjectModel(state));
  refused(run("import", "other.periplus"), "--name");
  refused(run("import", "other.periplus --name .."), "--name");
  EXPECT_EQ(run("import", "other.periplus --name other").status, 0);
}

TEST_F(ModelProgram, ImportedModelsAloneAreNotCarvedAgain) {
  EXPECT_EQ(run("export", "--format bt").status, 0);
  fs::remove_all(store());  // with its environment
  EXPECT_EQ(run("import", "ball.bt").status, 0);
  const Answer r = run("verify", "--recarve");
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_NE(r.out.find("ball: cannot be carved again here"), std::string::npos) << r.out;
}

TEST_F(ModelProgram, VerifiesAndCarvesAgain) {
  const Answer sound = run("verify", "--recarve");
  EXPECT_EQ(sound.status, 0) << sound.out << sound.err;
  EXPECT_NE(sound.out.find("ball: carved again, the same grid"), std::string::npos) << sound.out;
  EXPECT_EQ(run("take-out", "ball view-1").status, 0);
  const auto shown = nlohmann::json::parse(run("show", "ball --json").out);
  EXPECT_EQ(shown["view"].size(), 2u);
  EXPECT_EQ(shown["history"].back()["what"], "view taken out");
  EXPECT_EQ(run("verify", "--recarve").status, 0);
  refused(run("take-out", "ball view-1"), "no view view-1");
  // A byte of what is kept, turned over.
  const std::string database = store() + "/knowledge.sqlite";
  std::string bytes = read_file(database);
  for (std::size_t at = bytes.size() / 4; at < bytes.size(); at += 4096) bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
  std::ofstream(database, std::ios::binary) << bytes;
  const Answer damaged = run("verify");
  EXPECT_EQ(damaged.status, 1) << damaged.out << damaged.err;
  EXPECT_NE(damaged.out.find("damaged: "), std::string::npos);
  EXPECT_EQ(run("list").status, 1);
}

TEST_F(ModelProgram, ADamagedHeaderIsDamage) {
  const std::string database = store() + "/knowledge.sqlite", whole = read_file(database);
  for (const std::size_t at : {0u, 16u, 18u, 19u, 28u, 60u, 61u}) {  // name, size of a page, two versions, size in pages, our own version
    for (const char mask : {'\x01', '\x55', '\xff'}) {
      std::string bytes = whole;
      bytes[at] = static_cast<char>(bytes[at] ^ mask);
      std::ofstream(database, std::ios::binary) << bytes;
      const Answer r = run("verify");
      EXPECT_EQ(r.status, 1) << at << " " << int{mask} << r.out << r.err;
      EXPECT_NE((r.out + r.err).find("damaged"), std::string::npos) << at << r.out << r.err;
    }
  }
}

TEST_F(ModelProgram, DeletesOnlyWhatIsMeant) {
  refused(run("delete", "ball"), "--yes");
  refused(run("delete", "cube --yes"), "no object cube");
  EXPECT_EQ(run("delete", "ball --yes").status, 0);
  EXPECT_EQ(run("list").out, "no object is stored\n");
}

TEST_F(ModelProgram, ReadsButDoesNotChangeWhatAServerUses) {
  const KnowledgeStore server(store());
  EXPECT_EQ(run("list").status, 0);
  refused(run("delete", "ball --yes"), "stop it first");
  fs::create_directories(file("empty"));
  EXPECT_EQ(run("list", "--store " + file("empty")).status, 2);
}

}  // namespace
}  // namespace periplus::model

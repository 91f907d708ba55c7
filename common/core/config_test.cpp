#include "common/core/config.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "common/core/error.h"

namespace periplus::config {
namespace {

std::string message_of(const std::function<void()>& action, ErrorCode code = ErrorCode::bad_input) {
  try {
    action();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), code);
    return e.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

TEST(Config, ReadsEveryType) {
  const Node root = parse("flag: true\ncount: -3\nseed: 18446744073709551615\nrange_m: 2.5e0\nname: \"42\"\nhere: [1, 2]\nsize: [1, 2.5, -3]\n"
                          "many: [4, 5, 6, 7]\nnames: [a, b c]\nmode: fast\n",
                          "x.yaml");
  bool flag = false;
  int count = 0;
  std::uint64_t seed = 0;
  double range = 0;
  std::string name, mode = "slow";
  Eigen::Vector2d here;
  Eigen::Vector3d size;
  std::vector<double> many;
  std::vector<std::string> names;
  EXPECT_TRUE(root.read("flag", flag) && root.read("count", count) && root.read("seed", seed) && root.read("range_m", range));
  EXPECT_TRUE(root.read("name", name) && root.read("here", here) && root.read("size", size) && root.read("many", many));
  EXPECT_TRUE(root.read("names", names) && root.read_choice("mode", mode, {"fast", "slow"}));
  EXPECT_TRUE(flag);
  EXPECT_EQ(count, -3);
  EXPECT_EQ(seed, 18446744073709551615ull);
  EXPECT_EQ(range, 2.5);
  EXPECT_EQ(name, "42");
  EXPECT_EQ(here, Eigen::Vector2d(1, 2));
  EXPECT_EQ(size, Eigen::Vector3d(1, 2.5, -3));
  EXPECT_EQ(many, (std::vector<double>{4, 5, 6, 7}));
  EXPECT_EQ(names, (std::vector<std::string>{"a", "b c"}));
  EXPECT_EQ(mode, "fast");
  root.finish();
}

TEST(Config, AnAbsentKeyKeepsTheDefault) {
  const Node root = parse("", "x.yaml");
  double range = 2.5;
  EXPECT_FALSE(root.read("range_m", range));
  EXPECT_EQ(range, 2.5);
  EXPECT_EQ(message_of([&] { root.get<double>("range_m"); }), "x.yaml: the key 'range_m' is missing; add it");
  EXPECT_FALSE(root.child("camera").has("width"));
  EXPECT_TRUE(root.children("solids").empty());
  root.finish();
}

TEST(Config, AnUnknownKeyNamesTheNearestKnownOne) {
  const Node root = parse("search:\n  seed: 4\n  evalautions: 3\n", "nbv.yaml");
  const Node search = root.child("search");
  int evaluations = 0, seed = 0;
  search.read("seed", seed);
  search.read("evaluations", evaluations);
  EXPECT_EQ(message_of([&] { root.finish(); }), "nbv.yaml:3: search.evalautions: unknown key; the nearest known one is 'evaluations'");
  EXPECT_EQ(message_of([&] { search.finish(); }), "nbv.yaml:3: search.evalautions: unknown key; the nearest known one is 'evaluations'");
}

TEST(Config, LooksIntoTheElementsOfLists) {
  const Node root = parse("solids:\n  - name: table\n  - nmae: wall\n", "scene.yaml");
  for (const Node& solid : root.children("solids")) {
    std::string name;
    solid.read("name", name);
  }
  EXPECT_EQ(message_of([&] { root.finish(); }), "scene.yaml:3: solids[1].nmae: unknown key; the nearest known one is 'name'");
}

TEST(Config, WrongTypesSayWhatIsExpectedAndWhere) {
  const Node root = parse("a: three\nb: [1, 2]\nc: .nan\nd: 1e999\ne: yes\nf: 7\ng: \"7\"\nh:\ni: {x: 1}\nj: 7.5\n", "t.yaml");
  int i = 0;
  double d = 0;
  bool b = false;
  std::string s;
  Eigen::Vector3d v;
  EXPECT_EQ(message_of([&] { root.read("a", d); }), "t.yaml:1: a: expected a finite number, found 'three'");
  EXPECT_EQ(message_of([&] { root.read("b", v); }), "t.yaml:2: b: expected a list of 3 finite numbers, found 2");
  message_of([&] { root.read("c", d); });
  message_of([&] { root.read("d", d); });
  message_of([&] { root.read("e", b); });
  EXPECT_EQ(message_of([&] { root.read("f", d, {.minimum = 0, .maximum = 5}); }), "t.yaml:6: f: expected a finite number from 0 to 5, found 7");
  message_of([&] { root.read("f", i, {.maximum = 6}); });
  message_of([&] { root.read("g", i); });
  EXPECT_EQ(message_of([&] { root.read("h", s); }), "t.yaml:8: h: has no value; expected a text");
  message_of([&] { root.read("i", s); });
  message_of([&] { root.read("j", i); });
  message_of([&] { root.child("a"); });
  message_of([&] { root.children("i"); });
  EXPECT_EQ(message_of([&] { root.read_choice("a", s, {"one", "two"}); }), "t.yaml:1: a: expected one of one, two; found 'three'");
  EXPECT_EQ(d, 0);
}

TEST(Config, RefusesWhatIsNoConfiguration) {
  message_of([] { parse("a: [1, 2", "x"); });
  message_of([] { parse("- 1\n- 2\n", "x"); });
  message_of([] { parse("just text", "x"); });
  EXPECT_EQ(message_of([] { parse("a: 1\na: 2\n", "x"); }), "x:2: the key 'a' stands here twice; keep one");
  EXPECT_NE(message_of([] { parse("a: &n 1\nb: 2\n", "x"); }).find("anchors"), std::string::npos);
  EXPECT_NE(message_of([] { parse("&n a: 1\n", "x"); }).find("anchors"), std::string::npos);
  message_of([] { parse("a: 1\nb: *n\n", "x"); });
  message_of([] { parse("a: !!python/object:os.system 1\nb: !mine 3\n", "x"); });
  message_of([] { parse("a: 1\n---\nb: 2\n", "x"); });
  message_of([] { parse("[a, b]: 1\n", "x"); });
  message_of([] { parse("a: " + std::string(100, '[') + std::string(100, ']'), "x"); });
  message_of([] { parse("a: " + std::string(100000, '['), "x"); });
  message_of([] { parse(std::string((4u << 20) + 1, ' '), "x"); });
}

TEST(Config, ManyKeysOfAMappingAreRefusedBeforeTheyTakeTime) {
  std::string text;
  for (int n = 0; n < 200000; ++n) text += "k" + std::to_string(n) + ": 1\n";
  try {
    parse(text, "t.yaml");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input);
    EXPECT_STREQ(e.what(), "t.yaml:1025: a mapping may have at most 1024 keys");
  }
}

TEST(Config, TextsAreUtf8) {
  for (const char* good : {"é", "ü/日本", "\U0001F600", "\uFFFD"}) {
    std::string value;
    EXPECT_TRUE(parse(std::string("path: a") + good, "t.yaml").read("path", value));
    EXPECT_EQ(value, std::string("a") + good);
  }
  for (const char* bad : {"\xe9", "\xff", "\x80", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe6\x97"}) {
    try {
      parse(std::string("name: x\npath: a") + bad, "t.yaml");
      FAIL() << bad;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::bad_input);
      EXPECT_STREQ(e.what(), "t.yaml:2: is not UTF-8; write it in that encoding");
    }
  }
}

TEST(Config, CommandLineOverridesCreateAndReplace) {
  Node root = parse("search: {seed: 4}\n", "x.yaml");
  set(root, "search.seed", "5");
  set(root, "search.box.size", "[1, 2, 3]");
  set(root, "name", "a: b");  // stays text for a reader of mappings only
  EXPECT_EQ(root.child("search").get<int>("seed"), 5);
  EXPECT_EQ(root.child("search").child("box").get<Eigen::Vector3d>("size"), Eigen::Vector3d(1, 2, 3));
  set(root, "search.seed", "nine");
  EXPECT_EQ(message_of([&] { root.child("search").get<int>("seed"); }), "command line: search.seed: expected a whole number, found 'nine'");
  message_of([&] { set(root, "search.seed.deeper", "1"); });
  message_of([&] { set(root, "", "1"); });
  message_of([&] { set(root, "a..b", "1"); });
}

TEST(Config, OverlayJoinsMappingsAndReplacesTheRest) {
  Node base = parse("a: {x: 1, y: 2}\nlist: [1, 2]\n", "base.yaml");
  overlay(base, parse("a: {y: 3, z: 4}\nlist: [5]\n", "mine.yaml"));
  const Node a = base.child("a");
  EXPECT_EQ(a.get<int>("x"), 1);
  EXPECT_EQ(a.get<int>("y"), 3);
  EXPECT_EQ(a.get<int>("z"), 4);
  EXPECT_EQ(base.get<std::vector<double>>("list"), std::vector<double>{5});
  EXPECT_EQ(message_of([&] { a.get<bool>("y"); }), "mine.yaml:1: a.y: expected true or false, found '3'");
}

TEST(Config, TextReadsBackTheSame) {
  const Node root = parse("b: \"1\"\na: {x: 1, list: [1, 2], deep: [{p: q}]}\nempty:\nodd: 'it''s: # so'\n", "x.yaml");
  const Node again = parse(root.text(), "again");
  EXPECT_EQ(again.text(), root.text());
  EXPECT_EQ(again.keys(), (std::vector<std::string>{"b", "a", "empty", "odd"}));
  EXPECT_EQ(again.get<std::string>("odd"), "it's: # so");
  int number = 0;
  message_of([&] { again.read("b", number); });  // a quoted number stays text
}

TEST(Config, LoadFileSaysWhatIsWrongWithTheFile) {
  const auto folder = std::filesystem::temp_directory_path() / ("periplus_config_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "good.yaml") << "a: 1\n";
  std::ofstream(folder / "empty.yaml");
  std::ofstream(folder / "huge.yaml") << std::string((4u << 20) + 1, '#');
  EXPECT_EQ(load_file(folder / "good.yaml").get<int>("a"), 1);
  EXPECT_TRUE(load_file(folder / "empty.yaml").keys().empty());
  message_of([&] { load_file(folder / "huge.yaml"); });
  message_of([&] { load_file(folder / "absent.yaml"); }, ErrorCode::io);
  message_of([&] { load_file(folder); }, ErrorCode::io);
  std::filesystem::remove_all(folder);
}

TEST(Config, NearestFindsSwappedAndMissingLetters) {
  EXPECT_EQ(nearest("staus", {"start", "status", "watch"}), "status");
  EXPECT_EQ(nearest("dcotor", {"down", "doctor"}), "doctor");
  EXPECT_EQ(nearest("anything", {}), "");
  EXPECT_EQ(nearest(std::string(257, 'a'), {"a"}), "");
}

}  // namespace
}  // namespace periplus::config

#include "services/model_server/tool/model_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/object_model/testing/sphere_views.h"

namespace periplus::model {
namespace {

using namespace object_model::testing;

object_model::ObjectModel seen() {
  object_model::ObjectModel m("ball", box_around({}), 0.05, {});
  for (int n = 0; n < 2; ++n) m.integrate(ideal_view({}, n, 4, 40, 30), {}, {});
  return m;
}

TEST(ModelText, ListsALineEachBelowTheNames) {
  EXPECT_EQ(list_text({}), "no object is stored\n");
  const auto m = seen();
  const std::string text = list_text({m, m});
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
  const std::string row = text.substr(text.find('\n') + 1, text.find('\n', text.find('\n') + 1) - text.find('\n'));
  EXPECT_NE(row.find(std::to_string(m.grid().counts().unknown)), std::string::npos) << row;
}

TEST(ModelText, WhatIsNoTextIsShownAsQuestionMarks) {
  auto m = seen();
  m.note({1764201600000000000, "looked\x1b[2J", "a\nb\xff", 2, "0.1.0"});
  const std::string text = show_text(m);
  EXPECT_NE(text.find("2025-11-27T00:00:00Z  revision 2    looked?[2J  a?b?  (periplus 0.1.0)"), std::string::npos) << text;
  EXPECT_EQ(show_json(m)["history"][0]["detail"], "a?b?");
  EXPECT_FALSE(show_json(m).dump().empty());  // would throw for what is not UTF-8
}

TEST(ModelText, JsonHasEachViewsPose) {
  const auto m = seen();
  const nlohmann::json j = show_json(m);
  ASSERT_EQ(j["view"].size(), 2u);
  EXPECT_EQ(j["view"][1]["pose_world_camera"][2][3].get<double>(), m.state().views[1]->X_WC.translation().z());
  EXPECT_EQ(j["counts"]["known"], m.grid().counts().known);
  EXPECT_EQ(list_json({m})[0]["digest"], m.digest());
}

}  // namespace
}  // namespace periplus::model

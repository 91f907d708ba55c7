#include "integration-tests/nbv_benchmark/html_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "integration-tests/nbv_benchmark/report.h"

namespace periplus::nbv_benchmark {
namespace {

// A result made by hand: the second planner never gets to 90 %, neither to 99 %.
BenchmarkResult two_planners() {
  BenchmarkResult r;
  SettingResult s;
  s.setting = {PoseSet::free, SensorKind::ideal, Camera::single, {"ours", "random"}};
  ObjectResult o;
  o.object = "<cup & saucer>";
  o.sha256 = std::string(64, 'a');
  for (const auto& [planner, curve] : {std::pair{"ours", std::vector<double>{0.4, 0.92, 0.96}}, std::pair{"random", std::vector<double>{0.4, 0.5, 0.8}}}) {
    nbv_benchmark::Run run;
    run.object = o.object;
    run.planner = planner;
    for (const double c : curve) {
      ViewRecord v;
      v.all = v.visible = c;
      run.views.push_back(v);
    }
    o.runs.push_back(run);
  }
  s.objects.push_back(o);
  r.settings.push_back(s);
  return r;
}

TEST(HtmlPage, SaysWhatIsNotReachableAndNeedsNothingFromOutside) {
  const nlohmann::json report = to_json(two_planners(), {}, provenance("test"));
  const nlohmann::json& runs = report.at("settings").at(0).at("objects").at(0).at("runs");
  EXPECT_EQ(runs.at(0).at("views_to").at("visible").at("90"), 2);
  EXPECT_EQ(runs.at(1).at("views_to").at("visible").at("90"), "> 3");
  EXPECT_EQ(runs.at(0).at("views_to").at("visible").at("99"), "not reachable");
  const std::string page = html_page(report);
  EXPECT_NE(page.find("2 / 3 / not reachable"), std::string::npos);
  EXPECT_NE(page.find("&gt; 3 / &gt; 3 / not reachable"), std::string::npos);
  EXPECT_NE(page.find("&lt;cup &amp; saucer&gt;"), std::string::npos);
  EXPECT_EQ(page.find("<cup"), std::string::npos);
  for (const char* outside : {"http://", "https://", "<script", "src=", "@import", "url("}) EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  EXPECT_EQ(page.find("nan"), std::string::npos);
}

TEST(HtmlPage, TheCsvHasALineAView) {
  const std::string csv = to_csv(two_planners());
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 6);
  EXPECT_NE(csv.find("free,ideal,single,<cup & saucer>,ours,2,-1,0.920000"), std::string::npos);
}

}  // namespace
}  // namespace periplus::nbv_benchmark

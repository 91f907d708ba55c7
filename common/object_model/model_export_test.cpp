#include "common/object_model/model_export.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "common/core/error.h"
#include "common/object_model/testing/exported_model.h"

namespace periplus::object_model {
namespace {

using namespace testing;

TEST(ModelExport, EveryFormatIsWrittenAndAnUnknownOneNamesThem) {
  const ObjectModel model = model_of({});
  for (const ExportFormat& format : export_formats()) EXPECT_GT(export_model(model, format.name).size(), 1000u) << format.name;
  EXPECT_EQ(export_model(model, "ply"), export_ply(model));
  EXPECT_EQ(export_model(model, "bt"), export_bt(model));
  EXPECT_EQ(export_model(model, "periplus").substr(0, 17), "PERIPLUS-MODEL 4\n");
  try {
    export_model(model, "stl");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    for (const ExportFormat& format : export_formats()) EXPECT_NE(std::string(error.what()).find(format.name), std::string::npos);
  }
}

TEST(ModelExport, AModelThatHasSeenNothingIsWrittenToo) {
  const ObjectModel model("unseen", box_around({}), 0.05, {});
  for (const ExportFormat& format : export_formats()) EXPECT_FALSE(export_model(model, format.name).empty()) << format.name;
}

TEST(ModelExport, FeaturesAreOneLineEach) {
  const ObjectModel model = model_of({});
  const std::string csv = features_csv(model);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 4 * 5);
  const Feature& first = model.state().views[0]->features[0];
  std::istringstream in(csv);
  std::string line;
  std::getline(in, line);
  const auto columns = std::count(line.begin(), line.end(), ',');
  while (std::getline(in, line)) EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns);
  double x = 0;
  const std::size_t start = csv.find("\"view-0\"");
  ASSERT_NE(start, std::string::npos);
  ASSERT_EQ(std::sscanf(&csv[start], "\"view-0\",%*f,%*f,%*f,%*f,%lf", &x), 1);
  EXPECT_EQ(x, first.p_W.x());
  EXPECT_NE(csv.find(",root_sift," + std::string(256, '0') + "\r\n"), std::string::npos);
}

}  // namespace
}  // namespace periplus::object_model

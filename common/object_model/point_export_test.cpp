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

TEST(PointExport, PcdAndPointsHoldOneRecordAKnownVoxel) {
  const ObjectModel model = model_of({});
  const SurfacePoints cloud = surface_points(model);
  const std::string pcd = to_pcd(cloud), ply = to_ply(cloud);
  const std::size_t data = pcd.find("DATA binary\n") + 12, body = ply.find("end_header\n") + 11;
  ASSERT_EQ(pcd.size(), data + 28 * cloud.points.size());
  ASSERT_EQ(ply.size(), body + 27 * cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    EXPECT_EQ(number_at<float>(pcd, data + 28 * i), cloud.points[i].x());
    EXPECT_EQ(number_at<std::uint8_t>(pcd, data + 28 * i + 14), cloud.colors[i][0]);
    EXPECT_EQ(number_at<float>(pcd, data + 28 * i + 24), cloud.normals[i].z());
    EXPECT_EQ(number_at<float>(ply, body + 27 * i + 20), cloud.normals[i].z());
    EXPECT_EQ(number_at<std::uint8_t>(ply, body + 27 * i + 24), cloud.colors[i][0]);
  }
}

}  // namespace
}  // namespace periplus::object_model

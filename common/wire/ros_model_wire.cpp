#include "common/wire/ros_model_wire.h"

#include <bit>
#include <cstring>

#include "common/wire/perception_wire.h"

namespace periplus::wire {

static_assert(std::endian::native == std::endian::little, "points are written as they lie in memory");

namespace {

constexpr std::uint8_t kFloat32 = 7;  // sensor_msgs/PointField

template <class Message>
void set_header(Message& m, std::int64_t stamp_ns, const std::string& frame_id) {
  m.header().stamp(stamp_to_wire(stamp_ns));
  m.header().frame_id(frame_id);
}

}  // namespace

octomap_msgs::msg::dds_::Octomap_ octomap_to_wire(std::int64_t stamp_ns, const std::string& frame_id, double resolution, std::string_view data) {
  octomap_msgs::msg::dds_::Octomap_ m;
  set_header(m, stamp_ns, frame_id);
  m.binary(true);
  m.id("OcTree");
  m.resolution(resolution);
  m.data().assign(data.begin(), data.end());
  return m;
}

sensor_msgs::msg::dds_::PointCloud2_ to_wire(std::int64_t stamp_ns, const std::string& frame_id, const object_model::SurfacePoints& cloud) {
  sensor_msgs::msg::dds_::PointCloud2_ m;
  set_header(m, stamp_ns, frame_id);
  std::uint32_t step = 0;
  for (const char* name : {"x", "y", "z", "rgb", "normal_x", "normal_y", "normal_z"}) {
    sensor_msgs::msg::dds_::PointField_ field;
    field.name(name);
    field.offset(step);
    field.datatype(kFloat32);
    field.count(1);
    m.fields().push_back(field);
    step += sizeof(float);
  }
  const std::size_t points = cloud.points.size();
  m.height(1);
  m.width(static_cast<std::uint32_t>(points));
  m.is_bigendian(false);
  m.point_step(step);
  m.row_step(static_cast<std::uint32_t>(points * step));
  m.is_dense(true);
  m.data().resize(points * step);
  for (std::size_t i = 0; i < points; ++i) {
    const auto& [r, g, b] = cloud.colors[i];
    const float rgb = std::bit_cast<float>(std::uint32_t{r} << 16 | std::uint32_t{g} << 8 | b);
    const Eigen::Vector3f &p = cloud.points[i], &n = cloud.normals[i];
    const float values[] = {p.x(), p.y(), p.z(), rgb, n.x(), n.y(), n.z()};
    std::memcpy(m.data().data() + i * step, values, sizeof values);
  }
  return m;
}

}  // namespace periplus::wire

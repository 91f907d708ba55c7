// Models for ROS 2 tools: octomap_msgs and point clouds, as their own readers take them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/object_model/model_export.h"
#include "idl/ros2.h"

namespace periplus::wire {

// What octomap_msgs::binaryMsgToMap makes an octomap::OcTree of. `data` of object_model::octomap_data; resolution [m].
octomap_msgs::msg::dds_::Octomap_ octomap_to_wire(std::int64_t stamp_ns, const std::string& frame_id, double resolution, std::string_view data);

// Unorganised: fields x, y, z [m], rgb (0x00rrggbb in the bits of a float, as PCL packs it), normal_x, normal_y, normal_z.
sensor_msgs::msg::dds_::PointCloud2_ to_wire(std::int64_t stamp_ns, const std::string& frame_id, const object_model::SurfacePoints& cloud);

}  // namespace periplus::wire

#include "common/wire/perception_wire.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/core/error.h"
#include "common/geometry/checks.h"
#include "common/wire/common_wire.h"

namespace periplus::wire {

namespace {

constexpr double kFarthest = 100;  // [m]
constexpr std::size_t kMostFeatures = 8192, kMostJoints = 1024, kMostDistortion = 14;

ImageF plane(const std::vector<float>& values, int width, int height, double most, const char* what) {
  require(values.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height), ErrorCode::bad_size,
          std::string(what) + " has " + std::to_string(values.size()) + " values, its camera " + std::to_string(width) +
              " x " + std::to_string(height) + " pixels");
  const auto wrong = std::find_if(values.begin(), values.end(), [most](float v) { return !(v >= 0 && v <= most); });
  require(wrong == values.end(), wrong == values.end() || std::isfinite(*wrong) ? ErrorCode::bad_input : ErrorCode::not_finite,
          std::string(what) + " must be finite, not negative and at most " + std::to_string(most));
  ImageF image;
  image.width = width;
  image.height = height;
  image.data = values;
  return image;
}

// Flags of guessed disparities, which must not measure: of a left eye whose `depth` has nothing there.
ImageU8 guesses(const std::vector<std::uint8_t>& flags, const ImageF& disparity, const object_model::DepthMap& depth) {
  require(flags.size() == disparity.data.size(), ErrorCode::bad_size, "disparity_filled must have as many values as disparity");
  ImageU8 out;
  if (flags.empty()) return out;
  require(depth.depth.width == disparity.width && depth.depth.height == disparity.height, ErrorCode::bad_size,
          "disparity must have the size of the left eye's depth");
  bool two_values = true, kept_apart = true;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    two_values = two_values && (flags[i] == 0 || flags[i] == 255);
    kept_apart = kept_apart && (flags[i] == 0 || (disparity.data[i] > 0 && depth.depth.data[i] == 0 && depth.depth_minimum.data[i] == 0));
  }
  require(two_values, ErrorCode::bad_input, "disparity_filled must be 0 or 255");
  require(kept_apart, ErrorCode::bad_input, "where disparity is filled there must be a disparity, and no depth or least depth: guesses do not carve");
  out.width = disparity.width;
  out.height = disparity.height;
  out.data = flags;
  return out;
}

object_model::DepthMap from_wire(const msg::DepthMap& m) {
  object_model::DepthMap d;
  d.camera = wire::from_wire(m.camera());
  d.X_WC = wire::from_wire(m.pose_world_camera());
  d.depth = plane(m.depth(), d.camera.width, d.camera.height, kFarthest, "depth");
  d.depth_minimum = plane(m.depth_minimum(), d.camera.width, d.camera.height, kFarthest, "depth_minimum");
  d.depth_sigma = plane(m.depth_sigma(), d.camera.width, d.camera.height, kFarthest, "depth_sigma");
  bool in_front = true;
  for (std::size_t i = 0; i < d.depth.data.size(); ++i) in_front = in_front && (d.depth.data[i] == 0 || d.depth_minimum.data[i] <= d.depth.data[i] * 1.0001f);
  require(in_front, ErrorCode::bad_input, "depth_minimum lies behind depth; it must be the least depth of the pixel's footprint");
  return d;
}

msg::DepthMap to_wire(const object_model::DepthMap& d) {
  msg::DepthMap m;
  m.camera(wire::to_wire(d.camera));
  m.pose_world_camera(wire::to_wire(d.X_WC));
  m.depth(d.depth.data);
  m.depth_minimum(d.depth_minimum.data);
  m.depth_sigma(d.depth_sigma.data);
  return m;
}

object_model::Feature from_wire(const msg::Feature& m) {
  object_model::Feature f;
  f.u = static_cast<float>(require_finite(m.u(), "a feature's u"));
  f.v = static_cast<float>(require_finite(m.v(), "a feature's v"));
  f.size = static_cast<float>(require_finite(m.size(), "a feature's size"));
  f.angle = static_cast<float>(require_finite(m.angle(), "a feature's angle"));
  f.p_W = wire::from_wire(m.position());
  f.normal_W = wire::from_wire(m.normal());
  const double length = f.normal_W.norm();
  require(length == 0 || std::abs(length - 1) < 1e-3, ErrorCode::bad_input,
          "a feature's normal must have length 1, or be zero where it is unknown");
  f.size_m = require_finite(m.size_m(), "a feature's size_m");
  require(f.size >= 0 && f.size_m >= 0, ErrorCode::bad_input, "a feature's size must not be negative");
  const auto kind = object_model::descriptor_kind(m.descriptor_kind());
  require(kind.has_value(), ErrorCode::bad_input, "a feature's descriptor_kind is unknown");
  f.kind = *kind;
  f.descriptor = m.descriptor();
  require(f.descriptor.empty() || f.descriptor.size() == object_model::descriptor_octets(f.kind), ErrorCode::bad_size,
          std::string("a descriptor of kind ") + object_model::to_string(f.kind) + " has another number of octets");
  return f;
}

msg::Feature to_wire(const object_model::Feature& f) {
  msg::Feature m;
  m.u(f.u);
  m.v(f.v);
  m.size(f.size);
  m.angle(f.angle);
  m.position(wire::to_wire(f.p_W));
  m.normal(wire::to_wire(f.normal_W));
  m.size_m(static_cast<float>(f.size_m));
  m.descriptor(f.descriptor);
  m.descriptor_kind(static_cast<std::uint8_t>(f.kind));
  return m;
}

void check_image_size(std::uint32_t width, std::uint32_t height) {
  require(width >= 1 && width <= 8192 && height >= 1 && height <= 8192, ErrorCode::vision_image_bad,
          "an image of " + std::to_string(width) + " x " + std::to_string(height) +
              " pixels was refused; sides must lie in 1..8192");
}

struct Encoding {
  const char* name;
  std::size_t octets;  // a pixel
  bool blue_first;
  Mosaic mosaic;
};
// The first of a kind is what goes out.
constexpr std::array<Encoding, 11> kEncodings{{{"mono8", 1, false, Mosaic::none},
                                               {"rgb8", 3, false, Mosaic::none},
                                               {"8UC1", 1, false, Mosaic::none},
                                               {"bgr8", 3, true, Mosaic::none},
                                               {"8UC3", 3, true, Mosaic::none},
                                               {"rgba8", 4, false, Mosaic::none},
                                               {"bgra8", 4, true, Mosaic::none},
                                               {"bayer_rggb8", 1, false, Mosaic::rggb},
                                               {"bayer_bggr8", 1, false, Mosaic::bggr},
                                               {"bayer_gbrg8", 1, false, Mosaic::gbrg},
                                               {"bayer_grbg8", 1, false, Mosaic::grbg}}};

const Encoding& encoding_of(const std::string& name) {
  const auto known = std::find_if(kEncodings.begin(), kEncodings.end(), [&](const Encoding& e) { return name == e.name; });
  if (known != kEncodings.end()) return *known;
  std::string names, reason = "which is not known here";
  for (const Encoding& e : kEncodings) names += (names.empty() ? "" : ", ") + std::string(e.name);
  if (name.find("16") != std::string::npos) reason = "16 bits a value, of which only the driver knows how many count; have it scale them to 8";
  if (name.find("32") != std::string::npos || name.find("64") != std::string::npos) reason = "which is for depth and computed images; send what the camera saw";
  if (name.starts_with("yuv") || name.find("422") != std::string::npos || name.starts_with("nv")) reason = "whose colours are packed; have the driver, or ROS's image_proc, convert it to rgb8";
  throw_error(ErrorCode::vision_image_bad, "an image has the encoding '" + name.substr(0, 32) + "', " + reason + ". Known are " + names);
}

double finite_calibration(double v) {
  require(std::isfinite(v), ErrorCode::vision_image_bad,
          "a camera info carries a number that is not finite; calibrate the camera again");
  return v;
}

}  // namespace

Eigen::Matrix<double, 6, 6> covariance_from_wire(const std::array<double, 36>& m) {
  Eigen::Matrix<double, 6, 6> out;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) out(i, j) = require_finite(m[static_cast<std::size_t>(6 * i + j)], "pose_covariance");
  require((out.diagonal().array() >= 0).all() && (out - out.transpose()).cwiseAbs().maxCoeff() <= 1e-9 + 1e-6 * out.cwiseAbs().maxCoeff(), ErrorCode::bad_input,
          "pose_covariance must be symmetric with no negative variance");
  return out;
}

object_model::Perception from_wire(const msg::Perception& m) {
  object_model::Perception p;
  p.view_id = id_from_wire(m.view_id(), "a perception's view_id");
  p.stamp_ns = m.stamp_ns();
  p.rig = from_wire(m.rig());
  p.X_WC = from_wire(m.pose_world_camera());
  p.covariance = covariance_from_wire(m.pose_covariance());
  require(!m.depth().empty() && m.depth().size() <= 2, ErrorCode::bad_size, "a perception carries one or two depth maps");
  for (const msg::DepthMap& d : m.depth()) p.depth.push_back(from_wire(d));
  const Pinhole& camera = p.rig.camera;
  const std::size_t pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  require(m.color().size() == 3 * pixels, ErrorCode::bad_size,
          "a perception's colour image must be rgb8 of the left camera's size");
  p.color.width = camera.width;
  p.color.height = camera.height;
  p.color.channels = 3;
  p.color.data = m.color();
  if (!m.disparity().empty()) p.disparity = plane(m.disparity(), camera.width, camera.height, 8192, "disparity");
  p.disparity_filled = guesses(m.disparity_filled(), p.disparity, p.depth.front());
  require(m.features().size() <= kMostFeatures, ErrorCode::bad_size, "a perception carries at most 8192 features");
  p.features.reserve(m.features().size());
  for (const msg::Feature& f : m.features()) p.features.push_back(from_wire(f));
  p.silhouette_valid_share = require_finite(m.silhouette_valid_share(), "silhouette_valid_share");
  require(p.silhouette_valid_share >= 0 && p.silhouette_valid_share <= 1, ErrorCode::bad_input,
          "silhouette_valid_share must lie in 0..1");
  return p;
}

msg::Perception to_wire(const object_model::Perception& p) {
  msg::Perception m;
  m.view_id(p.view_id);
  m.stamp_ns(p.stamp_ns);
  m.rig(to_wire(p.rig));
  m.pose_world_camera(to_wire(p.X_WC));
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) m.pose_covariance()[static_cast<std::size_t>(6 * i + j)] = p.covariance(i, j);
  for (const object_model::DepthMap& d : p.depth) m.depth().push_back(to_wire(d));
  m.color(p.color.data);
  m.disparity(p.disparity.data);
  m.disparity_filled(p.disparity_filled.data);
  for (const object_model::Feature& f : p.features) m.features().push_back(to_wire(f));
  m.silhouette_valid_share(p.silhouette_valid_share);
  return m;
}

std::int64_t stamp_from_wire(const builtin_interfaces::msg::dds_::Time_& t) {
  require(t.nanosec() < 1000000000u, ErrorCode::bad_input, "a time stamp's nanosec must be below 1e9");
  return static_cast<std::int64_t>(t.sec()) * 1000000000 + static_cast<std::int64_t>(t.nanosec());
}

builtin_interfaces::msg::dds_::Time_ stamp_to_wire(std::int64_t stamp_ns) {
  std::int64_t seconds = stamp_ns / 1000000000, rest = stamp_ns % 1000000000;
  if (rest < 0) {
    rest += 1000000000;
    --seconds;
  }
  builtin_interfaces::msg::dds_::Time_ t;
  t.sec(static_cast<std::int32_t>(seconds));
  t.nanosec(static_cast<std::uint32_t>(rest));
  return t;
}

StampedImage from_wire(const sensor_msgs::msg::dds_::Image_& m) {
  check_image_size(m.width(), m.height());
  const Encoding& encoding = encoding_of(m.encoding());
  require(encoding.mosaic == Mosaic::none || (m.width() >= 4 && m.height() >= 4), ErrorCode::vision_image_bad,
          "a mosaic of " + std::to_string(m.width()) + " x " + std::to_string(m.height()) + " pixels has no colours; send 4 x 4 or more");
  const std::size_t octets = encoding.octets, row = m.width() * octets;
  require(m.step() >= row && m.data().size() == static_cast<std::size_t>(m.step()) * m.height(),
          ErrorCode::vision_image_bad,
          "an image is truncated: " + std::to_string(m.data().size()) + " octets came, " + std::to_string(m.width()) +
              " x " + std::to_string(m.height()) + " " + encoding.name + " with a step of " + std::to_string(m.step()) +
              " needs " + std::to_string(std::max<std::size_t>(m.step(), row) * m.height()) + "; check the camera driver");
  StampedImage out;
  out.stamp_ns = stamp_from_wire(m.header().stamp());
  out.frame_id = m.header().frame_id();
  out.mosaic = encoding.mosaic;
  const std::size_t channels = octets == 1 ? 1 : 3;
  out.image = ImageU8(static_cast<int>(m.width()), static_cast<int>(m.height()), static_cast<int>(channels));
  std::uint8_t* to = out.image.data.data();
  for (std::size_t y = 0; y < m.height(); ++y) {
    const std::uint8_t* from = m.data().data() + y * m.step();
    if (octets == channels && !encoding.blue_first) {
      std::memcpy(to, from, row);
      to += row;
      continue;
    }
    for (std::size_t x = 0; x < m.width(); ++x, from += octets, to += channels)
      for (std::size_t c = 0; c < channels; ++c) to[c] = from[encoding.blue_first ? channels - 1 - c : c];
  }
  return out;
}

sensor_msgs::msg::dds_::Image_ to_wire(const StampedImage& image) {
  const bool grey = image.image.channels == 1;
  const auto encoding = std::find_if(kEncodings.begin(), kEncodings.end(),
                                     [&](const Encoding& e) { return e.mosaic == image.mosaic && (e.octets == 1) == grey; });
  require(encoding != kEncodings.end(), ErrorCode::bad_input, "a mosaic has one value a pixel");
  sensor_msgs::msg::dds_::Image_ m;
  m.header().stamp(stamp_to_wire(image.stamp_ns));
  m.header().frame_id(image.frame_id);
  m.width(static_cast<std::uint32_t>(image.image.width));
  m.height(static_cast<std::uint32_t>(image.image.height));
  m.encoding(encoding->name);
  m.is_bigendian(0);
  m.step(static_cast<std::uint32_t>(image.image.width * image.image.channels));
  m.data(image.image.data);
  return m;
}

std::pair<std::int64_t, CameraCalibration> from_wire(const sensor_msgs::msg::dds_::CameraInfo_& m) {
  check_image_size(m.width(), m.height());
  const std::string& model = m.distortion_model();
  require(model.empty() || model == "plumb_bob" || model == "rational_polynomial", ErrorCode::vision_image_bad,
          "a camera info has the distortion model '" + model.substr(0, 32) + "'; send plumb_bob or rational_polynomial");
  const std::size_t n = m.d().size();
  require(n == 0 || n == 4 || n == 5 || n == 8 || n == 12 || n == kMostDistortion, ErrorCode::vision_image_bad,
          "a camera info carries " + std::to_string(n) + " distortion coefficients; 0, 4, 5, 8, 12 or 14 are known");
  CameraCalibration c;
  c.width = static_cast<int>(m.width());
  c.height = static_cast<int>(m.height());
  for (double d : m.d()) c.distortion.push_back(finite_calibration(d));
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      c.K(i, j) = finite_calibration(m.k()[static_cast<std::size_t>(3 * i + j)]);
      c.R(i, j) = finite_calibration(m.r()[static_cast<std::size_t>(3 * i + j)]);
    }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) c.P(i, j) = finite_calibration(m.p()[static_cast<std::size_t>(4 * i + j)]);
  require(c.K(0, 0) > 0 && c.K(1, 1) > 0, ErrorCode::vision_image_bad, "a camera info's focal lengths must be positive");
  require((c.R * c.R.transpose()).isIdentity(1e-6) && c.R.determinant() > 0, ErrorCode::vision_image_bad,
          "a camera info's R must be a rotation; the identity where the images are rectified");
  return {stamp_from_wire(m.header().stamp()), c};
}

sensor_msgs::msg::dds_::CameraInfo_ to_wire(std::int64_t stamp_ns, const std::string& frame_id,
                                            const CameraCalibration& c) {
  sensor_msgs::msg::dds_::CameraInfo_ m;
  m.header().stamp(stamp_to_wire(stamp_ns));
  m.header().frame_id(frame_id);
  m.width(static_cast<std::uint32_t>(c.width));
  m.height(static_cast<std::uint32_t>(c.height));
  m.distortion_model("plumb_bob");
  m.d(c.distortion);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      m.k()[static_cast<std::size_t>(3 * i + j)] = c.K(i, j);
      m.r()[static_cast<std::size_t>(3 * i + j)] = c.R(i, j);
    }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) m.p()[static_cast<std::size_t>(4 * i + j)] = c.P(i, j);
  return m;
}

StampedJoints from_wire(const sensor_msgs::msg::dds_::JointState_& m) {
  require(m.name().size() == m.position().size() && m.name().size() <= kMostJoints, ErrorCode::bad_size,
          "joint states carry " + std::to_string(m.name().size()) + " names and " + std::to_string(m.position().size()) +
              " positions; as many of both are needed, at most 1024");
  StampedJoints out;
  out.stamp_ns = stamp_from_wire(m.header().stamp());
  for (std::size_t i = 0; i < m.name().size(); ++i) {
    require(m.name()[i].size() <= 128, ErrorCode::bad_input, "a joint's name has at most 128 characters");
    out.positions.emplace_back(m.name()[i], require_finite(m.position()[i], "a joint position"));
  }
  return out;
}

sensor_msgs::msg::dds_::JointState_ to_wire(const StampedJoints& joints) {
  sensor_msgs::msg::dds_::JointState_ m;
  m.header().stamp(stamp_to_wire(joints.stamp_ns));
  for (const auto& [name, position] : joints.positions) {
    m.name().push_back(name);
    m.position().push_back(position);
  }
  return m;
}

std::pair<std::int64_t, Pose> from_wire(const geometry_msgs::msg::dds_::PoseStamped_& m) {
  msg::Pose pose;
  pose.position().x(m.pose().position().x());
  pose.position().y(m.pose().position().y());
  pose.position().z(m.pose().position().z());
  pose.qx(m.pose().orientation().x());
  pose.qy(m.pose().orientation().y());
  pose.qz(m.pose().orientation().z());
  pose.qw(m.pose().orientation().w());
  return {stamp_from_wire(m.header().stamp()), from_wire(pose)};
}

geometry_msgs::msg::dds_::PoseStamped_ to_wire(std::int64_t stamp_ns, const std::string& frame_id, const Pose& pose) {
  const msg::Pose p = to_wire(pose);
  geometry_msgs::msg::dds_::PoseStamped_ m;
  m.header().stamp(stamp_to_wire(stamp_ns));
  m.header().frame_id(frame_id);
  m.pose().position().x(p.position().x());
  m.pose().position().y(p.position().y());
  m.pose().position().z(p.position().z());
  m.pose().orientation().x(p.qx());
  m.pose().orientation().y(p.qy());
  m.pose().orientation().z(p.qz());
  m.pose().orientation().w(p.qw());
  return m;
}

}  // namespace periplus::wire

#include "common/wire/perception_wire.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/dds/codec_impl.h"

namespace periplus::wire {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

object_model::Perception sample_perception() {
  object_model::Perception p;
  p.view_id = "look-3";
  p.stamp_ns = 12345678901;
  p.rig = {Pinhole::from_vertical_fov(8, 6, 0.5), 0.144};
  p.X_WC = look_at({1, 2, 1.3}, {0, 0, 1});
  p.covariance.diagonal().setConstant(1e-6);
  p.covariance(0, 1) = p.covariance(1, 0) = 1e-7;
  for (int eye = 0; eye < 2; ++eye) {
    object_model::DepthMap d{p.rig.camera, p.X_WC * Eigen::Translation3d(0.144 * eye, 0, 0), ImageF(8, 6, 1, 1.2f),
                             ImageF(8, 6, 1, 1.1f), ImageF(8, 6, 1, 0.002f)};
    d.depth.at(3, 2) = 0;
    p.depth.push_back(std::move(d));
  }
  p.color = ImageU8(8, 6, 3);
  for (std::size_t i = 0; i < p.color.data.size(); ++i) p.color.data[i] = static_cast<std::uint8_t>(i);
  p.disparity = ImageF(8, 6, 1, 5.f);
  p.disparity_filled = ImageU8(8, 6);
  p.disparity_filled.at(3, 2) = 255;
  p.depth[0].depth_minimum.at(3, 2) = 0;
  object_model::Feature f;
  f.u = 1.5f;
  f.v = 2.5f;
  f.size = 4;
  f.angle = 0.3f;
  f.p_W = {0.1, 0.2, 0.9};
  f.normal_W = {0, 0.6, 0.8};
  f.size_m = 0.25;
  f.descriptor.assign(128, 7);
  p.features = {f, f};
  p.features[1].kind = object_model::DescriptorKind::orb;
  p.features[1].descriptor.assign(32, 9);
  p.silhouette_valid_share = 0.9;
  return p;
}

ErrorCode refusal(const msg::Perception& m) {
  try {
    from_wire(m);
  } catch (const Error& e) {
    EXPECT_GT(std::string(e.what()).size(), 20u);
    return e.code();
  }
  return ErrorCode::ok;
}

TEST(PerceptionWire, RoundTrip) {
  const object_model::Perception p = sample_perception(), q = from_wire(to_wire(p));
  EXPECT_EQ(q.view_id, p.view_id);
  EXPECT_EQ(q.stamp_ns, p.stamp_ns);
  EXPECT_EQ(q.rig.baseline, p.rig.baseline);
  EXPECT_TRUE(q.X_WC.isApprox(p.X_WC, 1e-12));
  EXPECT_EQ(q.covariance, p.covariance);
  ASSERT_EQ(q.depth.size(), 2u);
  EXPECT_TRUE(q.depth[1].X_WC.isApprox(p.depth[1].X_WC, 1e-12));
  EXPECT_EQ(q.depth[1].depth.data, p.depth[1].depth.data);
  EXPECT_EQ(q.depth[0].depth_minimum.data, p.depth[0].depth_minimum.data);
  EXPECT_EQ(q.depth[0].depth_sigma.data, p.depth[0].depth_sigma.data);
  EXPECT_EQ(q.color.data, p.color.data);
  EXPECT_EQ(q.color.channels, 3);
  EXPECT_EQ(q.disparity.data, p.disparity.data);
  EXPECT_EQ(q.disparity_filled.data, p.disparity_filled.data);
  ASSERT_EQ(q.features.size(), 2u);
  EXPECT_EQ(q.features[0].kind, object_model::DescriptorKind::root_sift);
  EXPECT_EQ(q.features[1].kind, object_model::DescriptorKind::orb);
  EXPECT_EQ(q.features[1].descriptor, p.features[1].descriptor);
  EXPECT_EQ(q.features[0].descriptor, p.features[0].descriptor);
  EXPECT_EQ(q.features[0].p_W, p.features[0].p_W);
  EXPECT_EQ(q.features[0].size_m, 0.25);
  EXPECT_EQ(q.silhouette_valid_share, 0.9);
}

TEST(PerceptionWire, RefusesWhatDoesNotHold) {
  const msg::Perception good = to_wire(sample_perception());
  ASSERT_EQ(refusal(good), ErrorCode::ok);
  const auto spoilt = [&](const std::function<void(msg::Perception&)>& spoil) {
    msg::Perception m = good;
    spoil(m);
    return refusal(m);
  };
  EXPECT_EQ(spoilt([](auto& m) { m.view_id("../etc"); }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.depth()[0].depth().pop_back(); }), ErrorCode::bad_size);
  EXPECT_EQ(spoilt([](auto& m) { m.depth()[1].depth_sigma().clear(); }), ErrorCode::bad_size);
  EXPECT_EQ(spoilt([](auto& m) { m.depth()[0].depth()[5] = std::numeric_limits<float>::quiet_NaN(); }), ErrorCode::not_finite);
  EXPECT_EQ(spoilt([](auto& m) { m.depth()[0].depth_minimum()[5] = std::numeric_limits<float>::infinity(); }), ErrorCode::not_finite);
  EXPECT_EQ(spoilt([](auto& m) { m.depth()[0].depth()[5] = -1; }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.depth()[0].depth_minimum()[5] = 1.3f; }), ErrorCode::bad_input);  // behind the depth
  EXPECT_EQ(spoilt([](auto& m) { m.depth().clear(); }), ErrorCode::bad_size);
  EXPECT_EQ(spoilt([](auto& m) { m.depth()[0].camera().width(1u << 31); }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.depth()[0].camera().fx(2e11); }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.rig().camera().fy(1e7); }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.color().resize(10); }), ErrorCode::bad_size);
  EXPECT_EQ(spoilt([](auto& m) { m.disparity().resize(10); }), ErrorCode::bad_size);
  EXPECT_EQ(spoilt([](auto& m) { m.disparity().clear(); }), ErrorCode::bad_size);  // flags without disparities
  EXPECT_EQ(spoilt([](auto& m) { m.disparity().clear(), m.disparity_filled().clear(); }), ErrorCode::ok);
  EXPECT_EQ(spoilt([](auto& m) { m.disparity_filled().clear(); }), ErrorCode::bad_size);
  EXPECT_EQ(spoilt([](auto& m) { m.disparity_filled()[0] = 1; }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.disparity_filled()[0] = 255; }), ErrorCode::bad_input);           // a guess with a depth
  EXPECT_EQ(spoilt([](auto& m) { m.depth()[0].depth_minimum()[19] = 1; }), ErrorCode::bad_input);    // a guess that would carve
  EXPECT_EQ(spoilt([](auto& m) { m.disparity()[19] = 0; }), ErrorCode::bad_input);                   // a guess of nothing
  EXPECT_EQ(spoilt([](auto& m) { m.pose_world_camera().qw(2); }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.pose_world_camera().position().x(kNoNumber); }), ErrorCode::not_finite);
  EXPECT_EQ(spoilt([](auto& m) { m.pose_covariance()[0] = -1; }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.pose_covariance()[3] = 1; }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.pose_covariance()[3] = kNoNumber; }), ErrorCode::not_finite);
  EXPECT_EQ(spoilt([](auto& m) { m.features()[0].normal().z(3); }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.features()[0].u(std::numeric_limits<float>::quiet_NaN()); }), ErrorCode::not_finite);
  EXPECT_EQ(spoilt([](auto& m) { m.features()[0].size_m(-1); }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.features()[0].descriptor_kind(4); }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.features()[0].descriptor_kind(3); }), ErrorCode::bad_size);
  EXPECT_EQ(spoilt([](auto& m) { m.features()[1].descriptor().pop_back(); }), ErrorCode::bad_size);
  EXPECT_EQ(spoilt([](auto& m) { m.features()[1].descriptor().clear(); }), ErrorCode::ok);
  EXPECT_EQ(spoilt([](auto& m) { m.silhouette_valid_share(1.5); }), ErrorCode::bad_input);
  EXPECT_EQ(spoilt([](auto& m) { m.rig().baseline(0); }), ErrorCode::bad_input);
}

// Whatever octets come: a decoded sample is either accepted, with shapes that hold, or refused with an Error.
TEST(PerceptionWire, HostileOctetsNeverDoMoreThanBeRefused) {
  const dds::Codec& codec = dds::codec<msg::Perception>();
  const msg::Perception good = to_wire(sample_perception());
  std::vector<std::uint8_t> bytes(codec.size(&good) + 64);
  bytes.resize(codec.encode(&good, bytes.data(), bytes.size()));
  ASSERT_GT(bytes.size(), 100u);
  Random random(11);
  int refused = 0, accepted = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<std::uint8_t> spoilt = bytes;
    for (std::uint64_t n = 1 + random.below(4); n > 0; --n)
      spoilt[4 + random.below(spoilt.size() - 4)] = static_cast<std::uint8_t>(random.next());
    if (random.below(8) == 0) spoilt.resize(4 + random.below(spoilt.size() - 4));
    msg::Perception m;
    if (!codec.decode(spoilt.data(), spoilt.size(), &m)) {
      ++refused;
      continue;
    }
    try {
      const object_model::Perception p = from_wire(m);
      ++accepted;
      for (const auto& d : p.depth)
        ASSERT_EQ(d.depth.data.size(), static_cast<std::size_t>(d.camera.width) * static_cast<std::size_t>(d.camera.height));
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(accepted, 100);
}

TEST(ImageWire, RoundTripAndBgr) {
  StampedImage image{-1, "left", ImageU8(3, 2, 3)};
  for (std::size_t i = 0; i < image.image.data.size(); ++i) image.image.data[i] = static_cast<std::uint8_t>(10 * i);
  auto m = to_wire(image);
  const StampedImage back = from_wire(m);
  EXPECT_EQ(back.image.data, image.image.data);
  EXPECT_EQ(back.stamp_ns, -1);
  EXPECT_EQ(back.frame_id, "left");
  m.encoding("bgr8");
  EXPECT_EQ(from_wire(m).image.at(1, 0, 0), image.image.at(1, 0, 2));
}

TEST(ImageWire, EveryEightBitEncodingWithPaddedRowsAndOddSides) {
  struct Kind {
    const char* encoding;
    std::size_t octets;
    std::vector<std::uint8_t> pixel;  // what comes of the octets 10 20 30 40
    Mosaic mosaic;
  };
  const Kind kinds[] = {{"mono8", 1, {10}, Mosaic::none},         {"8UC1", 1, {10}, Mosaic::none},          {"rgb8", 3, {10, 20, 30}, Mosaic::none},
                        {"bgr8", 3, {30, 20, 10}, Mosaic::none},  {"8UC3", 3, {30, 20, 10}, Mosaic::none},  {"rgba8", 4, {10, 20, 30}, Mosaic::none},
                        {"bgra8", 4, {30, 20, 10}, Mosaic::none}, {"bayer_rggb8", 1, {10}, Mosaic::rggb},   {"bayer_bggr8", 1, {10}, Mosaic::bggr},
                        {"bayer_gbrg8", 1, {10}, Mosaic::gbrg},   {"bayer_grbg8", 1, {10}, Mosaic::grbg}};
  for (const Kind& kind : kinds) {
    sensor_msgs::msg::dds_::Image_ m;
    m.width(7);
    m.height(5);
    m.encoding(kind.encoding);
    m.step(static_cast<std::uint32_t>(7 * kind.octets + 3));
    for (int y = 0; y < 5; ++y)
      for (std::size_t i = 0; i < m.step(); ++i)
        m.data().push_back(i < 7 * kind.octets ? static_cast<std::uint8_t>(10 * (i % kind.octets + 1) + static_cast<std::size_t>(y)) : 255);
    const StampedImage image = from_wire(m);
    EXPECT_EQ(image.mosaic, kind.mosaic) << kind.encoding;
    ASSERT_EQ(image.image.data.size(), 35 * kind.pixel.size()) << kind.encoding;
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 7; ++x)
        for (std::size_t c = 0; c < kind.pixel.size(); ++c) EXPECT_EQ(image.image.at(x, y, static_cast<int>(c)), kind.pixel[c] + y) << kind.encoding;
    const StampedImage again = from_wire(to_wire(image));
    EXPECT_EQ(again.image.data, image.image.data) << kind.encoding;
    EXPECT_EQ(again.mosaic, image.mosaic) << kind.encoding;
  }
}

TEST(ImageWire, WhatCannotBeTakenIsRefusedWithWhatToSend) {
  sensor_msgs::msg::dds_::Image_ m;
  m.width(8);
  m.height(8);
  m.step(64);
  m.data().resize(512);
  for (const char* encoding : {"mono16", "16UC1", "bayer_rggb16", "32FC1", "yuv422", "", "RGB8", "rgb8 "}) {
    m.encoding(encoding);
    try {
      from_wire(m);
      FAIL() << encoding;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::vision_image_bad) << encoding;
      EXPECT_NE(std::string(e.what()).find("mono8, rgb8"), std::string::npos) << e.what();
      EXPECT_EQ(std::string(encoding).find("16") != std::string::npos, std::string(e.what()).find("scale them to 8") != std::string::npos) << e.what();
    }
  }
  m.encoding("bayer_rggb8");
  m.height(3);
  m.data().resize(192);
  EXPECT_THROW(from_wire(m), Error);
}

TEST(ImageWire, TakesRowsWithAStepAndRefusesTheRest) {
  sensor_msgs::msg::dds_::Image_ m;
  m.width(2);
  m.height(2);
  m.encoding("mono8");
  m.step(4);
  m.data({1, 2, 99, 99, 3, 4, 99, 99});
  EXPECT_EQ(from_wire(m).image.data, (std::vector<std::uint8_t>{1, 2, 3, 4}));
  const auto code = [](const sensor_msgs::msg::dds_::Image_& bad) {
    try {
      from_wire(bad);
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode::ok;
  };
  auto bad = m;
  bad.data().pop_back();
  EXPECT_EQ(code(bad), ErrorCode::vision_image_bad);
  bad = m;
  bad.step(1);
  bad.data().resize(2);
  EXPECT_EQ(code(bad), ErrorCode::vision_image_bad);
  bad = m;
  bad.width(0);
  EXPECT_EQ(code(bad), ErrorCode::vision_image_bad);
  bad = m;
  bad.height(0xffffffffu);
  EXPECT_EQ(code(bad), ErrorCode::vision_image_bad);
  bad = m;
  bad.encoding("16UC1");
  EXPECT_EQ(code(bad), ErrorCode::vision_image_bad);
  bad = m;
  bad.header().stamp().nanosec(2000000000u);
  EXPECT_EQ(code(bad), ErrorCode::bad_input);
}

TEST(CameraInfoWire, RoundTripAndRefusals) {
  CameraCalibration c = CameraCalibration::ideal(Pinhole::from_vertical_fov(640, 480, 0.43), 0.144);
  c.distortion = {0.1, -0.2, 0, 0, 0};
  const auto m = to_wire(5000000007, "right", c);
  const auto [stamp, back] = from_wire(m);
  EXPECT_EQ(stamp, 5000000007);
  EXPECT_EQ(back.P, c.P);
  EXPECT_EQ(back.K, c.K);
  EXPECT_EQ(back.distortion, c.distortion);
  auto bad = m;
  bad.r()[0] = 2;
  EXPECT_THROW(from_wire(bad), Error);
  bad = m;
  bad.r()[0] = -1;  // a mirror
  EXPECT_THROW(from_wire(bad), Error);
  bad = m;
  bad.k()[0] = kNoNumber;
  EXPECT_THROW(from_wire(bad), Error);
  bad = m;
  bad.d().resize(3);
  EXPECT_THROW(from_wire(bad), Error);
  bad = m;
  bad.distortion_model("equidistant");
  EXPECT_THROW(from_wire(bad), Error);
}

TEST(JointsAndPoseWire, RoundTripAndRefusals) {
  const StampedJoints joints{-2500000000, {{"neck", 0.1}, {"waist", -0.2}}};
  auto m = to_wire(joints);
  EXPECT_EQ(from_wire(m).stamp_ns, joints.stamp_ns);
  EXPECT_EQ(from_wire(m).positions, joints.positions);
  m.position()[1] = kNoNumber;
  EXPECT_THROW(from_wire(m), Error);
  m.position().pop_back();
  EXPECT_THROW(from_wire(m), Error);

  const Pose X = look_at({1, 2, 3}, {0, 0, 0});
  auto pose = to_wire(77, "world", X);
  EXPECT_EQ(from_wire(pose).first, 77);
  EXPECT_TRUE(from_wire(pose).second.isApprox(X, 1e-12));
  pose.pose().orientation().w(5);
  EXPECT_THROW(from_wire(pose), Error);
}

}  // namespace
}  // namespace periplus::wire

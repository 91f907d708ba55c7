// Messages of the cameras and of the vision server. The first octet says what the others are: C an image, c its calibration,
// P a perception, J joints, S a pose, each as it comes off the wire (CDR, with its encapsulation); T fields of an image in turn.
#include <cstring>

#include "common/dds/codec_impl.h"
#include "common/wire/perception_wire.h"
#include "integration-tests/fuzz/expected_refusal.h"

using namespace periplus;

namespace {

using RosImage = sensor_msgs::msg::dds_::Image_;

// What comes in, goes out and comes in again is the same on the wire.
template <class Message>
void domain_and_back(const Message& message) {
  const auto domain = fuzz::result_or_refusal([&] { return wire::from_wire(message); });
  if (!domain) return;
  if constexpr (std::is_same_v<Message, RosImage>) {
    const RosImage out = wire::to_wire(*domain);
    const auto again = fuzz::must_read("an image came in and went out", [&] { return wire::from_wire(out); });
    if (again.stamp_ns != domain->stamp_ns || again.image.data != domain->image.data || again.mosaic != domain->mosaic) fuzz::finding("an image that came in and went out is another one");
  } else if constexpr (std::is_same_v<Message, msg::Perception>) {
    const msg::Perception out = wire::to_wire(*domain);
    fuzz::must_read("a perception came in and went out", [&] { return wire::from_wire(out); });
  }
}

template <class Message>
void off_the_wire(const std::uint8_t* data, std::size_t size) {
  Message message;
  if (dds::codec<Message>().decode(data, size, &message)) domain_and_back(message);
}

// Fields one after the other; zeros where the input has ended.
class Fields {
 public:
  Fields(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  template <class T>
  T next() {
    T value{};
    const std::size_t n = std::min(left_, sizeof value);
    if (n > 0) std::memcpy(&value, data_, n);
    data_ += n;
    left_ -= n;
    return value;
  }
  std::vector<std::uint8_t> rest() { return {data_, data_ + left_}; }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

void typed(Fields fields) {
  static constexpr const char* encodings[] = {"rgb8", "bgr8", "mono8", "mono16", "", "rgba8", "bgra8", "bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"};
  RosImage image;
  image.header().stamp().sec(fields.next<std::int32_t>());
  image.header().stamp().nanosec(fields.next<std::uint32_t>());
  image.encoding(encodings[fields.next<std::uint8_t>() % std::size(encodings)]);
  image.width(fields.next<std::uint16_t>());
  image.height(fields.next<std::uint16_t>());
  image.step(fields.next<std::uint32_t>());
  image.data(fields.rest());
  domain_and_back(image);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  switch (fuzz::take_kind(data, size)) {
    case 'C': off_the_wire<RosImage>(data, size); break;
    case 'c': off_the_wire<sensor_msgs::msg::dds_::CameraInfo_>(data, size); break;
    case 'P': off_the_wire<msg::Perception>(data, size); break;
    case 'J': off_the_wire<sensor_msgs::msg::dds_::JointState_>(data, size); break;
    case 'S': off_the_wire<geometry_msgs::msg::dds_::PoseStamped_>(data, size); break;
    case 'T': typed({data, size}); break;
    default: break;
  }
  return 0;
}

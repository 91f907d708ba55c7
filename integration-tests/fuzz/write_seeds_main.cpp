// periplus-fuzz-seeds CORPORA: writes the seeds that come from the programs themselves: a small model in its formats, messages as they go
// over the wire. To be run again when a format changes; the seeds of older versions stay.
#include <cstdio>
#include <exception>
#include <filesystem>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/dds/codec_impl.h"
#include "common/object_model/model_export.h"
#include "common/object_model/model_file.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/wire/object_chunks.h"
#include "common/wire/perception_wire.h"
#include "services/vision_server/calibration_file.h"

namespace {

using namespace periplus;
using namespace periplus::object_model;

void write(const std::string& path, const std::string& bytes) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  vision::write_file(path, bytes);
}

ObjectModel small_model(int views) {
  const object_model::testing::Sphere sphere;
  ObjectBox box = object_model::testing::box_around(sphere);
  box.size = {0.4, 0.36, 0.4};
  ObjectModel model("ball", box, 0.04, {});
  for (int n = 0; n < views; ++n) model.integrate(object_model::testing::ideal_view(sphere, n, 3, 24, 18), {}, {});
  return model;
}

template <class Message>
std::string wired(char kind, const Message& message) {
  const dds::Codec& codec = dds::codec<Message>();
  std::vector<std::uint8_t> bytes(codec.size(&message));
  const std::size_t length = codec.encode(&message, bytes.data(), bytes.size());
  require(length > 0, ErrorCode::internal, "a message could not be encoded");
  return kind + std::string(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
}

void messages(const std::string& folder) {
  Perception p = object_model::testing::ideal_view({}, 0, 3, 8, 6);
  write(folder + "/perception", wired('P', wire::to_wire(p)));
  p.depth.pop_back();
  p.features.clear();
  p.disparity = ImageF(8, 6, 1, 3.f);
  p.disparity_filled = ImageU8(8, 6);
  write(folder + "/perception-one-eye", wired('P', wire::to_wire(p)));
  for (const int channels : {1, 3}) {
    wire::StampedImage image;
    image.stamp_ns = 1500000000;
    image.frame_id = "left";
    image.image = ImageU8(7, 5, channels);
    for (std::size_t i = 0; i < image.image.data.size(); ++i) image.image.data[i] = static_cast<std::uint8_t>(i);
    write(folder + "/image-" + std::to_string(channels), wired('C', wire::to_wire(image)));
  }
  CameraCalibration c;
  c.width = 640;
  c.height = 480;
  c.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  c.P.leftCols<3>() = c.K;
  c.distortion = {0.1, -0.2, 0.001, 0.002, 0};
  write(folder + "/camera-info", wired('c', wire::to_wire(7, "left", c)));
  wire::StampedJoints joints;
  joints.positions = {{"HEAD_JOINT0", 0.1}, {"HEAD_JOINT1", -0.3}};
  write(folder + "/joints", wired('J', wire::to_wire(joints)));
  write(folder + "/pose", wired('S', wire::to_wire(9, "world", look_at({1, 2, 1}, {0, 0, 1}))));
  const char header[] = "T\1\0\0\0\2\0\0\0\1\4\0\3\0\20\0\0\0";
  write(folder + "/typed", std::string(header, sizeof header - 1) + std::string(48, 'x'));
}

void objects(const std::string& folder) {
  const ObjectModel model = small_model(1);
  const wire::ObjectOnWire object = wire::ObjectSplitter().split("ball", model.grid(), model.landmarks(), {model.state().views[0]->X_WC});
  write(folder + "/revision", wired('R', object.revision));
  for (const msg::ObjectChunk& chunk : object.chunks) write(folder + "/chunk-" + std::to_string(chunk.part()), wired('C', chunk));
  // Two objects, the second of two chunks and landmarks; revisions before and after their chunks, and a chunk that goes back.
  const char script[] = "S\2\0\1\0\0\1\4\12\5\6\7\6\0\5\6\1\6\5\0\7\2\0\2\2\0\1\0\0\1\6\1\10\4\12\5\10\7\4\0\5";
  write(folder + "/script", std::string(script, sizeof script - 1));
  // More versions of a chunk than are kept, before the rest of the first one's revision.
  const char versions[] = "S\0\1\1\11\2\0\1\2\0\2\2\0\3\2\0\4\2\0\5\2\1\11\0\1\5\11";
  write(folder + "/script-of-versions", std::string(versions, sizeof versions - 1));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: periplus-fuzz-seeds CORPORA\n");
    return 2;
  }
  const std::string corpora = argv[1];
  try {
    for (const int views : {0, 1, 3}) {
      const ObjectModel model = small_model(views);
      const std::string file = write_model(model);
      write(corpora + "/model_file/" + file.substr(15, file.find('\n') - 15) + "-views-" + std::to_string(views), file);
      if (views != 3) continue;  // nothing is known without a view, and such a tree is refused
      write(corpora + "/model_import/" + std::to_string(views) + "-views.bt", export_model(model, "bt"));
    }
    write(corpora + "/model_import/ball.pcd", export_model(small_model(3), "pcd"));
    StereoRig rig;
    rig.camera = {640, 480, 512.5, 511.25, 319.5, 239.5};
    rig.baseline = 0.12;
    write(corpora + "/calibration_file/calibrated.yaml", vision::view_camera_yaml(rig, "calibrated"));
    messages(corpora + "/image_message");
    objects(corpora + "/object_message");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}

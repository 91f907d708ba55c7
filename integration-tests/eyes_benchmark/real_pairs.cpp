#include "integration-tests/eyes_benchmark/real_pairs.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/mesh/assets.h"
#include "integration-tests/eyes_benchmark/pictures.h"

namespace periplus::eyes_benchmark {
namespace {

std::string asset(const std::string& name) {
  try {
    return mesh::find_asset("stereo/" + name);
  } catch (const Error& e) {
    throw_error(e.code(), std::string(e.what()) + "; deploy/fetch-assets.sh --stereo fetches it");
  }
}

RealPair pair_of(const std::string& name, const std::string& source, const std::string& left, const std::string& right, ImageF truth) {
  RealPair p{name, source, load_grey(asset(left)), load_grey(asset(right)), std::move(truth), {}};
  require(p.left.width == p.truth.width && p.left.height == p.truth.height && p.right.width == p.left.width && p.right.height == p.left.height,
          ErrorCode::bad_size, name + ": pictures and true disparity must have one size");
  const float most = *std::max_element(p.truth.data.begin(), p.truth.data.end());
  p.range = {0, (static_cast<int>(std::ceil(most)) + 2 + 15) / 16 * 16};
  return p;
}

}  // namespace

ImageF parse_npy(const std::string& bytes, int width, int height) {
  static_assert(std::endian::native == std::endian::little);
  ImageF out(width, height);
  const std::string shape = "'shape': (" + std::to_string(height) + ", " + std::to_string(width) + ")";
  const std::size_t length = bytes.size() < 10 ? 0 : static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
  const std::string header = bytes.substr(std::min<std::size_t>(10, bytes.size()), length);
  require(bytes.starts_with("\x93NUMPY\x01") && header.find("'descr': '<f4'") != std::string::npos && header.find("'fortran_order': False") != std::string::npos &&
              header.find(shape) != std::string::npos && bytes.size() == 10 + length + out.data.size() * sizeof(float),
          ErrorCode::bad_input, "not a .npy file of floats with " + shape);
  std::memcpy(out.data.data(), bytes.data() + 10 + length, out.data.size() * sizeof(float));
  for (float& v : out.data)
    if (!std::isfinite(v)) v = 0;
  return out;
}

std::vector<RealPair> load_real_pairs() {
  std::vector<RealPair> pairs;
  const ImageU8 levels = load_grey(asset("aloeGT.png"));
  ImageF aloe(levels.width, levels.height);
  std::copy(levels.data.begin(), levels.data.end(), aloe.data.begin());
  pairs.push_back(pair_of("Aloe", "opencv-doc", "aloeL.jpg", "aloeR.jpg", std::move(aloe)));
  const ImageU8 left = load_grey(asset("motorcycle_left.png"));
  pairs.push_back(pair_of("Motorcycle", "python3-skimage", "motorcycle_left.png", "motorcycle_right.png",
                          parse_npy(read_file(asset("motorcycle_disp.npy")), left.width, left.height)));
  return pairs;
}

}  // namespace periplus::eyes_benchmark

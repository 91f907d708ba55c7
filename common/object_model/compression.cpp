#include "common/object_model/compression.h"

#include <zlib.h>

#include "common/core/error.h"

namespace periplus::object_model {

std::string pack_bytes(const void* data, std::size_t elements, std::size_t element_bytes) {
  const auto* from = static_cast<const unsigned char*>(data);
  std::vector<unsigned char> sorted(elements * element_bytes);
  for (std::size_t b = 0; b < element_bytes; ++b)
    for (std::size_t i = 0; i < elements; ++i) sorted[b * elements + i] = from[i * element_bytes + b];
  uLongf length = compressBound(sorted.size());
  std::string packed(length, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(packed.data()), &length, sorted.data(), sorted.size(), 1);
  PERIPLUS_ASSERT(status == Z_OK);
  packed.resize(length);
  return packed;
}

void unpack_bytes(std::string_view packed, std::size_t elements, std::size_t element_bytes, void* data) {
  require(may_hold(packed, elements * element_bytes), ErrorCode::bad_input, "a packed array is shorter than its claimed size allows");
  std::vector<unsigned char> sorted(elements * element_bytes + 1);  // one more, to notice what is too long
  uLongf length = sorted.size();
  const int status = uncompress(sorted.data(), &length, reinterpret_cast<const Bytef*>(packed.data()), packed.size());
  require(status == Z_OK && length == elements * element_bytes, ErrorCode::bad_input,
          "a packed array is damaged or has another size than it claims");
  auto* to = static_cast<unsigned char*>(data);
  for (std::size_t b = 0; b < element_bytes; ++b)
    for (std::size_t i = 0; i < elements; ++i) to[i * element_bytes + b] = sorted[b * elements + i];
}

bool may_hold(std::string_view packed, std::size_t bytes) {
  // Deflate shrinks at most about 1032 times (zlib's technical notes).
  return bytes <= (packed.size() + 1) * 1040;
}

}  // namespace periplus::object_model

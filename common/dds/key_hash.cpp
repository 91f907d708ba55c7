#include "common/dds/key_hash.h"

#include <algorithm>

#include "common/core/hash.h"

namespace periplus::dds {

std::optional<KeyHash> key_hash(const Codec& codec, const void* sample, bool force_md5) {
  KeyHash hash{};
  if (!codec.keyed) return hash;
  std::vector<std::uint8_t> key;
  if (!codec.key_be(sample, key)) return std::nullopt;
  if (force_md5 || codec.key_md5) return md5(key.data(), key.size());
  std::copy_n(key.begin(), std::min(hash.size(), key.size()), hash.begin());
  return hash;
}

}  // namespace periplus::dds

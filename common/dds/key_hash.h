// What a sample's instance is known by on the wire (DDSI-RTPS 9.6.3.8).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/dds/codec.h"

namespace periplus::dds {

using KeyHash = std::array<std::uint8_t, 16>;

// The key in big-endian CDR, filled up with zeros; its MD5 where `force_md5` or the type's largest key is over 16 bytes. Zeros
// for a type without key; nothing if the key cannot be encoded.
std::optional<KeyHash> key_hash(const Codec& codec, const void* sample, bool force_md5);

}  // namespace periplus::dds

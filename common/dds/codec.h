// (De)serialiser of a generated IDL type, type-erased: knows no vendor, so both vendors carry the same C++ types.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace periplus::dds {

struct Codec {
  std::string type_name;                                                    // "periplus::msg::CaptureRequest"
  bool keyed = false;
  bool key_md5 = false;                                                     // largest key over 16 bytes
  std::size_t (*size)(const void*) = nullptr;                               // with the 4 bytes of encapsulation
  std::size_t (*encode)(const void*, std::uint8_t*, std::size_t) noexcept = nullptr;  // 0: failed
  bool (*decode)(const std::uint8_t*, std::size_t, void*) noexcept = nullptr;         // false: bad sample
  bool (*key_le)(const void*, std::vector<std::uint8_t>&) noexcept = nullptr;
  bool (*key_be)(const void*, std::vector<std::uint8_t>&) noexcept = nullptr;
  void* (*create)() = nullptr;
  void (*destroy)(void*) = nullptr;
};

// Defined in codec_impl.h, which only files that know wire types include.
template <class T>
const Codec& codec();

}  // namespace periplus::dds

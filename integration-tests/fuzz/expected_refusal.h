// What a fuzzed reader may answer: a result, or a refusal. Anything else ends the program, which is how a fuzzer hears of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "common/core/error.h"

namespace periplus::fuzz {

inline std::string_view text(const std::uint8_t* data, std::size_t size) { return {reinterpret_cast<const char*>(data), size}; }

// Takes the first octet, which tells what follows; 0 of nothing.
inline std::uint8_t take_kind(const std::uint8_t*& data, std::size_t& size) { return size == 0 ? std::uint8_t{0} : (--size, *data++); }

[[noreturn]] inline void finding(const std::string& what) {
  std::fprintf(stderr, "finding: %s\n", what.c_str());
  std::abort();
}

// How many results the readers have given, and why the last refusal: by these periplus-fuzz-replay tells whether a seed is read at all.
inline long accepted = 0;
inline std::string refusal;

// What read() returns; nothing if it refuses. `internal` is no refusal but a defect of ours.
template <class Read>
std::optional<std::invoke_result_t<Read>> result_or_refusal(Read&& read) {
  try {
    auto result = read();
    ++accepted;
    return result;
  } catch (const Error& error) {
    if (error.code() == ErrorCode::internal || error.code() == ErrorCode::ok) finding(std::string("an input is answered with ") + to_string(error.code()) + ": " + error.what());
    if (*error.what() == '\0') finding("a refusal says nothing");
    refusal = error.what();
    return std::nullopt;
  }
}

// For what must not be refused: the program wrote it itself.
template <class Read>
auto must_read(const char* what, Read&& read) {
  auto result = result_or_refusal([&]() -> std::invoke_result_t<Read> {
    try {
      return read();
    } catch (const Error& error) {
      finding(std::string(what) + ", and is refused: " + error.what());
    }
  });
  return std::move(*result);
}

}  // namespace periplus::fuzz

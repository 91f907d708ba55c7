// Reading of generated types from hostile bytes. The generated deserialize() functions call read_checked() for each
// member (checked_reads.awk rewrites them): a sequence that is longer than its IDL bound is refused; one of structures or
// strings grows as its elements are read, so that memory stays proportional to the bytes that really came, whatever
// length stands before them; a string longer than its IDL bound is refused instead of cut. Errors are exceptions of
// Fast-CDR, caught by the codec.
#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/exceptions/BadParamException.h>

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace periplus::idl {

template <class T>
void read_checked(eprosima::fastcdr::Cdr& cdr, T& value) {
  cdr >> value;
}

template <class T>
void read_checked(eprosima::fastcdr::Cdr& cdr, std::vector<T>& sequence, std::uint32_t most = std::numeric_limits<std::uint32_t>::max()) {
  auto begin = cdr.getState();
  std::uint32_t length = 0;
  cdr >> length;
  if (length > most) throw eprosima::fastcdr::exception::BadParamException("a sequence is longer than its bound in the IDL");
  if constexpr (std::is_arithmetic_v<T>) {
    cdr.setState(begin);
    cdr >> sequence;  // compares the length with the bytes left before it allocates
  } else {
    sequence.clear();
    for (std::uint32_t i = 0; i < length; ++i) {
      sequence.emplace_back();
      read_checked(cdr, sequence.back());
    }
  }
}

template <class T, std::size_t n>
void read_checked(eprosima::fastcdr::Cdr& cdr, std::array<T, n>& array) {
  if constexpr (std::is_arithmetic_v<T>) {
    cdr >> array;
  } else {
    for (T& element : array) read_checked(cdr, element);
  }
}

template <class FixedString>
void assign_bounded(FixedString& to, const std::string& from) {
  if (from.size() > FixedString::max_size) {
    throw eprosima::fastcdr::exception::BadParamException("a string is longer than its bound in the IDL");
  }
  to = from;
}

}  // namespace periplus::idl

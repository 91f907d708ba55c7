// Reading of generated types from hostile bytes. The generated deserialize() functions call read_checked() for each
// member (deploy/cmake/PeriplusIdl.cmake rewrites them): a sequence of structures or strings grows as its elements are
// read, so that memory stays proportional to the bytes that really came, whatever length stands before them; a string
// longer than its IDL bound is refused instead of cut. Errors are exceptions of Fast-CDR, caught by the codec.
#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/exceptions/BadParamException.h>

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace periplus::dds {

template <class T>
void read_checked(eprosima::fastcdr::Cdr& cdr, T& value) {
  cdr >> value;
}

template <class T>
void read_checked(eprosima::fastcdr::Cdr& cdr, std::vector<T>& sequence) {
  if constexpr (std::is_arithmetic_v<T>) {
    cdr >> sequence;  // compares the length with the bytes left before it allocates
  } else {
    std::uint32_t length = 0;
    cdr >> length;
    sequence.clear();
    for (std::uint32_t i = 0; i < length; ++i) {
      sequence.emplace_back();
      read_checked(cdr, sequence.back());
    }
  }
}

template <class FixedString>
void assign_bounded(FixedString& to, const std::string& from) {
  if (from.size() > FixedString::max_size) {
    throw eprosima::fastcdr::exception::BadParamException("a string is longer than its bound in the IDL");
  }
  to = from;
}

}  // namespace periplus::dds

// codec<T>() and rpc_access<Request, Reply>() for types of fastddsgen, over Fast-CDR. Include it where wire types are
// used (services' *_service.cpp, common/wire); it knows no vendor's middleware.
#pragma once

#include <cxxabi.h>
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <typeinfo>

#include "common/dds/codec.h"
#include "common/dds/rpc.h"

namespace periplus::dds {
namespace detail {

template <class T>
std::size_t encode_sample(const void* sample, std::uint8_t* bytes, std::size_t capacity) noexcept {
  try {
    eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(bytes), capacity);
    eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::LITTLE_ENDIANNESS, eprosima::fastcdr::Cdr::DDS_CDR);
    cdr.serialize_encapsulation();
    static_cast<const T*>(sample)->serialize(cdr);
    return cdr.getSerializedDataLength();
  } catch (...) {
    return 0;
  }
}

template <class T>
bool decode_sample(const std::uint8_t* bytes, std::size_t length, void* sample) noexcept {
  try {
    if (length < 4) return false;
    eprosima::fastcdr::FastBuffer buffer(const_cast<char*>(reinterpret_cast<const char*>(bytes)), length);
    eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR);
    cdr.read_encapsulation();
    static_cast<T*>(sample)->deserialize(cdr);
    return true;
  } catch (...) {
    return false;
  }
}

// With encapsulation as payload of a dispose; bare and big-endian for the key hash (DDSI-RTPS 9.6.3.8).
template <class T, bool payload>
bool encode_key(const void* sample, std::vector<std::uint8_t>& out) noexcept {
  try {
    using eprosima::fastcdr::Cdr;
    eprosima::fastcdr::FastBuffer buffer;
    Cdr cdr(buffer, payload ? Cdr::LITTLE_ENDIANNESS : Cdr::BIG_ENDIANNESS, payload ? Cdr::DDS_CDR : Cdr::CORBA_CDR);
    if (payload) cdr.serialize_encapsulation();
    static_cast<const T*>(sample)->serializeKey(cdr);
    const auto* begin = reinterpret_cast<const std::uint8_t*>(buffer.getBuffer());
    out.assign(begin, begin + cdr.getSerializedDataLength());
    return true;
  } catch (...) {
    return false;
  }
}

}  // namespace detail

template <class T>
const Codec& codec() {
  static const Codec instance = [] {
    int status = 0;
    const std::unique_ptr<char, void (*)(void*)> name(abi::__cxa_demangle(typeid(T).name(), nullptr, nullptr, &status), std::free);
    Codec c;
    c.type_name = name ? name.get() : typeid(T).name();
    c.keyed = T::isKeyDefined();
    c.key_md5 = T::getKeyMaxCdrSerializedSize() > 16;
    c.size = [](const void* sample) -> std::size_t { return 4 + T::getCdrSerializedSize(*static_cast<const T*>(sample)); };
    c.encode = detail::encode_sample<T>;
    c.decode = detail::decode_sample<T>;
    c.key_le = detail::encode_key<T, true>;
    c.key_be = detail::encode_key<T, false>;
    c.create = []() -> void* { return new T; };
    c.destroy = [](void* sample) { delete static_cast<T*>(sample); };
    return c;
  }();
  return instance;
}

namespace detail {

template <class Req, class Rep>
const RpcAccess& rpc_access() {
  static const RpcAccess instance = {
      .request = &codec<Req>(),
      .reply = &codec<Rep>(),
      .get_request_header =
          [](const void* request, CallName& name) {
            const auto& header = static_cast<const Req*>(request)->header();
            name = {header.client().value(), header.number(), header.server().value()};
          },
      .set_request_header =
          [](void* request, const CallName& name) {
            auto& header = static_cast<Req*>(request)->header();
            header.client().value(name.client);
            header.number(name.number);
            header.server().value(name.server);
          },
      .get_reply_header =
          [](const void* reply, CallName& name, std::int32_t& code, std::string& message) {
            const auto& header = static_cast<const Rep*>(reply)->header();
            name = {header.client().value(), header.number(), {}};
            code = header.error_code();
            message = header.error_message().to_string();
          },
      .set_reply_header =
          [](void* reply, const CallName& name, std::int32_t code, const std::string& message) {
            auto& header = static_cast<Rep*>(reply)->header();
            header.client().value(name.client);
            header.number(name.number);
            header.error_code(code);
            header.error_message(message);
          },
      .assign_reply = [](void* to, const void* from) { *static_cast<Rep*>(to) = *static_cast<const Rep*>(from); },
      .copy_request = [](const void* request) -> void* { return new Req(*static_cast<const Req*>(request)); },
  };
  return instance;
}

}  // namespace detail
}  // namespace periplus::dds

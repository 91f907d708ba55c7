#include "common/dds/cyclonedds/sertype.h"

#include <dds/features.h>
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <vector>

#include "common/dds/key_hash.h"

namespace periplus::dds::cyclonedds {
namespace {

using Sample = std::unique_ptr<void, void (*)(void*)>;

struct Sertype : ddsi_sertype {
  const Codec* codec;
};

struct Serdata : ddsi_serdata {
  Serdata(const ddsi_sertype* sertype, ddsi_serdata_kind sample_kind) : codec(static_cast<const Sertype*>(sertype)->codec) {
    ddsi_serdata_init(this, sertype, sample_kind);
  }
  ~Serdata() { std::free(bytes); }
  Serdata(const Serdata&) = delete;
  Serdata& operator=(const Serdata&) = delete;

  void allocate(std::size_t n) {
    size = n;
    const std::size_t padded = std::max<std::size_t>(4, (n + 3) & ~std::size_t{3});  // Cyclone sends whole words
    bytes = static_cast<std::uint8_t*>(std::malloc(padded));
    if (!bytes) throw std::bad_alloc();
    std::memset(bytes + padded - 4, 0, 4);
  }
  void copy(const std::vector<std::uint8_t>& from) {
    allocate(from.size());
    std::copy(from.begin(), from.end(), bytes);
  }

  bool hash_key(const void* sample, bool force_md5, ddsi_keyhash_t& hash_out) const {
    const auto found = key_hash(*codec, sample, force_md5);
    if (!found) return false;
    static_assert(sizeof hash_out.value == sizeof *found);
    std::memcpy(hash_out.value, found->data(), found->size());
    return true;
  }
  void set_hash() {
    std::uint32_t first = 0, last = 0;
    std::memcpy(&first, key.value, 4);
    std::memcpy(&last, key.value + 12, 4);
    hash = first ^ last * 2654435761U ^ 0x5bd1e995U;
  }
  bool identify(const void* sample) {
    if (!hash_key(sample, false, key)) return false;
    set_hash();
    return true;
  }
  // A payload that does not decode keeps the key hash zero and goes on to take(), where it is counted.
  void received() {
    if (codec->keyed) {
      const Sample sample(codec->create(), codec->destroy);
      const bool decoded = codec->decode(bytes, size, sample.get());
      // A key-only payload ends after the leading @key members, which are filled by then.
      if (decoded || kind == SDK_KEY) hash_key(sample.get(), false, key);
    }
    set_hash();
  }

  std::uint8_t* bytes = nullptr;
  std::size_t size = 0;
  ddsi_keyhash_t key{};
  const Codec* codec;
};

const Serdata& serdata(const ddsi_serdata* data) { return *static_cast<const Serdata*>(data); }

// Cyclone's callbacks are C: nothing may be thrown through them.
template <class Make>
ddsi_serdata* guarded(Make make) noexcept {
  try {
    return make();
  } catch (...) {
    return nullptr;
  }
}

ddsi_serdata* from_fragments(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment, std::size_t size) {
  return guarded([&]() -> ddsi_serdata* {
    auto data = std::make_unique<Serdata>(type, kind);
    data->allocate(size);
    std::uint32_t offset = 0;
    for (; fragment && offset < size; fragment = fragment->nextfrag) {
      if (fragment->maxp1 <= offset) continue;  // repeats what is there
      const std::size_t n = std::min<std::size_t>(fragment->maxp1 - offset, size - offset);
      const auto* payload = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
      std::memcpy(data->bytes + offset, payload + offset - fragment->min, n);
      offset += static_cast<std::uint32_t>(n);
    }
    data->received();
    return data.release();
  });
}

ddsi_serdata* from_vectors(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count, const ddsrt_iovec_t* vectors,
                           std::size_t size) {
  return guarded([&]() -> ddsi_serdata* {
    auto data = std::make_unique<Serdata>(type, kind);
    data->allocate(size);
    std::size_t offset = 0;
    for (ddsrt_msg_iovlen_t i = 0; i < count && offset < size; ++i) {
      const std::size_t n = std::min<std::size_t>(vectors[i].iov_len, size - offset);
      std::memcpy(data->bytes + offset, vectors[i].iov_base, n);
      offset += n;
    }
    data->received();
    return data.release();
  });
}

ddsi_serdata* from_key_hash(const ddsi_sertype* type, const ddsi_keyhash_t* key) {
  return guarded([&]() -> ddsi_serdata* {
    auto data = std::make_unique<Serdata>(type, SDK_KEY);
    data->copy({0, 1, 0, 0});
    data->key = *key;
    data->set_hash();
    return data.release();
  });
}

ddsi_serdata* from_sample(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* sample) {
  return guarded([&]() -> ddsi_serdata* {
    auto data = std::make_unique<Serdata>(type, kind);
    if (kind == SDK_KEY) {
      std::vector<std::uint8_t> key;
      if (!data->codec->key_le(sample, key)) return nullptr;
      data->copy(key);
    } else {
      data->allocate(data->codec->size(sample));
      data->size = data->codec->encode(sample, data->bytes, data->size);
      if (data->size == 0) return nullptr;
    }
    return data->identify(sample) ? data.release() : nullptr;
  });
}

ddsi_serdata* to_untyped(const ddsi_serdata* from) {
  return guarded([&]() -> ddsi_serdata* {
    const Serdata& source = serdata(from);
    auto data = std::make_unique<Serdata>(from->type, SDK_KEY);
    std::vector<std::uint8_t> key{0, 1, 0, 0};
    if (source.codec->keyed) {
      if (from->kind == SDK_KEY) {
        key.assign(source.bytes, source.bytes + source.size);
      } else {
        const Sample sample(source.codec->create(), source.codec->destroy);
        source.codec->decode(source.bytes, source.size, sample.get());
        source.codec->key_le(sample.get(), key);
      }
    }
    data->copy(key);
    data->key = source.key;
    data->hash = from->hash;
    data->type = nullptr;
    return data.release();
  });
}

const ddsi_serdata_ops& serdata_operations() {
  static const ddsi_serdata_ops operations = [] {
    ddsi_serdata_ops o;
    std::memset(&o, 0, sizeof o);
    o.eqkey = [](const ddsi_serdata* a, const ddsi_serdata* b) { return std::memcmp(serdata(a).key.value, serdata(b).key.value, 16) == 0; };
    o.get_size = [](const ddsi_serdata* d) { return static_cast<std::uint32_t>(serdata(d).size); };
    o.from_ser = from_fragments;
    o.from_ser_iov = from_vectors;
    o.from_keyhash = from_key_hash;
    o.from_sample = from_sample;
    o.to_ser = [](const ddsi_serdata* d, std::size_t offset, std::size_t n, void* to) { std::memcpy(to, serdata(d).bytes + offset, n); };
    o.to_ser_ref = [](const ddsi_serdata* d, std::size_t offset, std::size_t n, ddsrt_iovec_t* vector) {
      vector->iov_base = serdata(d).bytes + offset;
      vector->iov_len = n;
      return ddsi_serdata_ref(d);
    };
    o.to_ser_unref = [](ddsi_serdata* d, const ddsrt_iovec_t*) { ddsi_serdata_unref(d); };
    o.to_sample = [](const ddsi_serdata* d, void* sample, void**, void*) { return decode(d, *serdata(d).codec, sample) || d->kind == SDK_KEY; };
    o.to_untyped = to_untyped;
    o.untyped_to_sample = [](const ddsi_sertype*, const ddsi_serdata* d, void* sample, void**, void*) {
      decode(d, *serdata(d).codec, sample);
      return true;
    };
    o.free = [](ddsi_serdata* d) { delete static_cast<Serdata*>(d); };
    o.print = [](const ddsi_sertype*, const ddsi_serdata* d, char* text, std::size_t n) {
      return static_cast<std::size_t>(std::snprintf(text, n, "(%zu bytes)", serdata(d).size));
    };
    o.get_keyhash = [](const ddsi_serdata* d, ddsi_keyhash_t* hash, bool force_md5) {
      const Serdata& data = serdata(d);
      *hash = data.key;
      if (!force_md5 || data.codec->key_md5) return;
      const Sample sample(data.codec->create(), data.codec->destroy);
      data.codec->decode(data.bytes, data.size, sample.get());
      data.hash_key(sample.get(), true, *hash);
    };
    return o;
  }();
  return operations;
}

const ddsi_sertype_ops& sertype_operations() {
  static const ddsi_sertype_ops operations = [] {
    ddsi_sertype_ops o;
    std::memset(&o, 0, sizeof o);
    o.version = ddsi_sertype_v0;
    o.free = [](ddsi_sertype* t) {
      ddsi_sertype_fini(t);
      delete static_cast<Sertype*>(t);
    };
    // Loans are never used (dds_takecdr only), so there are no samples for Cyclone to manage.
    o.zero_samples = [](const ddsi_sertype*, void*, std::size_t) {};
    o.realloc_samples = [](void**, const ddsi_sertype*, void*, std::size_t, std::size_t) {};
    o.free_samples = [](const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {};
    o.equal = [](const ddsi_sertype* a, const ddsi_sertype* b) {
      return static_cast<const Sertype*>(a)->codec == static_cast<const Sertype*>(b)->codec;
    };
    o.hash = [](const ddsi_sertype*) { return 0U; };
    return o;
  }();
  return operations;
}

}  // namespace

dds_entity_t create_topic(dds_entity_t participant, const char* name, const Codec& codec) {
  auto* type = new Sertype;
  std::memset(static_cast<void*>(type), 0, sizeof *type);
  type->codec = &codec;
  ddsi_sertype_init_flags(type, codec.type_name.c_str(), &sertype_operations(), &serdata_operations(),
                          codec.keyed ? DDSI_SERTYPE_FLAG_REQUEST_KEYHASH : DDSI_SERTYPE_FLAG_TOPICKIND_NO_KEY);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  ddsi_sertype* handed_over = type;
  const dds_entity_t topic = dds_create_topic_sertype(participant, name, &handed_over, nullptr, nullptr, nullptr);
  if (topic < 0) ddsi_sertype_unref(type);
  return topic;
}

bool decode(const ddsi_serdata* data, const Codec& codec, void* sample) {
  return codec.decode(serdata(data).bytes, serdata(data).size, sample);
}

void release(ddsi_serdata* data) { ddsi_serdata_unref(data); }

}  // namespace periplus::dds::cyclonedds

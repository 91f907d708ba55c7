// Cyclone DDS carries the types of fastddsgen through a sertype of our own, which (de)serialises with the codec.
#pragma once

#include <dds/dds.h>

#include "common/dds/codec.h"

struct ddsi_serdata;

namespace periplus::dds::cyclonedds {

// A topic of `codec`'s type; `codec` outlives it. Negative: the vendor's error code.
dds_entity_t create_topic(dds_entity_t participant, const char* name, const Codec& codec);

// Decodes a sample got from dds_takecdr. False: a bad sample.
bool decode(const ddsi_serdata* data, const Codec& codec, void* sample);
void release(ddsi_serdata* data);

}  // namespace periplus::dds::cyclonedds

// Stored models as earlier versions wrote them.
#pragma once

#include <cstdint>
#include <vector>

#include "common/object_model/compression.h"
#include "common/object_model/model.pb.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model::testing {

// As versions 1 and 2 wrote evidence and distances: a value for every voxel, z fastest.
inline void put_every_voxel(const ObjectModel& model, proto::Model& m) {
  const voxel::GridGeometry& g = model.grid().geometry();
  std::vector<std::uint16_t> points, seen, solid;
  std::vector<std::uint8_t> votes;
  std::vector<TsdfSample> tsdf;
  for_each_voxel(g, [&](const Eigen::Vector3i& v) {
    const VoxelEvidence e = model.state().evidence.at(v);
    points.push_back(e.points);
    seen.push_back(e.seen);
    solid.push_back(e.solid);
    votes.push_back(e.votes);
    tsdf.push_back(model.state().tsdf.at(v));
  });
  const auto put = [](const auto& from, proto::Array& to) {
    to.set_elements(from.size());
    to.set_element_bytes(sizeof from[0]);
    to.set_deflated(pack_bytes(from.data(), from.size(), sizeof from[0]));
  };
  put(points, *m.mutable_points());
  put(seen, *m.mutable_seen());
  put(solid, *m.mutable_solid());
  put(votes, *m.mutable_votes());
  put(tsdf, *m.mutable_tsdf());
  m.clear_evidence_bricks();
  m.clear_tsdf_bricks();
  m.clear_tsdf_free();
  m.clear_tsdf_distinct();
  m.clear_tsdf_places();
}

// As version 3 wrote distances: a sample for each voxel of the bricks named.
inline void put_every_sample(const ObjectModel& model, proto::Model& m) {
  std::vector<TsdfSample> samples;
  const voxel::BrickField<PackedTsdfBrick>& bricks = model.state().tsdf.bricks();
  for (std::size_t b = 0; b < bricks.size(); ++b) {
    if (!bricks.find(b)) continue;
    for (int n = 0; n < voxel::kBrickVoxels; ++n) samples.push_back(bricks.find(b)->at(n));
  }
  m.mutable_tsdf()->set_elements(samples.size());
  m.mutable_tsdf()->set_deflated(pack_bytes(samples.data(), samples.size(), sizeof(TsdfSample)));
  m.clear_tsdf_distinct();
  m.clear_tsdf_places();
}

}  // namespace periplus::object_model::testing

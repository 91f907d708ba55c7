// Which samples of the true surface a depth map covers, and which a camera can see.
//
// covered   a point of the depth map lies within `distance` of the sample: the reconstructed surface are the depth maps' points
//           themselves, without voxels or meshing in between;
// visible   the straight line from the camera to the sample is free, meets it at no more than 75 degrees from its normal, and
//           the sample projects into the image.
#pragma once

#include <vector>

#include "common/mesh/triangle_mesh.h"
#include "common/mesh/triangle_tree.h"
#include "common/object_model/perception.h"
#include "integration-tests/nbv_benchmark/mask.h"

namespace periplus::nbv_benchmark {

// Adds the samples (frame of `X_SC`: camera in the samples' frame) that the points of `depth` cover. Depth 0 is none. Exact:
// every pixel whose point can lie within `distance` is looked at. Throws Error(bad_size) if the image does not fit the camera.
void add_covered(const std::vector<mesh::SurfaceSample>& samples, const ImageF& depth, const Pinhole& camera, const Pose& X_SC,
                 double distance, Mask& covered);

// Where a camera stands and what may stand in the way.
struct Viewer {
  Pinhole camera;
  std::vector<Pose> X_SC;   // all of these must see a sample at once: one camera, or both eyes of a pair
};

// Adds what the viewer sees and was not in `visible` before. `points` and `normals` of the surface, in the frame of `tree`.
void add_visible(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& normals,
                 const std::vector<const mesh::TriangleTree*>& occluders, const Viewer& viewer, Mask& visible);

}  // namespace periplus::nbv_benchmark

// A triangle mesh among the solids of a scene. Its frame S: about the middle of its bounding box, z up, metres.
//
// A closed mesh has an inside. One that is not, a sheet or a scan with holes, is a skin: it hides and is run into, but nothing is in it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/mesh/triangle_mesh.h"
#include "common/mesh/triangle_tree.h"

namespace periplus::scene {

// Immutable: may be shared between threads.
class MeshSolid {
 public:
  // Each triangle costs whoever evaluates views about a microsecond a view.
  static constexpr std::size_t kMostTriangles = 10000;

  // Moves the mesh to the middle of its bounding box; one that is closed and faces inwards is turned. Throws Error(bad_input |
  // not_finite | bad_size): no triangles, too many, arrays that do not fit each other.
  explicit MeshSolid(mesh::TriangleMesh mesh);
  // As mesh::load_named does, turned upright and scaled. Throws Error(io) if there is no such file, and as above.
  static std::shared_ptr<const MeshSolid> load(const std::string& name, double longest_side, std::string_view up_axis);

  const mesh::TriangleMesh& mesh() const { return mesh_; }
  const Eigen::Vector3d& size() const { return size_; }  // of the bounding box
  bool closed() const { return closed_; }

  // Of a point, negative inside; `gradient`: the unit direction in which it grows.
  double distance(const Eigen::Vector3d& p_S, Eigen::Vector3d& gradient_S) const;
  // Of the segment a-b: where on it, as share of the way, and that point's distance(). If it meets the mesh or is inside: at its
  // deepest of some points, a bound of the depth.
  double segment_distance(const Eigen::Vector3d& a_S, const Eigen::Vector3d& b_S, double& share, Eigen::Vector3d& gradient_S) const;
  // First hit of the segment from p to p + d, as share of the way in 0..1; 0 from inside.
  std::optional<double> first_hit(const Eigen::Vector3d& p_S, const Eigen::Vector3d& d_S) const;

 private:
  bool inside(const Eigen::Vector3d& p_S) const;

  mesh::TriangleMesh mesh_;
  Eigen::Vector3d size_;
  bool closed_ = false;
  mesh::TriangleTree tree_;
};

}  // namespace periplus::scene

// Pictures and depth of scene and object from any camera, drawn by MuJoCo without a display. Diffuse light without
// shadows, reflections and highlights: the same surface point has the same colour in both eyes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/geometry/pose.h"
#include "common/mesh/triangle_mesh.h"
#include "common/scene/scene.h"

namespace periplus::render {

// The object of a scene as it stands in the world.
struct TrueObject {
  std::string path;               // of the mesh file
  std::string texture;            // as of scene::Solid
  ImageU8 picture;                // RGB, in place of the texture, unless empty
  Eigen::Vector3d rgb{0.7, 0.7, 0.7};  // where there is neither
  mesh::TriangleMesh mesh_W;      // world frame [m], with texture coordinates and normals
  double scale = 1;               // metres per mesh unit
  Pose X_WM = Pose::Identity();   // p_W = X_WM * (scale * p of the file)
};

// Throws Error with the mesh's fault. Texture coordinates are the file's own if the texture is a file and there are any,
// otherwise six projections. `folders` are searched before the assets folder.
TrueObject load_true_object(const scene::Truth& truth, const std::vector<std::string>& folders = {});

struct RendererOptions {
  std::string backend = "auto";   // egl | osmesa | auto
  int threads = 2;                // of the software rasteriser; results do not depend on it
  int max_width = 640, max_height = 480;  // largest picture [px]
  int samples = 0;                // a pixel, against jagged edges; depth is exact with 0 only
  double near_m = 0.05, far_m = 40;
  std::vector<std::string> asset_folders;
};

struct RenderedView {
  ImageU8 colour;                 // RGB
  ImageF depth;                   // z along the optical axis [m]; 0 where nothing is
};

// May be used from several threads, one at a time.
class Renderer {
 public:
  // Throws Error(sim_scene_bad) if the world cannot be built, Error(sim_render_failed) if there is nothing to draw with,
  // Error(io) for missing textures.
  Renderer(const scene::Scene& scene, const std::vector<TrueObject>& objects, const RendererOptions& options = {});
  ~Renderer();

  // `X_WC` is an optical frame; fx and fy must be equal. Throws Error(bad_input) for another camera, Error(bad_size) for
  // pictures larger than the options say.
  RenderedView render(const Pose& X_WC, const Pinhole& camera);

  const std::string& backend() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::render

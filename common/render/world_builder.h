// Scene and objects as MuJoCo's XML with its meshes and textures. Inside common/render only.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/geometry/image.h"
#include "common/render/renderer.h"
#include "common/scene/scene.h"

namespace periplus::render {

struct World {
  std::string xml;
  std::vector<std::pair<std::string, std::string>> meshes;   // file name, bytes of a .msh
  std::vector<std::pair<std::string, ImageU8>> textures;     // name in the XML, picture to be filled in after compiling
};

World build_world(const scene::Scene& scene, const std::vector<TrueObject>& objects, const RendererOptions& options);

}  // namespace periplus::render

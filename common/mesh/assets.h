// Where meshes and textures named in a scene are found.
#pragma once

#include <string>
#include <vector>

namespace periplus::mesh {

// $PERIPLUS_ASSETS, else $XDG_CACHE_HOME or ~/.cache below which periplus/assets stands; filled by deploy/fetch-assets.sh.
std::string assets_folder();

// Path of the file: `name` itself if absolute; else below each of `folders`, then below assets_folder(). Throws Error(io) that
// names the folders searched.
std::string find_asset(const std::string& name, const std::vector<std::string>& folders = {});

}  // namespace periplus::mesh

// Objects of the larger scenes, made by us so that no file is needed: a scene names them "made:ship" and so on, and paints them with
// "materials:<seed>". Closed parts that reach into one another, z up, standing on z = 0, with texture coordinates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/triangle_mesh.h"

namespace periplus::mesh {

bool is_made(std::string_view name);   // begins with "made:"
const std::vector<std::string>& made_models();

// A three-master of 0.5 m on its cradle: hull with raised decks, masts, yards, sails, bowsprit (after thesis Fig. 3.10).
TriangleMesh make_ship();
// An abstract statue of 2 m: plinth, a twisted body with deep grooves, two rings one can look through, head and spire (Fig. 3.9).
TriangleMesh make_statue();
// A treehouse of 3 m: trunk with roots, platform on struts, hut with door and window, ladder, railing, crown (Fig. 5.9).
TriangleMesh make_treehouse();

// By name ("made:ship"); throws Error(bad_input) that lists the names.
TriangleMesh make_model(std::string_view name);
// As make_model() for made ones; other names are files, looked for as find_asset() does. Sets `path` to what was found.
TriangleMesh load_named(const std::string& name, const std::vector<std::string>& folders, std::string& path);

}  // namespace periplus::mesh

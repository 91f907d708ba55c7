#include "common/object_model/model_export.h"

#include <array>
#include <charconv>

#include "common/core/error.h"
#include "common/geometry/ply.h"
#include "common/object_model/feature_direction.h"
#include "common/object_model/landmarks.h"
#include "common/object_model/model_file.h"

namespace periplus::object_model {

namespace {

SurfaceMesh surface_of(const ObjectModel& model, const CarvingSettings& settings) {
  const ModelState& s = model.state();
  return extract_surface(s.grid, s.tsdf, settings.truncation_voxels * s.grid.geometry().voxel_size);
}

constexpr std::array kFormats{
    ExportFormat{"periplus", ".periplus", "the whole model with its views, to go on learning"},
    ExportFormat{"ply", ".ply", "coloured triangles, binary"},
    ExportFormat{"obj", ".obj", "triangles with colours and normals, text"},
    ExportFormat{"glb", ".glb", "coloured triangles, binary glTF 2.0, y up"},
    ExportFormat{"points.ply", ".points.ply", "one point with normal and colour for each known voxel, binary"},
    ExportFormat{"pcd", ".pcd", "the same points for PCL"},
    ExportFormat{"bt", ".bt", "occupied, free and unknown as an OctoMap"},
    ExportFormat{"ot", ".ot", "the same with colours, a ColorOcTree of OctoMap"},
    ExportFormat{"features.csv", ".features.csv", "the visual features of each view with their landmarks and descriptors, text"},
};

using Write = std::string (*)(const ObjectModel&, const CarvingSettings&);
// In the order of kFormats.
constexpr std::array<Write, kFormats.size()> kWriters{
    [](const ObjectModel& m, const CarvingSettings&) { return write_model(m); },
    [](const ObjectModel& m, const CarvingSettings& s) { return to_ply(surface_of(m, s)); },
    [](const ObjectModel& m, const CarvingSettings& s) { return to_obj(surface_of(m, s)); },
    [](const ObjectModel& m, const CarvingSettings& s) { return to_glb(surface_of(m, s)); },
    [](const ObjectModel& m, const CarvingSettings&) { return to_ply(surface_points(m)); },
    [](const ObjectModel& m, const CarvingSettings&) { return to_pcd(surface_points(m)); },
    [](const ObjectModel& m, const CarvingSettings&) { return export_bt(m); },
    [](const ObjectModel& m, const CarvingSettings&) { return export_ot(m); },
    [](const ObjectModel& m, const CarvingSettings&) { return features_csv(m); },
};

template <class T>
void append_number(std::string& out, T value) {
  char text[32];
  out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}

// An identifier may hold anything.
std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) out.append(c == '"' ? 2 : 1, c);
  return out + "\"";
}

}  // namespace

std::span<const ExportFormat> export_formats() { return kFormats; }

std::string export_model(const ObjectModel& model, std::string_view format, const CarvingSettings& settings) {
  settings.check();
  std::string names;
  for (std::size_t i = 0; i < kFormats.size(); ++i) {
    if (format == kFormats[i].name) return kWriters[i](model, settings);
    names += (i ? ", " : "") + std::string(kFormats[i].name);
  }
  throw_error(ErrorCode::bad_input, "no model is written as `" + std::string(format.substr(0, 32)) + "`; the formats are " + names);
}

std::string to_ply(const SurfaceMesh& mesh) { return encode_ply(mesh.vertices, mesh.colors, mesh.triangles, "metres, world frame, z up"); }

std::string export_ply(const ObjectModel& model, const CarvingSettings& settings) { return to_ply(surface_of(model, settings)); }

std::string features_csv(const ObjectModel& model) {
  std::string out =
      "view,u_px,v_px,size_px,angle_rad,x_m,y_m,z_m,normal_x,normal_y,normal_z,size_m,direction_x,direction_y,direction_z,landmark,descriptor_kind,descriptor\r\n";
  const auto& views = model.state().views;
  std::vector<std::vector<std::size_t>> landmark_of(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) landmark_of[v].resize(views[v]->features.size());
  const std::vector<SeenLandmark> landmarks = merge_landmarks(views);
  for (std::size_t l = 0; l < landmarks.size(); ++l)
    for (const Observation& o : landmarks[l].seen) landmark_of[o.view][o.feature] = l;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (std::size_t i = 0; i < views[v]->features.size(); ++i) {
      const auto& view = views[v];
      const Feature& f = view->features[i];
      out += quoted(view->view_id);
      for (const float value : {f.u, f.v, f.size, f.angle}) append_number(out += ',', value);
      for (const Eigen::Vector3d& vector : {f.p_W, f.normal_W})
        for (int n = 0; n < 3; ++n) append_number(out += ',', vector[n]);
      append_number(out += ',', f.size_m);
      const Eigen::Vector3d direction = surface_direction(f, view->rig.camera, view->X_WC);
      for (int axis = 0; axis < 3; ++axis) append_number(out += ',', direction[axis]);
      append_number(out += ',', landmark_of[v][i]);
      out += std::string(",") + to_string(f.kind) + ',';
      for (const std::uint8_t byte : f.descriptor) {
        out += "0123456789abcdef"[byte >> 4];
        out += "0123456789abcdef"[byte & 15];
      }
      out += "\r\n";
    }
  return out;
}

}  // namespace periplus::object_model

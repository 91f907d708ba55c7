#include "common/render/world_builder.h"

#include <locale>
#include <map>
#include <sstream>

#include "common/core/error.h"
#include "common/core/hash.h"
#include "common/mesh/assets.h"
#include "common/scene/mesh_solid.h"
#include "common/render/texture.h"

namespace periplus::render {
namespace {

constexpr double kAmbient = 0.45;
constexpr double kSolidTileSlack = 1.25;  // room between neighbouring tiles of a texture
constexpr double kLandmarkThickness = 0.006;  // [m]
constexpr double kFloorPicturesPerMetre = 0.5, kSolidPicturesPerMetre = 1.0;
constexpr int kObjectTiles[2] = {3072, 2048}, kWallPixels[2] = {2048, 1024}, kSurfacePixels[2] = {1024, 1024}, kMaterialPixels[2] = {2048, 2048};

class Builder {
 public:
  Builder(const scene::Scene& scene, const std::vector<TrueObject>& objects, const RendererOptions& options) : options_(options) {
    assets_.imbue(std::locale::classic());
    bodies_.imbue(std::locale::classic());
    assets_.precision(17);
    bodies_.precision(17);
    add_room(scene.room);
    add_lights(scene.lights);
    for (const scene::Solid& solid : scene.solids) add_solid(solid);
    for (const scene::Landmark& landmark : scene.landmarks) add_landmark(landmark);
    for (const TrueObject& object : objects)
      add_mesh(object.mesh_W, Pose::Identity(), object.picture.empty() ? material(object.texture, object.rgb, kObjectTiles, 1) : painted(object.picture));
  }

  World finish() {
    std::ostringstream xml;
    xml.imbue(std::locale::classic());
    xml << "<mujoco><compiler angle='radian' autolimits='true'/><visual><global offwidth='" << options_.max_width << "' offheight='"
        << options_.max_height << "'/><quality shadowsize='0' offsamples='" << options_.samples << "'/><headlight ambient='" << kAmbient << ' '
        << kAmbient << ' ' << kAmbient << "' diffuse='0 0 0' specular='0 0 0'/></visual><statistic extent='1' center='0 0 1'/><asset>"
        << assets_.str() << "</asset><worldbody>" << bodies_.str() << "</worldbody></mujoco>";
    world_.xml = xml.str();
    return std::move(world_);
  }

 private:
  // Name of the material with this texture, or with the plain colour if there is none.
  std::string material(const std::string& texture, const Eigen::Vector3d& rgb, const int (&pixels)[2], double repeat, int shift = 0) {
    const std::string name = "material" + std::to_string(materials_++);
    const std::string picture = texture.empty() ? "" : add_texture(texture, pixels, shift);
    assets_ << "<material name='" << name << "' specular='0' shininess='0' reflectance='0' ";
    if (picture.empty()) {
      assets_ << "rgba='" << rgb.x() << ' ' << rgb.y() << ' ' << rgb.z() << " 1'/>";
      return name;
    }
    assets_ << "texture='" << picture << "' texrepeat='" << repeat << ' ' << repeat << "' texuniform='"
            << (repeat == 1 ? "false" : "true") << "'/>";
    return name;
  }

  std::string painted(const ImageU8& picture) {
    const std::string name = "material" + std::to_string(materials_++), texture = "picture" + name;
    assets_ << "<texture name='" << texture << "' type='2d' builtin='flat' width='" << picture.width << "' height='" << picture.height
            << "'/><material name='" << name << "' specular='0' shininess='0' reflectance='0' texture='" << texture << "'/>";
    world_.textures.emplace_back(texture, picture);
    return name;
  }

  std::string add_texture(const std::string& texture, const int (&pixels)[2], int shift) {
    const bool noise = texture.starts_with("noise:"), materials = texture.starts_with("materials:"), made = noise || materials;
    const std::string key = texture + "/" + (made ? std::to_string(pixels[0]) + "/" + std::to_string(shift) : "");
    const auto [it, fresh] = textures_.try_emplace(key, "texture" + std::to_string(textures_.size()));
    if (!fresh) return it->second;
    ImageU8 picture = noise       ? make_texture(pixels[0], pixels[1], std::stoull(texture.substr(6)) * 1000 + static_cast<unsigned>(shift))
                      : materials ? make_materials(kMaterialPixels[0], kMaterialPixels[1], std::stoull(texture.substr(10)))
                                  : load_texture(mesh::find_asset(texture, options_.asset_folders));
    // The picture itself is copied in after compiling: no detour through a file format.
    assets_ << "<texture name='" << it->second << "' type='2d' builtin='flat' width='" << picture.width << "' height='" << picture.height << "'/>";
    world_.textures.emplace_back(it->second, std::move(picture));
    return it->second;
  }

  void add_room(const scene::Room& room) {
    const Eigen::Vector3d h = room.size / 2;
    const std::string floor = material(room.floor_texture, {0.5, 0.45, 0.4}, kSurfacePixels, kFloorPicturesPerMetre);
    plane(h.x(), h.y(), {0, 0, 0}, "1 0 0 0 1 0", floor);
    const Eigen::Vector3d plain(0.8, 0.8, 0.78);
    plane(h.x(), h.z(), {0, h.y(), h.z()}, "1 0 0 0 0 1", material(room.wall_texture, plain, kWallPixels, 1, 0));
    plane(h.x(), h.z(), {0, -h.y(), h.z()}, "-1 0 0 0 0 1", material(room.wall_texture, plain, kWallPixels, 1, 1));
    plane(h.y(), h.z(), {h.x(), 0, h.z()}, "0 -1 0 0 0 1", material(room.wall_texture, plain, kWallPixels, 1, 2));
    plane(h.y(), h.z(), {-h.x(), 0, h.z()}, "0 1 0 0 0 1", material(room.wall_texture, plain, kWallPixels, 1, 3));
  }

  void plane(double half_x, double half_y, const Eigen::Vector3d& p, const char* xyaxes, const std::string& with) {
    bodies_ << "<geom type='plane' contype='0' conaffinity='0' size='" << half_x << ' ' << half_y << " 0.25' pos='" << p.x() << ' ' << p.y() << ' '
            << p.z() << "' xyaxes='" << xyaxes << "' material='" << with << "'/>";
  }

  void add_lights(const std::vector<scene::Light>& lights) {
    for (const scene::Light& light : lights)
      bodies_ << "<light pos='" << light.position.x() << ' ' << light.position.y() << ' ' << light.position.z() << "' dir='0 0 -1' diffuse='"
              << light.intensity << ' ' << light.intensity << ' ' << light.intensity
              << "' ambient='0 0 0' specular='0 0 0' cutoff='180' exponent='0' castshadow='false'/>";
  }

  void add_solid(const scene::Solid& solid) {
    const std::string with = material(solid.texture, solid.rgb, solid.shape == scene::Shape::mesh ? kObjectTiles : kSurfacePixels, 1);
    switch (solid.shape) {
      case scene::Shape::box: add_mesh(mesh::make_box(solid.size, kSolidPicturesPerMetre), solid.X_WS, with); break;
      case scene::Shape::cylinder:
        add_mesh(mesh::make_cylinder(solid.size.x(), solid.size.z(), kSolidPicturesPerMetre), solid.X_WS, with);
        break;
      case scene::Shape::sphere: add_mesh(mesh::make_sphere(solid.size.x(), kSolidPicturesPerMetre), solid.X_WS, with); break;
      case scene::Shape::mesh: {
        mesh::TriangleMesh shown = solid.mesh->mesh();
        mesh::compute_normals(shown);
        if (!solid.texture.starts_with("materials:") || shown.corner_uv.empty()) mesh::unwrap_six_tiles(shown, kSolidTileSlack * solid.size.maxCoeff());
        add_mesh(shown, solid.X_WS, with);
        break;
      }
    }
  }

  void add_landmark(const scene::Landmark& landmark) {
    // Each its own picture, by its name.
    const std::string seed = std::to_string(std::stoul(sha256_hex(landmark.name).substr(0, 6), nullptr, 16));
    const Pose X = make_pose(landmark.position, Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), landmark.normal).toRotationMatrix());
    add_mesh(mesh::make_box({landmark.size, landmark.size, kLandmarkThickness}, 1 / landmark.size), X,
             material("noise:" + seed, {1, 1, 1}, kSurfacePixels, 1));
  }

  void add_mesh(const mesh::TriangleMesh& mesh, const Pose& X, const std::string& with) {
    const std::string name = "mesh" + std::to_string(world_.meshes.size());
    const Eigen::Quaterniond q(X.linear());
    const Eigen::Vector3d& p = X.translation();
    world_.meshes.emplace_back(name + ".msh", mesh::to_msh(mesh));
    assets_ << "<mesh name='" << name << "' file='" << name << ".msh'/>";
    bodies_ << "<geom type='mesh' contype='0' conaffinity='0' mesh='" << name << "' pos='" << p.x() << ' ' << p.y() << ' ' << p.z() << "' quat='"
            << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << "' material='" << with << "'/>";
  }

  const RendererOptions& options_;
  World world_;
  std::ostringstream assets_, bodies_;
  std::map<std::string, std::string> textures_;
  int materials_ = 0;
};

}  // namespace

World build_world(const scene::Scene& scene, const std::vector<TrueObject>& objects, const RendererOptions& options) {
  return Builder(scene, objects, options).finish();
}

}  // namespace periplus::render

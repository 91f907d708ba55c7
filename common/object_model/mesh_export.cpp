#include <Eigen/Geometry>
#include <bit>
#include <charconv>
#include <cmath>

#include "common/core/error.h"
#include "common/object_model/model_export.h"

namespace periplus::object_model {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

template <class T>
void append_octets(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Neither the locale nor the number of digits matters: the shortest text that reads back as the same number.
template <class T>
std::string shortest(T value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string triple(const Eigen::Vector3f& v, char separator) {
  return shortest(v.x()) + separator + shortest(v.y()) + separator + shortest(v.z());
}

// IEC 61966-2-1.
std::uint16_t linear_from_srgb(std::uint8_t value) {
  const double s = value / 255.0;
  return static_cast<std::uint16_t>(std::lround(65535 * (s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4))));
}

Eigen::Vector3f y_up(const Eigen::Vector3f& v) { return {v.x(), v.z(), -v.y()}; }

void append_chunk(std::string& out, std::string data, const char* type, char filler) {
  data.resize((data.size() + 3) / 4 * 4, filler);
  append_octets(out, static_cast<std::uint32_t>(data.size()));
  out.append(type, 4);
  out += data;
}

}  // namespace

std::vector<Eigen::Vector3f> vertex_normals(const SurfaceMesh& mesh) {
  std::vector<Eigen::Vector3d> sums(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
    const Eigen::Vector3d twice_area = (mesh.vertices[t[1]].cast<double>() - a).cross(mesh.vertices[t[2]].cast<double>() - a);
    for (const std::uint32_t v : t) sums[v] += twice_area;
  }
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(sums.size());
  for (const Eigen::Vector3d& sum : sums)
    normals.push_back(sum.norm() > 1e-16 ? Eigen::Vector3f(sum.normalized().cast<float>()) : Eigen::Vector3f(0, 0, 1));
  return normals;
}

std::string to_obj(const SurfaceMesh& mesh) {
  std::string out = "# Periplus: metres, world frame, z up\n";
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f color(mesh.colors[i][0], mesh.colors[i][1], mesh.colors[i][2]);
    out += "v " + triple(mesh.vertices[i], ' ') + ' ' + triple(color / 255, ' ') + '\n';
  }
  for (const Eigen::Vector3f& n : vertex_normals(mesh)) out += "vn " + triple(n, ' ') + '\n';
  for (const auto& t : mesh.triangles) {
    out += 'f';
    for (const std::uint32_t v : t) {
      const std::string number = std::to_string(v + 1);
      out += ' ' + number + "//" + number;
    }
    out += '\n';
  }
  return out;
}

std::string to_glb(const SurfaceMesh& mesh) {
  const std::size_t vertices = mesh.vertices.size(), indices = mesh.triangles.size() * 3;
  std::string json = R"({"asset":{"version":"2.0","generator":"Periplus"},"scene":0,)", binary;
  if (indices == 0) {
    json += R"("scenes":[{}]})";
  } else {
    require(vertices < 0xffffffff / 64 && indices < 0xffffffff / 64, ErrorCode::bad_size, "the surface is too large for binary glTF; use larger voxels");
    Eigen::Vector3f least = y_up(mesh.vertices[0]), most = least;
    for (const Eigen::Vector3f& p : mesh.vertices) {
      const Eigen::Vector3f q = y_up(p);
      least = least.cwiseMin(q);
      most = most.cwiseMax(q);
      for (int n = 0; n < 3; ++n) append_octets(binary, q[n]);
    }
    for (const Eigen::Vector3f& normal : vertex_normals(mesh)) {
      const Eigen::Vector3f q = y_up(normal);
      for (int n = 0; n < 3; ++n) append_octets(binary, q[n]);
    }
    // Four of sixteen bits: dark tones survive being linear, and each vertex begins at a multiple of four bytes.
    for (const auto& rgb : mesh.colors) {
      for (const std::uint8_t c : rgb) append_octets(binary, linear_from_srgb(c));
      append_octets(binary, std::uint16_t{0xffff});
    }
    for (const auto& t : mesh.triangles)
      for (const std::uint32_t v : t) append_octets(binary, v);

    const std::string count = std::to_string(vertices);
    const auto view = [](std::size_t offset, std::size_t length, int target) {
      return R"({"buffer":0,"byteOffset":)" + std::to_string(offset) + R"(,"byteLength":)" + std::to_string(length) + R"(,"target":)" +
             std::to_string(target) + "}";
    };
    constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
    json += R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"object"}],)"
            R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"COLOR_0":2},"indices":3,"material":0}]}],)"
            R"("materials":[{"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":1}}],"accessors":[)";
    json += R"({"bufferView":0,"componentType":5126,"count":)" + count + R"(,"type":"VEC3","min":[)" + triple(least, ',') + R"(],"max":[)" +
            triple(most, ',') + "]},";
    json += R"({"bufferView":1,"componentType":5126,"count":)" + count + R"(,"type":"VEC3"},)";
    json += R"({"bufferView":2,"componentType":5123,"normalized":true,"count":)" + count + R"(,"type":"VEC4"},)";
    json += R"({"bufferView":3,"componentType":5125,"count":)" + std::to_string(indices) + R"(,"type":"SCALAR"}],)";
    json += R"("bufferViews":[)" + view(0, 12 * vertices, kArrayBuffer) + ',' + view(12 * vertices, 12 * vertices, kArrayBuffer) + ',' +
            view(24 * vertices, 8 * vertices, kArrayBuffer) + ',' + view(32 * vertices, 4 * indices, kElementArrayBuffer) + "],";
    json += R"("buffers":[{"byteLength":)" + std::to_string(binary.size()) + "}]}";
  }
  std::string chunks;
  append_chunk(chunks, json, "JSON", ' ');
  if (!binary.empty()) append_chunk(chunks, binary, "BIN\0", '\0');
  std::string out = "glTF";
  append_octets(out, std::uint32_t{2});
  append_octets(out, static_cast<std::uint32_t>(12 + chunks.size()));
  return out + chunks;
}

}  // namespace periplus::object_model

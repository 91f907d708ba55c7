// Reading by assimp; writing binary PLY and MuJoCo's .msh.
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string_view>
#include <tuple>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/geometry/ply.h"
#include "common/mesh/triangle_mesh.h"

namespace periplus::mesh {
namespace {

static_assert(std::endian::native == std::endian::little, "binary files are written as they lie in memory");

template <class T>
void append(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

// Assimp up to 5.4 drops the first byte of a binary PLY's data if it is a line's end, and reads nonsense from there on (assimp issue
// 5341). The bytes of such a file with the lowest bit of its first number turned, 1e-7 of its value; otherwise nothing.
std::string without_leading_newline(const std::string& path) {
  constexpr std::size_t kLongestHeader = 1 << 16;
  constexpr std::string_view kEnd = "end_header\n";
  std::ifstream file(path, std::ios::binary);
  std::string head(kLongestHeader, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  const std::size_t end = head.find(kEnd);
  if (!head.starts_with("ply") || end == std::string::npos || head.find("binary_little_endian") > end) return {};
  const std::size_t first = end + kEnd.size();
  if (first >= head.size() || head[first] != '\n') return {};
  std::string bytes = read_file(path);
  bytes[first] ^= 1;
  return bytes;
}

}  // namespace

TriangleMesh load(const std::string& path, const LoadLimits& limits) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  require(!error, ErrorCode::io, path + ": the mesh file cannot be read; deploy/fetch-assets.sh fetches those of the scenes");
  require(bytes <= limits.most_bytes, ErrorCode::bad_size,
          path + ": the mesh file is larger than " + std::to_string(limits.most_bytes >> 20) + " MiB");
  Assimp::Importer importer;
  constexpr unsigned kSteps = aiProcess_Triangulate | aiProcess_PreTransformVertices;
  const std::string mended = without_leading_newline(path);
  const aiScene* scene = mended.empty() ? importer.ReadFile(path, kSteps) : importer.ReadFileFromMemory(mended.data(), mended.size(), kSteps, "ply");
  require(scene != nullptr, ErrorCode::bad_input, path + ": not a mesh that can be read: " + importer.GetErrorString());

  TriangleMesh mesh;
  std::map<std::tuple<double, double, double>, int> known;
  bool textured = true, coloured = true;
  std::size_t triangles = 0;
  for (unsigned part = 0; part < scene->mNumMeshes; ++part) triangles += scene->mMeshes[part]->mNumFaces;
  require(triangles <= limits.most_triangles, ErrorCode::bad_size,
          path + ": more than " + std::to_string(limits.most_triangles) + " triangles; simplify the mesh");
  for (unsigned part = 0; part < scene->mNumMeshes; ++part) {
    const aiMesh& m = *scene->mMeshes[part];
    textured = textured && m.HasTextureCoords(0);
    coloured = coloured && m.HasVertexColors(0);
    std::vector<int> index(m.mNumVertices);
    for (unsigned i = 0; i < m.mNumVertices; ++i) {
      const Eigen::Vector3d p(m.mVertices[i].x, m.mVertices[i].y, m.mVertices[i].z);
      require(p.allFinite() && p.cwiseAbs().maxCoeff() < 1e12, ErrorCode::bad_input, path + ": a vertex is not a finite number");
      const auto [it, fresh] = known.try_emplace({p.x(), p.y(), p.z()}, static_cast<int>(mesh.vertices.size()));
      if (fresh) {
        mesh.vertices.push_back(p);
        if (coloured) mesh.colours.emplace_back(m.mColors[0][i].r, m.mColors[0][i].g, m.mColors[0][i].b);
      }
      index[i] = it->second;
    }
    for (unsigned i = 0; i < m.mNumFaces; ++i) {
      const aiFace& f = m.mFaces[i];
      if (f.mNumIndices != 3) continue;  // points and lines
      for (int k = 0; k < 3; ++k)
        require(f.mIndices[k] < m.mNumVertices, ErrorCode::bad_input, path + ": a triangle names a vertex that does not exist");
      const Eigen::Vector3i t(index[f.mIndices[0]], index[f.mIndices[1]], index[f.mIndices[2]]);
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
      mesh.triangles.push_back(t);
      if (!textured) continue;
      for (int k = 0; k < 3; ++k) {
        const aiVector3D& uv = m.mTextureCoords[0][f.mIndices[k]];
        mesh.corner_uv.emplace_back(uv.x, uv.y);
      }
    }
  }
  if (!textured) mesh.corner_uv.clear();
  if (!coloured) mesh.colours.clear();
  require(!mesh.triangles.empty(), ErrorCode::bad_input, path + ": the file holds no triangle");
  mesh.check();
  return mesh;
}

std::string to_ply(const TriangleMesh& mesh) {
  mesh.check();
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint8_t, 3>> colours;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const auto octet = [](double share) { return static_cast<std::uint8_t>(std::clamp(share, 0.0, 1.0) * 255 + 0.5); };
  for (const Eigen::Vector3d& p : mesh.vertices) vertices.push_back(p.cast<float>());
  for (const Eigen::Vector3d& c : mesh.colours) colours.push_back({octet(c.x()), octet(c.y()), octet(c.z())});
  for (const Eigen::Vector3i& t : mesh.triangles)
    triangles.push_back({static_cast<std::uint32_t>(t.x()), static_cast<std::uint32_t>(t.y()), static_cast<std::uint32_t>(t.z())});
  return encode_ply(vertices, colours, triangles);
}

void write_ply(const TriangleMesh& mesh, const std::string& path) {
  const std::string bytes = to_ply(mesh);
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  require(!file.fail(), ErrorCode::io, path + ": the mesh could not be written; is the folder there and not full?");
}

std::string to_msh(const TriangleMesh& mesh) {
  mesh.check();
  const TriangleMesh* source = &mesh;
  TriangleMesh with_normals;
  if (mesh.corner_normals.empty()) {
    with_normals = mesh;
    compute_normals(with_normals);
    source = &with_normals;
  }
  const auto corners = static_cast<std::int32_t>(3 * mesh.triangles.size());
  std::string out;
  append(out, corners);
  append(out, corners);
  append(out, mesh.corner_uv.empty() ? std::int32_t{0} : corners);
  append(out, corners / 3);
  for (const Eigen::Vector3i& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < 3; ++c) append(out, static_cast<float>(mesh.vertices[static_cast<std::size_t>(t[k])][c]));
  for (const Eigen::Vector3d& n : source->corner_normals)
    for (int c = 0; c < 3; ++c) append(out, static_cast<float>(n[c]));
  for (const Eigen::Vector2d& uv : mesh.corner_uv) {
    append(out, static_cast<float>(uv.x()));
    append(out, static_cast<float>(1 - uv.y()));  // pictures are stored top row first
  }
  for (std::int32_t i = 0; i < corners; ++i) append(out, i);
  return out;
}

}  // namespace periplus::mesh

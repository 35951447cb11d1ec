// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_io.h"

#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <set>
#include <sstream>
#include <unordered_map>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/isolation/read_in_child.h"

namespace reamsim {

namespace {

[[noreturn]] void fail(const std::string& path, const std::string& found, const std::string& expected) {
  throw InputError({path, 0, 0}, "", found, expected);
}

/// Keeps only the reader of `extension`, so that assimp does not try others.
void keep_only_reader(Assimp::Importer& importer, const std::string& extension) {
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    Assimp::BaseImporter* reader = importer.GetImporter(i);
    std::set<std::string> extensions;
    reader->GetExtensionList(extensions);
    if (extensions.count(extension) == 0) {
      importer.UnregisterLoader(reader);
      delete reader;  // unregistering passes ownership
    }
  }
}

/// assimp's own checks do not find faces without vertices, and its triangulation crashes on them.
void check_faces(const aiScene& scene, const std::string& path) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices == 0 || face.mIndices == nullptr) {
        fail(path, "face " + std::to_string(f + 1) + " has no vertices", "give a complete mesh");
      }
      for (unsigned c = 0; c < face.mNumIndices; ++c) {
        if (face.mIndices[c] >= part.mNumVertices) {
          fail(path, "face " + std::to_string(f + 1) + " refers to a missing vertex", "give a complete mesh");
        }
      }
    }
  }
}

struct PositionHash {
  std::size_t operator()(const std::array<float, 3>& p) const {
    std::uint64_t hash = 1469598103934665603ULL;
    for (const float v : p) hash = (hash ^ std::bit_cast<std::uint32_t>(v)) * 1099511628211ULL;
    return static_cast<std::size_t>(hash ^ (hash >> 29));
  }
};

/// Collects triangles and merges vertices at equal positions.
class MeshBuilder {
 public:
  MeshBuilder(const std::string& path, double scale) : path_(path), scale_(scale) {}

  void add(const aiMesh& part) {
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;  // a point or line
      std::array<std::int32_t, 3> triangle{};
      for (std::size_t c = 0; c < 3; ++c) {
        const unsigned index = face.mIndices[c];
        if (index >= part.mNumVertices) fail(path_, "a triangle refers to a missing vertex", "give a complete mesh");
        triangle[c] = vertex(part.mVertices[index]);
      }
      mesh_.triangles.push_back(triangle);
    }
  }

  TriangleMesh take() { return std::move(mesh_); }

 private:
  std::int32_t vertex(const aiVector3D& v) {
    if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
      fail(path_, "a NaN or infinite coordinate in triangle " + std::to_string(mesh_.triangles.size() + 1),
           "expected finite numbers");
    }
    const std::array<float, 3> key{v.x + 0.0F, v.y + 0.0F, v.z + 0.0F};  // −0 becomes 0
    const auto [found, is_new] = vertex_of_.try_emplace(key, static_cast<std::int32_t>(mesh_.vertices.size()));
    if (is_new) mesh_.vertices.push_back(scale_ * Vec3(key[0], key[1], key[2]));
    return found->second;
  }

  std::string path_;
  double scale_;
  TriangleMesh mesh_;
  std::unordered_map<std::array<float, 3>, std::int32_t, PositionHash> vertex_of_;
};

/// Reads with assimp. Throws InputError.
TriangleMesh read_with_assimp(const std::string& path, const std::string& extension, double scale) {
  MeshBuilder builder(path, scale);
  Assimp::Importer importer;
  keep_only_reader(importer, extension);
  // Triangulation trusts the faces, so they are checked first; it comes only then.
  const aiScene* scene = importer.ReadFile(path, 0);
  if (scene != nullptr) check_faces(*scene, path);
  if (scene != nullptr) scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) {
    fail(path, "not a readable " + extension + " mesh (truncated or damaged)", "expected a surface");
  }
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) builder.add(*scene->mMeshes[i]);
  return builder.take();
}

void put_mesh(ResultWriter& out, const TriangleMesh& mesh) {
  auto* coordinate = out.array<double>(3 * mesh.vertices.size());
  for (const Vec3& vertex : mesh.vertices) coordinate = std::copy_n(vertex.data(), 3, coordinate);
  auto* corner = out.array<std::int32_t>(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) corner = std::copy_n(triangle.data(), 3, corner);
}

TriangleMesh take_mesh(ResultReader& in) {
  TriangleMesh mesh;
  const auto coordinate = in.array<double>();
  const auto corner = in.array<std::int32_t>();
  if (coordinate.size() % 3 != 0 || corner.size() % 3 != 0) in.fail();
  mesh.vertices.reserve(coordinate.size() / 3);
  for (std::size_t i = 0; i < coordinate.size(); i += 3) {
    mesh.vertices.emplace_back(coordinate[i], coordinate[i + 1], coordinate[i + 2]);
    if (!mesh.vertices.back().allFinite()) in.fail();
  }
  mesh.triangles.reserve(corner.size() / 3);
  for (std::size_t i = 0; i < corner.size(); i += 3) {
    mesh.triangles.push_back({corner[i], corner[i + 1], corner[i + 2]});
    for (const std::int32_t vertex : mesh.triangles.back()) {
      if (vertex < 0 || static_cast<std::size_t>(vertex) >= mesh.vertices.size()) in.fail();
    }
  }
  return mesh;
}

void read_and_put(ResultWriter& out, const std::string& path, const std::string& extension, double scale) {
  put_mesh(out, read_with_assimp(path, extension, scale));
}

/// What assimp may need: its own arrays for each number in a text file.
ReadLimits limits_for(std::uintmax_t file_bytes) {
  constexpr std::uint64_t kMemoryPerFileByte = 48;
  ReadLimits limits = ReadLimits().with(file_bytes, kMemoryPerFileByte * file_bytes);
  limits.result_bytes += 16 * file_bytes;
  return limits;
}

void append_point(std::string& out, const Vec3& p) {
  const Eigen::Vector3f narrow = p.cast<float>();
  out.append(reinterpret_cast<const char*>(narrow.data()), 3 * sizeof(float));
}

}  // namespace

TriangleMesh read_mesh(const std::string& path, double scale) {
  if (!std::isfinite(scale) || scale <= 0) fail(path, "a scale of " + std::to_string(scale), "expected more than 0");
  const MeshFile file = check_mesh_file(path);
  ChildResult result = read_in_child<read_and_put>({path, ""}, limits_for(file.bytes), path, file.extension, scale);
  TriangleMesh mesh = take_mesh(result.reader());
  if (mesh.triangles.empty()) fail(path, "a mesh of 0 triangles", "expected a surface");
  return mesh;
}

void write_stl(const std::string& path, const TriangleMesh& mesh, const std::string& space) {
  std::string bytes = "reamsim, mm";  // not "solid", which marks an ASCII STL
  if (!space.empty()) bytes += ", SPACE=" + space;
  bytes.resize(kStlHeaderBytes - 4, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
  bytes.reserve(kStlHeaderBytes + kStlTriangleBytes * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    const auto corners = mesh.corners(triangle);
    append_point(bytes, (corners[1] - corners[0]).cross(corners[2] - corners[0]).stableNormalized());
    for (const Vec3& corner : corners) append_point(bytes, corner);
    bytes.append(2, '\0');
  }
  write_file(path, bytes);
}

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{2} << 30;

[[noreturn]] void refuse(const std::string& path, const std::string& found, const std::string& expected) {
  throw InputError({path, 0, 0}, "", found, expected);
}

[[noreturn]] void refuse_vtk(const std::string& path) {
  refuse(path, "a VTK file",
         "save its surface as STL or PLY: in ParaView with File > Save Data, or in Python with PyVista: "
         "pyvista.read(\"bone.vtp\").extract_surface().triangulate().save(\"bone.stl\")");
}

/// "stl", "obj" or "ply".
std::string checked_extension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const std::set<std::string> vtk{".vtk", ".vtp", ".vtu", ".vts", ".vtr", ".vti", ".vtm", ".pvtp", ".pvtu"};
  if (vtk.contains(extension) && fs::is_regular_file(path)) refuse_vtk(path);
  if (extension != ".stl" && extension != ".obj" && extension != ".ply") {
    refuse(path, "the extension \"" + extension + "\"", "expected a mesh in .stl, .obj or .ply");
  }
  return extension.substr(1);
}

std::uintmax_t checked_size(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const std::string reason = unreachable_reason(path);
  if (!reason.empty()) refuse(path, "cannot be read (" + reason + ")", "expected a readable mesh file");
  if (!fs::exists(status)) refuse(path, "no such file", "expected a mesh in .stl, .obj or .ply");
  if (fs::is_directory(status)) refuse(path, "a folder", "expected a mesh in .stl, .obj or .ply");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || !std::ifstream(path).good()) refuse(path, "cannot be read", "expected a readable mesh file");
  if (size == 0) refuse(path, "an empty file", "expected a mesh in .stl, .obj or .ply");
  if (size > kMaxFileBytes) refuse(path, "a file of more than 2 GiB", "expected a mesh of at most 2 GiB");
  return size;
}

/// Detects VTK's legacy and XML formats by the content of the file.
void check_is_not_vtk(const std::string& path) {
  const std::string start = read_file_start(path, 256);
  if (start.starts_with("# vtk DataFile") || start.find("<VTKFile") != std::string::npos) refuse_vtk(path);
}

/// Binary unless it begins like an ASCII STL ("solid ... facet").
bool stl_is_binary(const std::string& start) {
  const std::size_t first = start.find_first_not_of(" \t\r\n");
  if (first == std::string::npos || start.compare(first, 5, "solid") != 0) return true;
  return start.find("facet") == std::string::npos && start.find("endsolid") == std::string::npos;
}

/// Checks the number of triangles in the header of a binary STL, which assimp trusts.
void check_stl(const std::string& path, std::uintmax_t size) {
  const std::string start = read_file_start(path, 1024);
  if (!stl_is_binary(start)) return;
  if (size < kStlHeaderBytes)
    refuse(path, "a truncated STL of " + std::to_string(size) + " bytes", "expected 84 or more");
  std::uint32_t count = 0;
  std::memcpy(&count, start.data() + 80, sizeof count);
  const std::uintmax_t needed = kStlHeaderBytes + std::uintmax_t{kStlTriangleBytes} * count;
  if (count == 0) refuse(path, "an STL of 0 triangles", "expected a surface");
  if (size < needed) {
    refuse(path,
           "a truncated STL: its header claims " + std::to_string(count) + " triangles, the file holds " +
               std::to_string((size - kStlHeaderBytes) / kStlTriangleBytes),
           "expected " + std::to_string(needed) + " bytes");
  }
}

/// Checks the counts in a PLY header, for which assimp reserves memory.
void check_ply(const std::string& path, std::uintmax_t size) {
  std::istringstream header(read_file_start(path, std::size_t{64} * 1024));
  std::string line;
  bool ended = false;
  std::getline(header, line);
  if (line.rfind("ply", 0) != 0) refuse(path, "no PLY header", "expected a file that begins with \"ply\"");
  while (!ended && std::getline(header, line)) {
    std::istringstream words(line);
    std::string keyword;
    std::string name;
    words >> keyword;
    ended = keyword == "end_header";
    if (keyword != "element") continue;
    std::uintmax_t count = 0;
    if (!(words >> name >> count) || count > size) {
      refuse(path, "a truncated PLY: its header claims more elements \"" + name + "\" than the file can hold",
             "expected a complete PLY file");
    }
  }
  if (header.bad()) throw std::bad_alloc();  // std::getline() swallows it
  if (!ended) refuse(path, "a PLY header without \"end_header\"", "expected a complete PLY file");
}

}  // namespace

void require_mesh_name(const std::string& path, const std::string& key) {
  try {
    checked_extension(path);
  } catch (const InputError& error) {
    throw InputError({}, key, error.what(), "");
  }
}

MeshFile check_mesh_file(const std::string& path) {
  const std::string extension = checked_extension(path);
  const std::uintmax_t size = checked_size(path);
  check_is_not_vtk(path);
  if (extension == "stl") check_stl(path, size);
  if (extension == "ply") check_ply(path, size);
  return {.extension = extension, .bytes = size};
}

}  // namespace reamsim

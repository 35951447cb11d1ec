// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_io.h"

#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/core.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <boost/functional/hash.hpp>
#include <cmath>
#include <set>
#include <span>
#include <unordered_map>

#include "sim/base/file.h"
#include "sim/isolation/read_in_child.h"
#include "sim/mesh/mesh_check.h"

namespace reamsim {

namespace {

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
  for (const aiMesh* part : std::span(scene.mMeshes, scene.mNumMeshes)) {
    for (unsigned f = 0; f < part->mNumFaces; ++f) {
      const aiFace& face = part->mFaces[f];
      const auto is_missing = [part](unsigned vertex) { return vertex >= part->mNumVertices; };
      const bool empty = face.mNumIndices == 0 || face.mIndices == nullptr;
      if (!empty && std::ranges::none_of(std::span(face.mIndices, face.mNumIndices), is_missing)) continue;
      refuse_file(path, fmt::format("face {} {}", f + 1, empty ? "has no vertices" : "refers to a missing vertex"),
                  "give a complete mesh");
    }
  }
}

class MeshBuilder {
 public:
  MeshBuilder(const std::string& path, double scale) : path_(path), scale_(scale) {}

  void add(const std::array<StlCorner, 3>& corners) {
    mesh_.triangles.push_back({vertex(corners[0]), vertex(corners[1]), vertex(corners[2])});
  }

  TriangleMesh take() { return std::move(mesh_); }

 private:
  std::int32_t vertex(const StlCorner& v) {
    if (!std::ranges::all_of(v, [](float value) { return std::isfinite(value); })) {
      refuse_file(path_, "a NaN or infinite coordinate in triangle " + std::to_string(mesh_.triangles.size() + 1),
                  "expected finite numbers");
    }
    const StlCorner key{v[0] + 0.0F, v[1] + 0.0F, v[2] + 0.0F};  // −0 becomes 0
    const auto [found, is_new] = vertex_of_.try_emplace(key, static_cast<std::int32_t>(mesh_.vertices.size()));
    if (is_new) mesh_.vertices.push_back(scale_ * Vec3(key[0], key[1], key[2]));
    return found->second;
  }

  std::string path_;
  double scale_;
  TriangleMesh mesh_;
  std::unordered_map<StlCorner, std::int32_t, boost::hash<StlCorner>> vertex_of_;
};

/// Reads an OBJ or PLY with assimp. Throws InputError.
void read_with_assimp(const std::string& path, const std::string& bytes, const std::string& extension,
                      const StlSink& sink) {
  Assimp::Importer importer;
  keep_only_reader(importer, extension);
  // Triangulation trusts the faces, so they are checked first; it comes only then.
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, extension.c_str());
  if (scene != nullptr) check_faces(*scene, path);
  if (scene != nullptr) scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) {
    refuse_file(path, "not a readable " + extension + " mesh (truncated or damaged)", "expected a surface");
  }
  for (const aiMesh* part : std::span(scene->mMeshes, scene->mNumMeshes)) {
    const auto corner = [part](unsigned index) {
      const aiVector3D& v = part->mVertices[index];
      return StlCorner{v.x, v.y, v.z};
    };
    for (const aiFace& face : std::span(part->mFaces, part->mNumFaces)) {
      if (face.mNumIndices != 3) continue;  // a point or line
      sink({corner(face.mIndices[0]), corner(face.mIndices[1]), corner(face.mIndices[2])});
    }
  }
}

using Coordinates = std::array<double, 3>;

void put_mesh(ResultWriter& out, const TriangleMesh& mesh) {
  std::ranges::transform(mesh.vertices, out.array<Coordinates>(mesh.vertices.size()), [](const Vec3& v) {
    return Coordinates{v.x(), v.y(), v.z()};
  });
  out.put(mesh.triangles);
}

TriangleMesh take_mesh(ResultReader& in) {
  TriangleMesh mesh;
  in.for_each_in_array<Coordinates>([&](const Coordinates& c) {
    mesh.vertices.emplace_back(c[0], c[1], c[2]);
    if (!mesh.vertices.back().allFinite()) in.fail();
  });
  mesh.triangles = in.take<std::vector<MeshTriangle>>();
  for (const MeshTriangle& triangle : mesh.triangles) {
    for (const std::int32_t vertex : triangle) {
      if (vertex < 0 || static_cast<std::size_t>(vertex) >= mesh.vertices.size()) in.fail();
    }
  }
  return mesh;
}

void read_and_put(ResultWriter& out, const std::string& path, MeshFormat format, double scale) {
  std::string bytes = read_file(path, "a mesh");
  if (bytes.size() < kStlHeaderBytes && format == MeshFormat::stl_binary)
    refuse_file(path, "a truncated STL", "expected more");
  MeshBuilder builder(path, scale);
  const StlSink sink = [&builder](const std::array<StlCorner, 3>& corners) { builder.add(corners); };
  std::vector<std::string> warnings;
  if (format == MeshFormat::stl_binary) {
    warnings = read_binary_stl(bytes, sink);
  } else if (format == MeshFormat::stl_ascii) {
    warnings = read_ascii_stl(path, bytes, sink);
  } else if (format == MeshFormat::vtp) {
    bytes = read_vtp(path, bytes, sink);
  } else {
    read_with_assimp(path, bytes, format == MeshFormat::obj ? "obj" : "ply", sink);
  }
  put_mesh(out, builder.take());
  out.put(warnings);
  out.put(stated_space(std::string_view(bytes).substr(0, kMeshHeaderBytes), format));
}

void append_point(std::string& out, const Vec3& p) {
  const Eigen::Vector3f narrow = p.cast<float>();
  out.append(reinterpret_cast<const char*>(narrow.data()), 3 * sizeof(float));
}

}  // namespace

MeshContents read_mesh_contents(const std::string& path, double scale, const std::string& key) {
  if (!std::isfinite(scale) || scale <= 0)
    refuse_file(path, "a scale of " + std::to_string(scale), "expected more than 0");
  MeshFormat format{};
  try {
    format = check_mesh_file(path);
  } catch (const InputError& error) {
    if (key.empty()) throw;
    throw InputError({}, key, error.what(), "");
  }
  constexpr std::uint64_t kMemoryPerFileByte = 48;  // assimp's own arrays for each number in a text file
  const std::uintmax_t file_bytes = bytes_of_file(path);
  ReadLimits limits = ReadLimits().with(file_bytes, kMemoryPerFileByte * file_bytes);
  limits.result_bytes += 16 * file_bytes;
  ResultReader result = read_in_child<read_and_put>({path, ""}, limits, path, format, scale);
  MeshContents out;
  out.mesh = take_mesh(result);
  out.report.warnings = result.texts();
  out.space = result.text();
  if (out.mesh.triangles.empty()) refuse_file(path, "a mesh of 0 triangles", "expected a surface");
  const std::string welded = weld(out.mesh);
  if (!welded.empty()) out.report.note(welded);
  return out;
}

TriangleMesh read_mesh(const std::string& path, double scale) {
  return read_mesh_contents(path, scale).mesh;
}

TriangleMesh read_closed_part(const PartFile& file, Diagnostics& report) {
  constexpr double kLargest_mm = 1000;
  MeshContents contents = read_mesh_contents(file.path, file.scale, file.key);
  report.append(contents.report, file.key + ": ");
  if (!contents.space.empty()) {
    report.note(
        fmt::format("{}: the header says SPACE={}; the coordinates of a {} are taken as they stand, in its frame",
                    file.key, contents.space, file.part));
  }
  TriangleMesh mesh = std::move(contents.mesh);
  const MeshDiagnosis diagnosis = diagnose(mesh);
  if (!diagnosis.closed_manifold()) throw file.error(diagnosis.text(), "give a closed two-manifold surface");
  const Vec3 size = mesh.bounds().max - mesh.bounds().min;
  if (!(size.minCoeff() > file.least_mm) || !(size.maxCoeff() < kLargest_mm) || !(std::abs(diagnosis.volume_mm3) > 0)) {
    throw file.error(
        fmt::format("the {} measures {:.4g} × {:.4g} × {:.4g} mm", file.part, size.x(), size.y(), size.z()),
        fmt::format("more than {:.4g} mm and less than 1 m are supported: check {}", file.least_mm, file.scale_key));
  }
  if (diagnosis.volume_mm3 < 0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    report.warn(file.key + ": the triangles of " + file.path + " face inwards; orientation flipped");
  }
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

}  // namespace reamsim

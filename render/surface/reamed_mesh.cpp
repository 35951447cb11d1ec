// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/bone_surface.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "render/surface/scalar_grid.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/bone/vdb/grids.h"

namespace reamsim {
namespace {

constexpr int kMeshSmoothingRounds = 5;
constexpr int kNewtonSteps = 2;  // of the level; the second matters for thin bone, whose area changes with the level
constexpr double kMaxShift_voxels = 0.5;

TriangleMesh mesh_at(const openvdb::FloatGrid& surface, double level_mm) {
  const IsoSurface iso = extract_surface(surface, level_mm);
  TriangleMesh mesh;
  for (const Eigen::Vector3f& p : iso.points) mesh.vertices.emplace_back(p.cast<double>());
  // OpenVDB orients the triangles of a level set inwards.
  const auto corner = [&](std::size_t i) { return static_cast<std::int32_t>(iso.indices[i]); };
  for (std::size_t i = 0; i < iso.indices.size(); i += 3) {
    mesh.triangles.push_back({corner(i), corner(i + 2), corner(i + 1)});
  }
  return mesh;
}

/// The mesh by mesh_at(level) that encloses `volume_mm3`, by Newton's method: dV/dlevel is the surface area, nearly.
template <class MeshAt>
TriangleMesh mesh_of_volume(const MeshAt& mesh_at, double volume_mm3, double voxel_mm) {
  double level_mm = 0;
  TriangleMesh mesh = mesh_at(level_mm);
  for (int i = 0; i < kNewtonSteps && !mesh.triangles.empty(); ++i) {
    const double max_mm = kMaxShift_voxels * voxel_mm;
    level_mm = std::clamp(level_mm + (volume_mm3 - mesh.volume_mm3()) / mesh.area_mm2(), -max_mm, max_mm);
    mesh = mesh_at(level_mm);
  }
  return mesh;
}

/// Area-weighted means of the triangle normals at each vertex.
std::vector<Eigen::Vector3f> vertex_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> sums(mesh.vertices.size(), Vec3::Zero());
  for (const auto& triangle : mesh.triangles) {
    const auto [a, b, c] = mesh.corners(triangle);
    const Vec3 normal = (b - a).cross(c - a);
    for (const std::int32_t corner : triangle) sums[static_cast<std::size_t>(corner)] += normal;
  }
  std::vector<Eigen::Vector3f> out;
  out.reserve(sums.size());
  for (const Vec3& sum : sums) out.emplace_back((sum.norm() > 0 ? sum.normalized() : Vec3::UnitZ()).cast<float>());
  return out;
}

void add_reaming(ReamedMesh& out, const VoxelGrid& grid, const UnreamedSurface& unreamed) {
  const auto voxel = [&](std::size_t i) {
    return vdb_point(Vec3((out.mesh.vertices[i] - grid.origin_mm) / grid.voxel_mm - Vec3::Constant(0.5)));
  };
  // Without the field of the current bone the certainty stands for the edge as well.
  const auto removal_at = [&](const ReamingSampler& sampler, std::size_t i) {
    const float certainty = sampler.fraction(voxel(i));
    return Removal{certainty, certainty};
  };
  Reaming reaming = reaming_at(out.mesh.vertices.size(), unreamed, unreamed.field.grid(), removal_at,
                               [&](std::size_t i) { return voxel(i) * grid.voxel_mm; });
  std::vector<Eigen::Vector3f> points;
  for (const Vec3& p : out.mesh.vertices) points.emplace_back(((p - grid.origin_mm) / grid.voxel_mm).cast<float>());
  std::vector<std::uint32_t> corners;
  for (const auto& triangle : out.mesh.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
  reaming.smooth({points.size(), corners}, points, kMeshSmoothingRounds, kMeshSmoothingRounds);
  out.depth_mm = std::move(reaming.depth_mm);
  out.reamed = std::move(reaming.reamed);
}

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;  // glTF, JSON, BIN
constexpr int kFloat = 5126, kUnsignedShort = 5123, kUnsignedInt = 5125;
constexpr int kVertices = 34962, kIndices = 34963;

/// Colour of bone that was not reamed, linear.
const Eigen::Vector3f kBoneColor(0.72F, 0.60F, 0.45F);

/// glTF's vertex colours are linear.
Eigen::Vector3f color_of(float depth_mm, float reamed, const ColorMap& map, double depth_max_mm) {
  const auto linear = [](float c) { return c <= 0.04045F ? c / 12.92F : std::pow((c + 0.055F) / 1.055F, 2.4F); };
  const Eigen::Vector3f depth = map.at(depth_mm / depth_max_mm).unaryExpr(linear);
  // The same smoothstep as in the shader of the pictures.
  const float t = std::clamp((reamed - 0.35F) / 0.3F, 0.0F, 1.0F);
  const float fraction = t * t * (3 - 2 * t);
  return (1 - fraction) * kBoneColor + fraction * depth;
}

/// The binary chunk with its views and accessors.
struct Buffer {
  std::vector<char> data;
  Json views = Json::array();
  Json accessors = Json::array();

  /// Appends values as one view with one accessor of `count` elements; returns the accessor's index.
  template <class Value>
  std::size_t add(const std::vector<Value>& values, int target, int component, std::size_t count, const char* type,
                  const Json& more = Json::object()) {
    const std::size_t bytes = values.size() * sizeof(Value);
    views.push_back({{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", bytes}, {"target", target}});
    const auto* begin = reinterpret_cast<const char*>(values.data());
    data.insert(data.end(), begin, begin + bytes);
    data.resize((data.size() + 3) / 4 * 4);
    accessors.push_back({{"bufferView", views.size() - 1},
                         {"byteOffset", 0},
                         {"componentType", component},
                         {"count", count},
                         {"type", type}});
    accessors.back().update(more);
    return accessors.size() - 1;
  }
};

std::size_t add_positions(Buffer& buffer, const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> positions;
  Eigen::AlignedBox3f box;
  for (const Vec3& v : mesh.vertices) box.extend(positions.emplace_back(v.cast<float>()));
  const auto json = [](const Eigen::Vector3f& p) { return Json{p.x(), p.y(), p.z()}; };
  const Json bounds{{"min", json(box.min())}, {"max", json(box.max())}};
  return buffer.add(positions, kVertices, kFloat, positions.size(), "VEC3", bounds);
}

std::size_t add_colors(Buffer& buffer, const ReamedMesh& reamed, double depth_max_mm) {
  using VertexColor = std::array<std::uint16_t, 4>;  // the fourth, opacity, keeps the rows at multiples of four bytes
  const ColorMap map = depth_colors();
  std::vector<VertexColor> colors;
  for (std::size_t i = 0; i < reamed.depth_mm.size(); ++i) {
    const Eigen::Vector3f c = color_of(reamed.depth_mm[i], reamed.reamed[i], map, depth_max_mm);
    const auto level = [](float x) {
      return static_cast<std::uint16_t>(std::lround(65535 * std::clamp(x, 0.0F, 1.0F)));
    };
    colors.push_back({level(c.x()), level(c.y()), level(c.z()), 65535});
  }
  return buffer.add(colors, kVertices, kUnsignedShort, colors.size(), "VEC4", {{"normalized", true}});
}

Json list_of(const Json& item) {
  return Json::array({item});
}

Json document(const Buffer& buffer, const Json& attributes, std::size_t indices, double depth_max_mm) {
  Json out;
  out["asset"] = {{"version", "2.0"},
                  {"generator", "reamsim " REAMSIM_VERSION},
                  {"extras", {{"length_unit", "mm"}, {"depth_color_max_mm", depth_max_mm}}}};
  out["scene"] = 0;
  out["scenes"] = list_of({{"nodes", Json::array({0})}});
  const double half = std::sqrt(0.5);
  out["nodes"] = list_of({{"name", "reamed bone"}, {"mesh", 0}, {"rotation", {-half, 0, 0, half}}});
  const Json triangles = {{"attributes", attributes}, {"indices", indices}, {"material", 0}, {"mode", 4}};
  out["meshes"] = list_of({{"name", "reamed bone"}, {"primitives", list_of(triangles)}});
  out["materials"] =
      list_of({{"name", "bone"}, {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.6}}}});
  out["buffers"] = list_of({{"byteLength", buffer.data.size()}});
  out["bufferViews"] = buffer.views;
  out["accessors"] = buffer.accessors;
  return out;
}

void write_chunks(const std::string& path, const std::string& json, const std::vector<char>& binary) {
  constexpr std::size_t kHeads = 12 + 8 + 8;
  const std::size_t total = kHeads + json.size() + binary.size();
  if (total > UINT32_MAX) {
    throw RunError(path + ": the mesh exceeds the 4 GiB limit of GLB: set output.meshes: false, or use larger voxels");
  }
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  const auto put = [&](std::initializer_list<std::size_t> words, const auto& bytes) {
    for (const std::size_t word : words) {
      const auto narrow = static_cast<std::uint32_t>(word);
      out.write(reinterpret_cast<const char*>(&narrow), sizeof narrow);
    }
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  };
  put({kMagic, 2, total, json.size(), kJsonChunk}, json);
  put({binary.size(), kBinaryChunk}, binary);
  close_file(out, path);
}

}  // namespace

ReamedMesh make_reamed_mesh(const std::string& path, const BoneView& bone, const UnreamedSurface& unreamed,
                            bool whole_voxels) {
  const VoxelGrid& grid = bone.voxmap.grid;
  ReamedMesh out;
  const auto surface = read_vdb_grid(path, "surface");
  const auto sharp_mesh_at = [&](double level_mm) {
    TriangleMesh mesh = mesh_at(*surface, level_mm);
    if (!whole_voxels) sharpen_edges(mesh, bone, unreamed);
    return mesh;
  };
  out.mesh = mesh_of_volume(sharp_mesh_at, bone.bone_mm3(), grid.voxel_mm);
  out.normals = vertex_normals(out.mesh);
  add_reaming(out, grid, unreamed);
  return out;
}

void write_glb(const std::string& path, const ReamedMesh& reamed, double depth_max_mm) {
  Buffer buffer;
  Json attributes;
  attributes["POSITION"] = add_positions(buffer, reamed.mesh);
  attributes["NORMAL"] = buffer.add(reamed.normals, kVertices, kFloat, reamed.normals.size(), "VEC3");
  attributes["COLOR_0"] = add_colors(buffer, reamed, depth_max_mm);
  attributes["_DEPTH_MM"] = buffer.add(reamed.depth_mm, kVertices, kFloat, reamed.depth_mm.size(), "SCALAR");
  const std::size_t indices =
      buffer.add(reamed.mesh.triangles, kIndices, kUnsignedInt, 3 * reamed.mesh.triangles.size(), "SCALAR");
  std::string json = document(buffer, attributes, indices, depth_max_mm).dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  write_chunks(path, json, buffer.data);
}

}  // namespace reamsim

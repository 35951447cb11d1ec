// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/reamed_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "render/surface/color_map.h"
#include "sim/base/error.h"
#include "sim/base/file.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsignedShort = 5123, kUnsignedInt = 5125;
constexpr int kVertices = 34962, kIndices = 34963;

/// Colour of bone that was not reamed, linear.
const Eigen::Vector3f kBoneColor(0.72F, 0.60F, 0.45F);

float linear_from_srgb(float c) {
  return c <= 0.04045F ? c / 12.92F : std::pow((c + 0.055F) / 1.055F, 2.4F);
}

/// glTF's vertex colours are linear.
Eigen::Vector3f color_of(float depth_mm, float reamed, const ColorMap& map, double depth_max_mm) {
  const Eigen::Vector3f depth = map.at(depth_mm / depth_max_mm).unaryExpr(&linear_from_srgb);
  // The same smoothstep as in the shader of the pictures.
  const float t = std::clamp((reamed - 0.35F) / 0.3F, 0.0F, 1.0F);
  const float fraction = t * t * (3 - 2 * t);
  return (1 - fraction) * kBoneColor + fraction * depth;
}

/// The binary chunk with its views and accessors.
class Buffer {
 public:
  /// Appends values as one view with one accessor of `count` elements; returns the accessor's index.
  template <class Value>
  std::size_t add(const std::vector<Value>& values, int target, int component, std::size_t count, const char* type,
                  const Json& more = Json::object()) {
    const std::size_t bytes = values.size() * sizeof(Value);
    views_.push_back({{"buffer", 0}, {"byteOffset", data_.size()}, {"byteLength", bytes}, {"target", target}});
    const auto* begin = reinterpret_cast<const char*>(values.data());
    data_.insert(data_.end(), begin, begin + bytes);
    data_.resize((data_.size() + 3) / 4 * 4);
    accessors_.push_back({{"bufferView", views_.size() - 1},
                          {"byteOffset", 0},
                          {"componentType", component},
                          {"count", count},
                          {"type", type}});
    accessors_.back().update(more);
    return accessors_.size() - 1;
  }

  [[nodiscard]] const std::vector<char>& data() const { return data_; }
  [[nodiscard]] const Json& views() const { return views_; }
  [[nodiscard]] const Json& accessors() const { return accessors_; }

 private:
  std::vector<char> data_;
  Json views_ = Json::array();
  Json accessors_ = Json::array();
};

std::size_t add_positions(Buffer& buffer, const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(mesh.vertices.size());
  Eigen::Vector3f low = mesh.vertices.front().cast<float>();
  Eigen::Vector3f high = low;
  for (const Vec3& v : mesh.vertices) {
    positions.emplace_back(v.cast<float>());
    low = low.cwiseMin(positions.back());
    high = high.cwiseMax(positions.back());
  }
  const Json bounds{{"min", {low.x(), low.y(), low.z()}}, {"max", {high.x(), high.y(), high.z()}}};
  return buffer.add(positions, kVertices, kFloat, positions.size(), "VEC3", bounds);
}

std::size_t add_colors(Buffer& buffer, const ReamedMesh& reamed, double depth_max_mm) {
  using VertexColor = std::array<std::uint16_t, 4>;  // the fourth, opacity, keeps the rows at multiples of four bytes
  const ColorMap map = depth_colors();
  std::vector<VertexColor> colors;
  colors.reserve(reamed.depth_mm.size());
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
  out["buffers"] = list_of({{"byteLength", buffer.data().size()}});
  out["bufferViews"] = buffer.views();
  out["accessors"] = buffer.accessors();
  return out;
}

void put_word(std::ofstream& out, std::size_t word) {
  const auto narrow = static_cast<std::uint32_t>(word);
  out.write(reinterpret_cast<const char*>(&narrow), sizeof narrow);
}

void write_chunks(const std::string& path, const std::string& json, const std::vector<char>& binary) {
  constexpr std::size_t kHeads = 12 + 8 + 8;
  const std::size_t total = kHeads + json.size() + binary.size();
  if (total > UINT32_MAX) {
    throw RunError(path + ": the mesh exceeds the 4 GiB limit of GLB: set output.meshes: false, or use larger voxels");
  }
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  for (const std::size_t word : {std::size_t{kMagic}, std::size_t{2}, total, json.size(), std::size_t{kJsonChunk}}) {
    put_word(out, word);
  }
  out << json;
  put_word(out, binary.size());
  put_word(out, kBinaryChunk);
  out.write(binary.data(), static_cast<std::streamsize>(binary.size()));
  close_file(out, path);
}

}  // namespace

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
  write_chunks(path, json, buffer.data());
}

}  // namespace reamsim

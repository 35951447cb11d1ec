#include "render/report/mesh_data.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/bone/voxmap/density.h"

namespace reamsim {
namespace {

using Corner = Eigen::Map<const Eigen::Vector3f>;

constexpr std::size_t kBytes = BoneSurface::kStride * sizeof(float);  // of a vertex
constexpr int kNormal = 3, kDepth = 6, kReamed = 7, kDensity = 8, kAccessibility = 9;

std::size_t vertex_count(const BoneSurface& surface) {
  return surface.vertices.size() / BoneSurface::kStride;
}

/// Appends to `out` the triangles of `indices` after thinning to `most`.
void thin(const BoneSurface& surface, const std::vector<std::uint32_t>& indices, std::size_t most,
          std::vector<std::uint32_t>& out) {
  if (indices.size() <= 3 * most) {
    out.insert(out.end(), indices.begin(), indices.end());
    return;
  }
  constexpr float kAnyError = 1;  // the number of triangles alone decides
  std::vector<std::uint32_t> kept(indices.size());
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), surface.vertices.data(),
                               vertex_count(surface), kBytes, 3 * most, kAnyError, meshopt_SimplifyLockBorder,
                               nullptr));
  out.insert(out.end(), kept.begin(), kept.end());
}

/// 0…255 for 0…1.
std::uint8_t byte_of(float share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0F, 1.0F)));
}

/// Small numbers of either sign become small numbers without one: 0, −1, 1, −2 … to 0, 1, 2, 3 …
std::uint16_t zigzag(std::uint16_t difference) {
  return static_cast<std::uint16_t>((difference << 1) ^ (difference & 0x8000 ? 0xFFFF : 0));
}

/// One number of every vertex, 0…65535 from `low` to `low` + `size`.
void put_numbers16(const BoneSurface& surface, std::size_t part, float low, float size,
                   std::vector<std::uint8_t>& out) {
  std::vector<std::uint8_t> high;
  std::uint16_t before = 0;
  for (std::size_t i = part; i < surface.vertices.size(); i += BoneSurface::kStride) {
    const float share = (surface.vertices[i] - low) / size;
    const auto now = static_cast<std::uint16_t>(std::lround(65535 * std::clamp(share, 0.0F, 1.0F)));
    const std::uint16_t code = zigzag(static_cast<std::uint16_t>(now - before));
    before = now;
    out.push_back(static_cast<std::uint8_t>(code & 255));
    high.push_back(static_cast<std::uint8_t>(code >> 8));
  }
  out.insert(out.end(), high.begin(), high.end());
}

/// The bytes of a vertex for its normal and its attributes but depth.
std::array<std::uint8_t, 6> attribute_bytes(const float* vertex) {
  std::array<std::uint8_t, 6> out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out[axis] = static_cast<std::uint8_t>(std::lround(127 * std::clamp(vertex[kNormal + axis], -1.0F, 1.0F)));
  }
  out[3] = byte_of(vertex[kReamed]);
  out[4] = byte_of(vertex[kDensity] / static_cast<float>(DensityMapping::kMaxDensity_g_cm3));
  out[5] = byte_of(vertex[kAccessibility]);
  return out;
}

void put_attributes(const BoneSurface& surface, std::vector<std::uint8_t>& out) {
  const std::size_t count = vertex_count(surface);
  const std::size_t from = out.size();
  std::array<std::uint8_t, 6> before{};
  out.resize(from + before.size() * count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto now = attribute_bytes(surface.vertices.data() + i * BoneSurface::kStride);
    for (std::size_t part = 0; part < now.size(); ++part) {
      out[from + part * count + i] = static_cast<std::uint8_t>(now[part] - before[part]);
    }
    before = now;
  }
}

void put_corners(const std::vector<std::uint32_t>& indices, std::vector<std::uint8_t>& out) {
  std::uint32_t next = 0;
  for (const std::uint32_t index : indices) {
    std::uint32_t below = next - index;
    if (below == 0) ++next;
    for (; below > 127; below >>= 7) out.push_back(static_cast<std::uint8_t>(128 | (below & 127)));
    out.push_back(static_cast<std::uint8_t>(below));
  }
}

}  // namespace

BoneSurface simplified(const BoneSurface& surface, const MeshBudget& budget) {
  std::vector<std::uint32_t> plain, reamed;
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    bool touched = false;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      touched = touched || surface.vertices[surface.indices[i + corner] * BoneSurface::kStride + kReamed] > 0;
    }
    auto& part = touched ? reamed : plain;
    part.insert(part.end(), surface.indices.begin() + static_cast<std::ptrdiff_t>(i),
                surface.indices.begin() + static_cast<std::ptrdiff_t>(i + 3));
  }
  BoneSurface out;
  out.deepest_mm = surface.deepest_mm;
  thin(surface, plain, budget.unreamed_triangles, out.indices);
  thin(surface, reamed, budget.reamed_triangles, out.indices);
  if (out.indices.empty()) return out;
  meshopt_optimizeVertexCache(out.indices.data(), out.indices.data(), out.indices.size(), vertex_count(surface));
  out.vertices.resize(surface.vertices.size());
  const std::size_t used = meshopt_optimizeVertexFetch(out.vertices.data(), out.indices.data(), out.indices.size(),
                                                       surface.vertices.data(), vertex_count(surface), kBytes);
  out.vertices.resize(used * BoneSurface::kStride);
  return out;
}

std::vector<std::uint8_t> mesh_bytes(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm) {
  std::vector<std::uint8_t> out;
  for (int axis = 0; axis < 3; ++axis) {
    put_numbers16(surface, static_cast<std::size_t>(axis), box.min()[axis], std::max(box.sizes()[axis], 1e-6F), out);
  }
  put_numbers16(surface, kDepth, 0, static_cast<float>(depth_max_mm), out);
  put_attributes(surface, out);
  put_corners(surface.indices, out);
  return out;
}

Eigen::AlignedBox3f bounds_of(const BoneSurface& surface) {
  Eigen::AlignedBox3f box;
  for (std::size_t i = 0; i < surface.vertices.size(); i += BoneSurface::kStride) {
    box.extend(Corner(surface.vertices.data() + i));
  }
  return box;
}

}  // namespace reamsim

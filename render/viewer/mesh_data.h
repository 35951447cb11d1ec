// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "render/surface/bone_surface.h"
#include "render/viewer/page.h"

namespace reamsim {

/// The maximum number of triangles of a mesh on the page.
struct MeshBudget {
  std::size_t unreamed_triangles = 110'000;  ///< of the unreamed surface
  std::size_t reamed_triangles = 90'000;     ///< of the reamed face, which stays finer
};

/// Simplifies a surface with meshoptimizer (edge collapses by quadric error). The vertices are a subset and no cracks
/// open: reamed face and rest are simplified separately with locked borders. Vertices are in the order of their first
/// use.
BoneSurface simplified(const BoneSurface& surface, const MeshBudget& budget);

/// A surface as bytes for the page, little-endian:
/// x, y, z of the vertices (0…65535 over `box`) and depth (over 0…`depth_max_mm`), 16 bits each, as zigzag differences
/// to the previous vertex, for each first all low bytes, then all high bytes; then, as 8-bit differences to the
/// previous vertex, x, y, z of the normal (−127…127), reamed, density (0…255 over 0…2 g/cm³) and ambient accessibility
/// (0…255 over 0…1); then the triangle indices, each as its distance below the first vertex not yet used, as
/// variable-length numbers with 7 bits per byte, low bits first.
std::vector<std::uint8_t> mesh_bytes(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm);

/// Whether mesh_bytes() writes a vertex as reamed.
bool counts_as_reamed(const float* vertex);

/// Appends `values` as 16-bit numbers, 0…65535 from `low` to `low` + `size`, in the code of mesh_bytes().
void append_numbers16(std::span<const double> values, double low, double size, std::vector<std::uint8_t>& out);

/// A surface for the page's JSON: `vertices`, `triangles`, and mesh_bytes() compressed as `bytes`.
nlohmann::ordered_json mesh_json(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm);

/// x, y, z with six significant digits.
template <class Vector>
nlohmann::ordered_json vector_json(const Vector& v) {
  return {short_number(v.x()), short_number(v.y()), short_number(v.z())};
}
/// Lower and upper corner of a box.
template <class Vector>
nlohmann::ordered_json box_json(const Vector& low, const Vector& high) {
  return nlohmann::ordered_json::array({vector_json(low), vector_json(high)});
}

/// The bounding box of a surface, mm.
Eigen::AlignedBox3f bounds_of(const BoneSurface& surface);

}  // namespace reamsim

#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "render/surface/bone_surface.h"

namespace reamsim {

/// How many triangles a mesh on the page may have.
struct MeshBudget {
  std::size_t unreamed_triangles = 110'000;  ///< of bone as it was
  std::size_t reamed_triangles = 90'000;  ///< of the reamed face, which is kept finer
};

/// `surface` with fewer triangles, by meshoptimizer (edge collapses by quadric error); its corners are corners of
/// `surface`, and no crack opens. The face that was reamed and the rest are thinned one after the other, each with
/// its border held. Vertices come in the order in which triangles use them first.
BoneSurface simplified(const BoneSurface& surface, const MeshBudget& budget);

/// A surface as bytes for the page. Little-endian, one after the other:
/// x, y, z of the vertices (0…65535 over `box`) and depth (over 0…`depth_max_mm`), 16 bits each, as differences to the
/// vertex before (zigzag), of each all low bytes before all high bytes; then as 8-bit differences to the vertex before
/// the normal's x, y, z (−127…127), and reamed, density (0…255 over 0…2 g/cm³), ambient accessibility (0…255 over 0…1);
/// then the triangles' corners, each as the distance below the first vertex that no corner has named yet, in
/// variable-length numbers of 7 bits a byte, low bits first.
std::vector<std::uint8_t> mesh_bytes(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm);

/// The box of a surface's vertices, mm.
Eigen::AlignedBox3f bounds_of(const BoneSurface& surface);

}  // namespace reamsim

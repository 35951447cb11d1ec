// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Writes the reamers of assets/ as binary STL: `generate_reamers DIR`. assets/README.md says how each is made.
#include <exception>
#include <filesystem>
#include <iostream>

#include "assets/reamer_shapes.h"
#include "sim/mesh/mesh_io.h"
#include "sim/tool/profile.h"

int main(int argc, char** argv) {
  using namespace reamsim;
  if (argc != 2) {
    std::cerr << "usage: generate_reamers DIR\n";
    return 2;
  }
  const std::filesystem::path dir = argv[1];
  try {
    std::filesystem::create_directories(dir);
    write_stl(dir / "reamer_hemispherical.stl", revolve(assets::hemispherical_profile(), assets::kHemisphereSegments));
    write_stl(dir / "reamer_convex.stl", revolve(assets::convex_profile(), assets::kRingSegments));
    write_stl(dir / "reamer_flat.stl", revolve(assets::flat_profile(), assets::kRingSegments));
    write_stl(dir / "reamer_convex_edges.stl", assets::convex_with_cutting_edges());
    write_stl(dir / "drill_3_2mm.stl", revolve(assets::drill_profile(), assets::kRingSegments));
  } catch (const std::exception& error) {
    std::cerr << "generate_reamers: " << error.what() << '\n';
    return 1;
  }
  return 0;
}

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_io.h"

#include "input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace reamsim;
  for (const char* name : {"mesh.stl", "mesh.ply"}) {
    test::read_input(data, size, name, [](const std::string& path) { check_mesh_file(path); });
  }
  return 0;
}

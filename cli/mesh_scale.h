// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>

#include "cli/console.h"

namespace reamsim {

/// File units to mm of a bone's mesh that has no scenario yet.
struct MeshScale {
  double scale = 1;
  std::string why;  ///< for a comment: "given by --scale"; "" of a scan, whose file says its unit
};

/// The scale that the option --scale gives, or by the length of the mesh, which is then said at once: what follows may
/// fail because it is wrong. Throws InputError: --scale for a scan, an unreadable mesh, an unknown unit, or a mesh that
/// is too long or too short for a bone with a glenoid, whose voxels could fill the memory.
MeshScale mesh_scale(const std::string& path, std::optional<double> of_option, const Console& console);

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>

#include "sim/base/error.h"
#include "sim/base/geometry.h"

namespace reamsim {

/// Throws InputError if the longest side of a bone with a glenoid frame is not 20 to 400 mm: the mesh has another unit.
/// The message lists the scales that would fit. Without a frame any solid may be reamed, and a size beyond 10 to 400 mm
/// is a warning. `bounds_mm` includes `scale`.
void check_mesh_unit(const std::string& path, const Aabb& bounds_mm, double scale, bool has_glenoid,
                     Diagnostics& report);

/// Whether a solid of this length, 10 to 400 mm, is likely to be given in the right unit.
bool is_likely_length(const Aabb& bounds_mm);

/// What is known of the unit of a mesh.
struct FoundScale {
  double scale = 1;      ///< file units to mm
  std::string unit;      ///< "metres"
  double length_mm = 0;  ///< longest side of the mesh, with the scale
  bool assumed = false;  ///< no unit is likely: mm, although a scapula is longer or shorter
};

/// The unit in which a mesh has the length of a scapula; mm where several or none do, but a bone with a glenoid may be
/// that long. `file_length`: its longest side, in file units. nullopt where mm are impossible and no unit is likely.
std::optional<FoundScale> find_scale(double file_length);

/// find_scale() of a file. Throws InputError: unreadable, or an unknown unit; then with the scales that would fit,
/// after the words `what_to_set`.
FoundScale find_scale_of(const std::string& path, const std::string& what_to_set);

/// Throws InputError where, with this scale, the mesh is not 20 to 400 mm long, as a bone with a glenoid is; with the
/// scales that would fit, after the words `what_to_set`.
void require_scale(const std::string& path, double scale, const std::string& what_to_set);

}  // namespace reamsim

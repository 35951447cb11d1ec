// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <map>
#include <string>

#include "sim/isolation/child_result.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

// What child processes hand back about images. The functions that take it throw InputError where it is inconsistent.

/// The warning of a header without orientation.
inline constexpr const char* kNoOrientation =
    "the header does not say how the axes lie in the body; left, posterior, superior are assumed. Check side and "
    "glenoid, "
    "or export the file with its orientation";

/// What the header of an image file says.
struct ImageFacts {
  std::string format;
  std::string pixel_type;  ///< "int16", "float", ...
  ScanGeometry geometry;
  int layers = 1;
  double bytes_per_voxel = 0;         ///< of all layers
  std::string frame;                  ///< what in the header places the voxels
  std::vector<std::string> warnings;  ///< what it leaves open or contradicts
};

/// An IndexBox, or dimensions, as a plain value for a child.
struct PlainBox {
  explicit PlainBox(const IndexBox& box)
      : start{box.start.x(), box.start.y(), box.start.z()}, size{box.size.x(), box.size.y(), box.size.z()} {}
  [[nodiscard]] IndexBox get() const { return {Vec3i(start[0], start[1], start[2]), Vec3i(size[0], size[1], size[2])}; }

  std::array<int, 3> start;
  std::array<int, 3> size;
};

/// Whether voxels have a volume, and edges of a plausible length.
bool is_plausible(const ScanGeometry& geometry);

void put_geometry(ResultWriter& out, const ScanGeometry& geometry);
ScanGeometry take_geometry(ResultReader& in);

void put_facts(ResultWriter& out, const ImageFacts& facts);
ImageFacts take_facts(ResultReader& in);

void put_texts(ResultWriter& out, const std::map<std::string, std::string>& texts);
std::map<std::string, std::string> take_texts(ResultReader& in);

}  // namespace reamsim::ct

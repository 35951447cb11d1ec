// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/dicom_header.h"
#include "sim/scan/scan.h"
#include "sim/scan/slice_spacing.h"

namespace reamsim::ct {

// The volumes of one DICOM series: phases, acquisitions, reconstructions. Private to sim/scan.

struct Slice {
  const DicomHeader* header = nullptr;
  ScanGeometry geometry;  ///< from the file; its slice thickness may differ from the slice spacing
  std::string pixel_type;
  double height_mm = 0;     ///< of its origin along the slice normal
  double half_unit_mm = 0;  ///< half a unit of the last digit of its position, along the normal
  double rounding_mm = 0;   ///< the same in any direction

  [[nodiscard]] const std::string& path() const { return header->path; }
};

using Stack = std::vector<Slice>;

std::vector<SlicePlace> places_of(const Stack& stack);

/// Slices of one size and orientation, sorted by height.
struct DicomVolume {
  std::string label;  ///< "AcquisitionNumber=1"; empty: the only one
  Stack slices;
};

/// Sorts by height, finds the rounding of positions, and removes copies of a slice (the same instance). Returns the
/// number of copies.
int sort_slices(Stack& stack);

/// The volumes in sorted slices of one geometry. Where different slices have the same position, or where slices of two
/// volumes alternate, the first elements that tell them apart divide them, one of separating_tags() or two. Without
/// such an element, and as many slices at every position, their instance numbers do. One volume otherwise.
std::vector<DicomVolume> volumes_in(const Stack& sorted);

/// The first slice that lies where its neighbour lies; -1: none.
std::ptrdiff_t same_place(const Stack& sorted);

/// Elements that differ within a volume as they would if two volumes were mixed: "ConvolutionKernel B30f and B60s".
/// Empty: none.
std::string mixed_elements(const Stack& sorted);

}  // namespace reamsim::ct

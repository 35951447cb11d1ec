// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/error.h"
#include "sim/scan/aligned_image.h"
#include "sim/scan/label_map.h"
#include "sim/scenario/scenario.h"

namespace reamsim::ct {

/// Compares the wanted label with the scan, and warns, with volume and place, of
/// - bone that has no label and that the label encloses or that lies in a hole or notch of it no wider than 10 mm:
/// voxels
///   of at least `refine_hu` in the closing of the label;
/// - a label that ends at the edge of the scan;
/// - pieces of the label beside the largest.
/// With `fill` the first become bone, and cavities that the label encloses.
void check_label(LabelImages& labels, const AlignedImage& hu, const CtSettings& settings, Diagnostics& report);

}  // namespace reamsim::ct

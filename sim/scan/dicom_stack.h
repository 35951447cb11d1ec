// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/dicom_volumes.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

/// Slices that form a volume, in the order of their positions.
struct DicomStack {
  std::vector<SliceSource> slices;
  std::vector<SliceBlend> blends;  ///< of the slices of the volume, where it is interpolated between `slices`
  std::string pixel_type;
  ScanGeometry geometry;
  double kvp = 0;  ///< of the first slice; 0: unknown
  int files = 0;
};

/// Sorts the slices of a series, or of the volume of it that is chosen. Skips, with a warning, images of another size,
/// spacing or orientation (a scout) and copies of a slice. Warns of rounded positions, slices missing at the ends,
/// lossy compression and mixed volumes. Files of `folder` that cannot be read may be missing slices. `resample`: slices
/// that are not evenly spaced are interpolated, with a warning. Throws InputError with the file: several volumes,
/// truncated, damaged, MONOCHROME1, a multi-frame file without positions, missing, unevenly spaced, duplicate,
/// displaced.
DicomStack stack_slices(const DicomSeries& series, const SeriesChoice& choice, const DicomFolder& folder,
                        const std::string& key, bool resample, Diagnostics& report);

}  // namespace reamsim::ct

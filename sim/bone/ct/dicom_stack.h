#pragma once

#include <string>
#include <vector>

#include "sim/base/report.h"
#include "sim/bone/ct/dicom_series.h"
#include "sim/bone/ct/scan.h"

namespace reamsim::ct {

/// Slices that form a volume, in the order of their positions.
struct DicomStack {
  std::vector<std::string> path;
  ScanGeometry geometry;
};

/// Puts the slices of a series into order. Images of another size, spacing or orientation are left out with a warning
/// (a scout), and so are copies of a slice. `damaged` are files that may be what is missing.
/// Throws InputError naming the file: cut off, MONOCHROME1, multi-frame, missing, twice, displaced.
DicomStack stack_slices(const DicomSeries& series, const std::vector<std::string>& damaged, const std::string& key,
                        Report& report);

}  // namespace reamsim::ct

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <set>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/dicom_volumes.h"

namespace reamsim::ct {

// What is checked of the slices of a DICOM volume. Private to sim/scan.

/// Axes of slices are equal to within this fraction of the side of a pixel.
inline constexpr double kSameAxes = 2e-3;

/// "26x20 pixels; the other slices have 26x30".
std::string difference(const ScanGeometry& other, const ScanGeometry& usual);

/// Throws InputError: MONOCHROME1, or slices with and without rescale.
void check_values(const Stack& stack, const std::string& key);

/// The files that lie beside the slices and are named like them: slices that are damaged beyond recognition.
std::vector<std::string> named_like_slices(const Stack& stack, const std::vector<std::string>& files);

/// Throws InputError for a fault of the spacing. `groups`: all slices of the series by geometry, the stack's first;
/// one of the others, or a `skipped` file, may be the missing slice.
[[noreturn]] void refuse_spacing(const SpacingFault& fault, const Stack& stack, const std::vector<Stack>& groups,
                                 const std::vector<std::string>& skipped, const std::string& key);

/// Throws InputError unless the slices lie on the line, at these places along it. Warns of the largest deviation.
void check_straight(const Stack& stack, const SliceLine& line, const std::vector<double>& at, const std::string& key,
                    Diagnostics& report);

/// Warns of instance numbers before the first and after the last slice that no image of the series has.
void warn_of_missing_ends(const Stack& stack, const DicomSeries& series, Diagnostics& report);

/// Warns of lossy compression, and of two volumes that are mixed.
void warn_of_values(const Stack& stack, Diagnostics& report);

}  // namespace reamsim::ct

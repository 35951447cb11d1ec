// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scan/dicom_header.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

/// A mistake in a DICOM segmentation, with what to do about it.
InputError bad_seg(const std::string& path, const std::string& key, const std::string& found);

/// The evenly spaced planes on which the frames of a segmentation lie; SEG leaves empty planes out.
struct SegPlanes {
  ScanGeometry geometry;
  std::vector<int> plane_of_frame;
};

/// Throws InputError: frames without a place, of different orientations or spacings, not on evenly spaced planes.
SegPlanes seg_planes(const std::vector<DicomHeader>& frames, const std::string& path, const std::string& key);

}  // namespace reamsim::ct

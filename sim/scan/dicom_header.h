// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim::ct {

/// The header of a DICOM file. Texts are printable ASCII without padding.
struct DicomHeader {
  std::string path;
  std::string series_uid;
  std::string instance_uid;
  std::string description;
  std::string kernel;    ///< convolution kernel of the reconstruction
  std::string modality;  ///< "CT", "MR", ...
  std::string photometric;
  int series_number = 0;
  int frames = 1;  ///< above 1: a multi-frame file
  int columns = 0;
  int rows = 0;
  bool rescales = false;  ///< says how its values become HU
  double kvp = 0;         ///< tube voltage, kV; 0: unknown
  std::optional<Vec2> pixel_spacing_mm;
  std::optional<Vec3> position_mm;  ///< of the first pixel, LPS
  std::optional<Vec3> normal;       ///< across the slice
};

enum class DicomKind {
  other,     ///< not a DICOM file
  no_image,  ///< a DICOM file without an image: a report, a plan, a directory
  damaged,   ///< a DICOM file whose header cannot be read
  image
};

/// Reads a file up to its pixels. Fills `header` if the file contains an image.
DicomKind read_dicom_header(const std::string& path, DicomHeader& header);

}  // namespace reamsim::ct

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scan/scan_transfer.h"

namespace reamsim::ct {

// DICOM files are read by child processes, because GDCM crashes on some damaged files.

/// The headers of `files`, in their order. Files that crash the reader, or take it too long, are DicomKind::damaged.
/// `folder`: for messages. Throws InputError when there are many such files.
std::vector<DicomFile> read_dicom_headers(const std::vector<std::string>& files, const std::string& folder,
                                          const std::string& key);

/// What the file of a slice says about its pixels.
struct SliceFacts {
  ScanGeometry geometry;  ///< its slice thickness may differ from the slice spacing
  std::string pixel_type;
};

/// Throws InputError, with the file: truncated, damaged.
std::vector<SliceFacts> read_slice_facts(const std::vector<std::string>& files, const std::string& key);

/// The values of a box of each slice, one slice after the other. Throws InputError, with the file.
std::vector<float> read_slices(const std::vector<std::string>& files, const IndexBox& in_slice, const std::string& key);

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

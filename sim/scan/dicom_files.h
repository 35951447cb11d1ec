// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/scan/scan.h"
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

/// Reads a file up to its pixels. Fills `header` if the file contains an image.
DicomKind read_dicom_header(const std::string& path, DicomHeader& header);

/// The images of a folder with one series UID, sorted by path.
struct DicomSeries {
  std::string uid;
  std::string description;
  std::string kernel;
  std::string modality;
  int number = 0;
  std::vector<DicomHeader> images;
  /// Pixel spacing and median slice spacing; 0 where unknown.
  Vec3 spacing_mm = Vec3::Zero();

  /// Number of files, or of frames in multi-frame files.
  [[nodiscard]] int slices() const;
};

struct DicomFolder {
  std::vector<DicomSeries> series;   ///< by series number, then UID: the order that the scenario's numbers refer to
  std::vector<std::string> damaged;  ///< DICOM files that cannot be read
  std::vector<std::string> others;   ///< not recognized as DICOM
};

/// All DICOM images in a folder and its subfolders. Throws InputError if there is none.
DicomFolder find_dicom_series(const std::string& folder, const std::string& key, Diagnostics& report);

/// "1: UID 1.2.3, "Bone", CT, 24 slices of 512x512, 0.488x0.488x1.25 mm, kernel B60s; 2: ...".
std::string list_of(const std::vector<DicomSeries>& series);

/// The series that the scenario chooses by UID or number, or else the CT series with the most slices, with a warning if
/// there are several. Throws InputError: no such series, not CT, two with the same number and spacing of slices.
const DicomSeries& choose_series(const DicomFolder& found, const DicomChoice& choice, const std::string& folder,
                                 Diagnostics& report);

}  // namespace reamsim::ct

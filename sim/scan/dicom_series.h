// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

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

#pragma once

#include <string>
#include <vector>

#include "sim/base/report.h"
#include "sim/bone/ct/dicom_header.h"
#include "sim/bone/ct/scan.h"

namespace reamsim::ct {

/// The images of a folder that bear one series UID, in the order of their paths.
struct DicomSeries {
  std::string uid;
  std::string description;
  std::string kernel;
  std::string modality;
  int number = 0;
  std::vector<DicomHeader> images;
  /// Pixels, and the median distance of neighbouring slices; 0 where the files do not say.
  Vec3 spacing_mm = Vec3::Zero();

  /// Files, or frames where files hold several.
  [[nodiscard]] int slices() const;
};

struct DicomFolder {
  std::vector<DicomSeries> series;   ///< by series number, then UID: what the scenario's numbers count
  std::vector<std::string> damaged;  ///< files that begin as DICOM and cannot be read
};

/// Every DICOM image in a folder and its subfolders. Throws InputError where there is none.
DicomFolder find_dicom_series(const std::string& folder, const std::string& key, Report& report);

/// "1: UID 1.2.3, "Bone", CT, 24 slices of 512x512, 0.488x0.488x1.25 mm, kernel B60s; 2: ...".
std::string list_of(const std::vector<DicomSeries>& series);

/// The series that the scenario asks for by UID or number, or else the CT series with the most slices, which is said
/// where there are several. Throws InputError: no such series, not CT, two that are equally good.
const DicomSeries& choose_series(const DicomFolder& found, const DicomChoice& choice, const std::string& folder,
                                 Report& report);

}  // namespace reamsim::ct

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim::ct {

/// What one DICOM file says of itself before its pixels. Texts hold printable ASCII only, without padding.
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
  std::optional<Vec2> pixel_spacing_mm;
  std::optional<Vec3> position_mm;  ///< of the first pixel, LPS
  std::optional<Vec3> normal;       ///< across the slice
};

enum class DicomKind {
  other,     ///< no DICOM file
  no_image,  ///< a DICOM file without an image: a report, a plan, a directory
  damaged,   ///< begins as DICOM, and cannot be read as far as its pixels
  image
};

/// Reads one file as far as its pixels. `header` is filled where an image is found.
DicomKind read_dicom_header(const std::string& path, DicomHeader& header);

/// The files in a folder and its subfolders in the order of their paths, so that nothing depends on the file system's
/// order. Links to folders are not followed.
std::vector<std::string> files_below(const std::string& folder);

}  // namespace reamsim::ct

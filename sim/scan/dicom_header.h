// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/isolation/child_result.h"

namespace reamsim::ct {

/// The directions of the rows and of the columns of a slice, unit vectors in LPS.
using SliceAxes = Eigen::Matrix<double, 3, 2>;

/// The header of a slice: of a DICOM file, or of a frame of a multi-frame file. Texts are printable ASCII without
/// padding.
struct DicomHeader {
  std::string path;
  std::string series_uid;
  std::string instance_uid;  ///< with the number of the frame
  std::string sop_class;
  std::string description;
  std::string kernel;    ///< convolution kernel of the reconstruction
  std::string modality;  ///< "CT", "MR", ...
  std::string photometric;
  std::string pixel_type;     ///< "int16", ...
  std::string position_text;  ///< the position as it is written, "x\y\z", for its rounding
  std::string lossy;          ///< how the pixels were compressed with loss; empty: they were not
  int series_number = 0;
  int frames = 1;  ///< above 1: a multi-frame file
  int frame = -1;  ///< index of a frame that says where it lies (functional groups); -1: the file is one slice
  int columns = 0;
  int rows = 0;
  int images_in_acquisition = 0;  ///< 0: unknown
  bool rescales = false;          ///< says how its values become HU
  double slope = 1;               ///< of a frame
  double intercept = 0;           ///< of a frame
  double kvp = 0;                 ///< tube voltage, kV; 0: unknown
  double slice_spacing_mm = 0;    ///< as the header says it, else the slice thickness; 0: unknown
  std::optional<int> instance_number;
  std::optional<Vec2> pixel_spacing_mm;  ///< of columns (along a row) and of rows
  std::optional<Vec3> position_mm;       ///< of the first pixel, LPS
  std::optional<SliceAxes> axes;
  /// What may tell the volumes of a series apart, by keyword: "AcquisitionNumber".
  std::map<std::string, std::string> tags;

  [[nodiscard]] Vec3 normal() const { return axes->col(0).cross(axes->col(1)); }
};

enum class DicomKind {
  other,        ///< not a DICOM file
  no_image,     ///< a DICOM file without an image: a report, a plan, a directory
  damaged,      ///< a DICOM file whose header cannot be read
  unsupported,  ///< in a transfer syntax that cannot be decoded
  image
};

/// A DICOM file.
struct DicomFile {
  DicomKind kind = DicomKind::other;
  std::string note;                 ///< the transfer syntax that cannot be decoded; the modality without an image
  std::vector<DicomHeader> images;  ///< one, or its frames
};

/// What a child process hands back about a DICOM file.
void put_dicom_file(ResultWriter& out, const DicomFile& file);
/// Throws InputError where it is inconsistent.
DicomFile take_dicom_file(ResultReader& in);

/// Reads a file up to its pixels.
DicomFile read_dicom_header(const std::string& path);

}  // namespace reamsim::ct

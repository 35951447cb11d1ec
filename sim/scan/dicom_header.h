// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "sim/base/geometry.h"

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
  [[nodiscard]] bool is_valid() const {
    const auto is_finite = [](const auto& numbers) { return !numbers || numbers->allFinite(); };
    return is_finite(pixel_spacing_mm) && is_finite(position_mm) && is_finite(axes);
  }
  /// The value of an element that may tell volumes apart; "" without it.
  [[nodiscard]] std::string tag(const std::string& keyword) const {
    const auto found = tags.find(keyword);
    return found == tags.end() ? "" : found->second;
  }

  static auto fields(auto& h) {
    return std::tie(h.path, h.series_uid, h.instance_uid, h.sop_class, h.description, h.kernel, h.modality,
                    h.photometric, h.pixel_type, h.position_text, h.lossy, h.series_number, h.frames, h.frame,
                    h.columns, h.rows, h.images_in_acquisition, h.rescales, h.slope, h.intercept, h.kvp,
                    h.slice_spacing_mm, h.instance_number, h.pixel_spacing_mm, h.position_mm, h.axes, h.tags);
  }
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

  [[nodiscard]] bool is_valid() const {
    return kind >= DicomKind::other && kind <= DicomKind::image && (kind == DicomKind::image) != images.empty();
  }

  static auto fields(auto& self) { return std::tie(self.kind, self.note, self.images); }
};

/// Reads a file up to its pixels.
DicomFile read_dicom_header(const std::string& path);

}  // namespace reamsim::ct

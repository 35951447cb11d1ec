// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/scan/scan.h"

namespace reamsim::ct {

// DICOM files are read by child processes, because GDCM crashes on some damaged files.

/// The directions of the rows and of the columns of a slice, perpendicular unit vectors in LPS.
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
  std::string assumed;        ///< what was taken for an element that is incomplete; empty: none is
  int series_number = 0;
  int frames = 1;  ///< above 1: a multi-frame file
  int frame = -1;  ///< index of a frame that says where it lies (functional groups); -1: the file is one slice
  int columns = 0;
  int rows = 0;
  int images_in_acquisition = 0;  ///< 0: unknown
  bool rescales = false;          ///< says how its values become HU
  double slope = 1;
  double intercept = 0;
  double kvp = 0;               ///< tube voltage, kV; 0: unknown
  double slice_spacing_mm = 0;  ///< as the header says it, else the slice thickness; 0: unknown
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
                    h.photometric, h.pixel_type, h.position_text, h.lossy, h.assumed, h.series_number, h.frames,
                    h.frame, h.columns, h.rows, h.images_in_acquisition, h.rescales, h.slope, h.intercept, h.kvp,
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

/// Whether a file looks like DICOM: "DICM" after the preamble, or without one an element of the first groups.
bool looks_like_dicom(const std::string& path);

/// The headers of `files`, in their order. Files that crash the reader, or take it too long, are DicomKind::damaged.
/// `folder`: for messages. Throws InputError when there are many such files.
std::vector<DicomFile> read_dicom_headers(const std::vector<std::string>& files, const ForeignFile& folder);

/// What is read of a slice, with its rescale.
struct SliceSource {
  std::string path;
  int frame = -1;  ///< of the file; -1: the file is one slice
  double slope = 1;
  double intercept = 0;
  double file_pixels = 0;  ///< of all frames

  static auto fields(auto& s) { return std::tie(s.path, s.frame, s.slope, s.intercept, s.file_pixels); }
};

/// The values of a box of each slice, one slice after the other. Throws InputError, with the file.
std::vector<float> read_slices(const std::vector<SliceSource>& slices, const IndexBox& in_slice);

/// The error of pixels that are cut off, or in a coding that GDCM should decode and does not: damaged, or a variant.
InputError unreadable(const ForeignFile& file);

/// The regular files in a folder and its subfolders, sorted by path, or the file `path`. Links to folders are not
/// followed.
std::vector<std::string> files_below(const std::string& path);

/// The images of a folder with one series UID, sorted by path.
struct DicomSeries {
  std::vector<DicomHeader> images;
  /// Pixel spacing and median slice spacing; 0 where unknown.
  Vec3 spacing_mm = Vec3::Zero();

  [[nodiscard]] const DicomHeader& first() const { return images.front(); }
  /// Number of slices: frames count each.
  [[nodiscard]] int slices() const;
};

struct DicomFolder {
  std::vector<DicomSeries> series;   ///< by series number, then UID: the order that the scenario's numbers refer to
  std::vector<std::string> damaged;  ///< DICOM files that cannot be read
  std::vector<std::string> unread;   ///< these, files coded in a way that cannot be decoded, others than DICOM
  std::string folder;                ///< or a single file
};

/// All DICOM images in a folder and its subfolders, or the file `folder`. Throws InputError if there is none, or if
/// files are coded in a way that cannot be decoded.
DicomFolder find_dicom_series(const std::string& folder, Diagnostics& report);

/// "1: UID 1.2.3, "Bone", CT, 24 slices of 512x512, 0.488x0.488x1.25 mm, kernel B60s; 2: ...".
std::string list_of(const std::vector<DicomSeries>& series);

inline constexpr const char* kSeriesKey = "bone.ct.series";

/// What bone.ct.series says: SERIES, SERIES/VOLUME or SERIES#TAG=VALUE#TAG=VALUE. SERIES is a UID or number; without
/// it the usual series is meant.
struct SeriesChoice {
  std::string series;
  int volume = 0;                                         ///< in the list of its volumes, from 1; 0: not given
  std::vector<std::pair<std::string, std::string>> tags;  ///< keyword and value
};

/// Throws InputError.
SeriesChoice parse_series_choice(const std::string& text, const std::string& folder);

/// The series that the scenario chooses by UID or number, or else the CT series with the most slices, with a warning if
/// there are several. Throws InputError: no such series, not CT, two with the same number and spacing of slices.
const DicomSeries& choose_series(const DicomFolder& found, const SeriesChoice& chosen, bool any_modality,
                                 Diagnostics& report);

}  // namespace reamsim::ct

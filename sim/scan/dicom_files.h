// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/scan/dicom_header.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

// DICOM files are read by child processes, because GDCM crashes on some damaged files.

/// Whether a file looks like DICOM: "DICM" after the preamble, or without one an element of the first groups.
bool looks_like_dicom(const std::string& path);

/// The headers of `files`, in their order. Files that crash the reader, or take it too long, are DicomKind::damaged.
/// `folder`: for messages. Throws InputError when there are many such files.
std::vector<DicomFile> read_dicom_headers(const std::vector<std::string>& files, const std::string& folder,
                                          const std::string& key);

/// What the file of a slice says about its pixels.
struct SliceFacts {
  ScanGeometry geometry;  ///< its slice thickness may differ from the slice spacing
  std::string pixel_type;

  static auto fields(auto& self) { return std::tie(self.geometry, self.pixel_type); }
};

/// Of the slices `headers`, in their order. Throws InputError, with the file: truncated, damaged.
std::vector<SliceFacts> read_slice_facts(const std::vector<const DicomHeader*>& headers, const std::string& key);

/// What is read of a slice: a file, or a frame of it with its rescale.
struct SliceSource {
  std::string path;
  int frame = -1;
  double slope = 1;
  double intercept = 0;
  double file_pixels = 0;  ///< of all frames

  static auto fields(auto& s) { return std::tie(s.path, s.frame, s.slope, s.intercept, s.file_pixels); }
};

/// The values of a box of each slice, one slice after the other. Throws InputError, with the file.
std::vector<float> read_slices(const std::vector<SliceSource>& slices, const IndexBox& in_slice,
                               const std::string& key);

/// The regular files in a folder and its subfolders, sorted by path, or the file `path`. Links to folders are not
/// followed.
std::vector<std::string> files_below(const std::string& path);

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
DicomFolder find_dicom_series(const std::string& folder, const std::string& key, Diagnostics& report);

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

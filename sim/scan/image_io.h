// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <itkImageIOBase.h>
#include <cstdint>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "sim/scan/scan.h"

namespace reamsim::ct {

// Reading with ITK, for child processes. Private to sim/scan: only its sources include this header.

/// The warning of a header without orientation.
inline constexpr const char* kNoOrientation =
    "the header does not say how the axes lie in the body; left, posterior, superior are assumed. Check side and "
    "glenoid, "
    "or export the file with its orientation";

/// What the header of an image file says.
struct ImageFacts {
  std::string format;
  std::string pixel_type;  ///< "int16", "float", ...
  ScanGeometry geometry;
  int layers = 1;
  double bytes_per_voxel = 0;          ///< of all layers
  std::string frame;                   ///< what in the header places the voxels
  std::vector<std::string> warnings;   ///< what it leaves open or contradicts
  std::vector<NamedSegment> segments;  ///< the labels that it names

  [[nodiscard]] bool is_valid() const { return layers >= 1 && bytes_per_voxel > 0; }

  static auto fields(auto& f) {
    return std::tie(f.format, f.pixel_type, f.geometry, f.layers, f.bytes_per_voxel, f.frame, f.warnings, f.segments);
  }
};

/// The reader of a file by its content, without ITK's global list of factories. Sets `format`: "NRRD", "MetaImage",
/// "DICOM". Throws InputError: none of these, or a header on which the libraries would crash.
itk::ImageIOBase::Pointer open_image_io(const std::string& path, const std::string& key, std::string& format);

/// Reads the header and checks the file against it. Throws InputError: damaged, truncated, a single DICOM slice, not a
/// volume, larger than the memory.
ImageFacts check_image(itk::ImageIOBase& io, const std::string& path, const std::string& key, const std::string& format,
                       bool allow_layers);

/// Throws InputError when the header is damaged.
void read_header(itk::ImageIOBase& io, const std::string& path, const std::string& key, const std::string& format);

/// The geometry in the header. Throws InputError unless the image is a volume (or a slice with `allow_slice`) with one
/// value per voxel (or several with `allow_layers`).
ScanGeometry geometry_of(const itk::ImageIOBase& io, const std::string& path, const std::string& key, bool allow_slice,
                         bool allow_layers = false);

/// Throws InputError unless the sizes along the axes are those of a volume, or of a slice where that is allowed.
void check_volume(const std::vector<std::int64_t>& sizes, bool allow_slice, const std::string& path,
                  const std::string& key);

/// "int16", "float", ...
std::string pixel_type_of(const itk::ImageIOBase& io);

/// Writes the values in `box`, of one layer, to `out`. Throws InputError: truncated, damaged.
void read_voxels(itk::ImageIOBase& io, const IndexBox& box, int layer, const std::string& path, const std::string& key,
                 float* out);

/// The error of a file whose voxels end too early.
InputError cut_off(const std::string& path, const std::string& key);

// What ITK reads otherwise than the format says, by version, and what a header leaves open (image_conventions.cpp). All
// after ReadImageInformation().

/// The geometry that ITK gives, mm in LPS, as the file means it: NRRD in the space left-anterior-superior or in one
/// with time, which versions of ITK convert differently, and NRRD in other units than mm.
ScanGeometry apply_format_conventions(const itk::ImageIOBase& io, ScanGeometry geometry);

/// What in the header places the voxels, and warnings of what it leaves open. Orientation: NRRD without an anatomical
/// space; ITK takes the axes as left, posterior, superior. Units: NRRD in units that are unknown, which are taken as
/// mm.
void describe_header(const itk::ImageIOBase& io, ImageFacts& facts);

/// Throws InputError where the voxels of an NRRD are encoded in a way that ITK cannot read.
void check_encoding(const std::string& path, const std::string& key);

/// Opens a folder of DICOM slices, or a multi-frame file (dicom_stack.cpp). Throws InputError: no DICOM, slices that do
/// not form a volume.
std::unique_ptr<ScanSource> open_dicom(const std::string& path, const std::string& key, const DicomChoice& choice,
                                       Diagnostics& report);

/// Opens a DICOM segmentation (SEG), or a folder with one (dicom_seg.cpp). Each segment is named by its label; its
/// value is its number. Throws InputError: no segmentation, several, damaged, frames that do not form a volume.
std::unique_ptr<LabelSource> open_dicom_seg(const std::string& path, const std::string& key, Diagnostics& report);

/// Suppresses the output of ITK, GDCM and MetaIO during its lifetime. These libraries print warnings about
/// damaged files, where a user should see only the message of the exception. Not for concurrent use.
class QuietLibraries {
 public:
  QuietLibraries();
  ~QuietLibraries();
  QuietLibraries(const QuietLibraries&) = delete;
  QuietLibraries& operator=(const QuietLibraries&) = delete;

  /// Whether MetaIO or GDCM printed that voxels are missing. They report it in no other way.
  [[nodiscard]] bool reports_missing_voxels() const;

 private:
  std::ostringstream captured_;
  std::streambuf* cerr_;
  std::streambuf* cout_;
  int stderr_ = -1;  ///< copy of the file descriptor of stderr
};

}  // namespace reamsim::ct

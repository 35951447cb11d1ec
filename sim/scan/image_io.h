// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <itkImageIOBase.h>
#include <array>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "sim/scan/scan.h"

namespace reamsim::ct {

// Image files: reading with ITK, and of NIfTI by its bytes, for child processes. Private to sim/scan: only its sources
// include this header.

/// The warning of a header without orientation.
inline constexpr const char* kNoOrientation =
    "the header does not say how the axes lie in the body; left, posterior, superior are assumed. Check side and "
    "glenoid, or export the file with its orientation";

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

/// The ITK reader of a file by its content, without ITK's global list of factories, after it has read the header.
/// Throws InputError: neither NRRD nor MetaImage, or damaged.
itk::ImageIOBase::Pointer open_image_io(const ForeignFile& file);

/// Checks the file against its header. Throws InputError: truncated, no volume of single numbers (of several with
/// `allow_layers`), larger than the memory.
ImageFacts check_image(const itk::ImageIOBase& io, const ForeignFile& file, bool allow_layers);

/// Throws InputError unless the sizes along the axes are those of a volume.
void check_volume(const std::vector<std::int64_t>& sizes, const ForeignFile& file);

/// Writes the values in `box`, of one layer, to `out`. Throws InputError: truncated, damaged.
void read_voxels(itk::ImageIOBase& io, const IndexBox& box, int layer, const ForeignFile& file, float* out);

/// The error of a file whose voxels end too early.
InputError cut_off(const ForeignFile& file);

// What ITK reads otherwise than the format says, by version, and what a header leaves open (image_placement.cpp).

bool is_nrrd(const itk::ImageIOBase& io);

/// Corrects the geometry that ITK gives, mm in LPS, to what the file means: NRRD in the space left-anterior-superior or
/// in one with time, which versions of ITK convert differently, and NRRD in other units than mm. Sets what places the
/// voxels, and warnings of what the header leaves open: NRRD without an anatomical space, whose axes ITK takes as left,
/// posterior, superior, or in unknown units, which are taken as mm.
void apply_conventions(const itk::ImageIOBase& io, ImageFacts& facts);

/// Throws InputError where the voxels of an NRRD are encoded in a way that ITK cannot read.
void check_encoding(const ForeignFile& file);

// NIfTI-1, NIfTI-2 and Analyze 7.5, compressed or not, read from their bytes: the geometry does not depend on the
// version of a library, and headers that libraries refuse are read. For child processes. Source:
// https://nifti.nimh.nih.gov/nifti-1 and /nifti-2, nifti1.h and nifti2.h.

/// What a header says, in its own units.
struct NiftiHeader {
  std::array<std::int64_t, 8> dim{};  ///< number of axes, and voxels along each
  int datatype = 0;                   ///< NIFTI_TYPE_…
  std::string type;                   ///< "uint16", ...; "" where values are no single real numbers
  int bytes_of_value = 0;             ///< of a stored one
  std::array<double, 8> pixdim{};     ///< qfac, and the spacing along each axis
  double slope = 0, intercept = 0;    ///< value = slope · stored + intercept, unless the slope is 0
  int units = 0;                      ///< of lengths: 1 m, 2 mm, 3 µm, 0 unknown
  int qform_code = 0, sform_code = 0;
  Vec3 quaternion = Vec3::Zero();                             ///< b, c, d
  Vec3 q_offset = Vec3::Zero();                               ///< position of voxel (0, 0, 0), RAS
  Eigen::Matrix<double, 3, 4> srow = decltype(srow)::Zero();  ///< rows of the sform: RAS from index
  bool is_analyze = false;                                    ///< without orientation
  bool swapped = false;                                       ///< the bytes of a number are in the other order
  std::string voxel_file;                                     ///< the header's own file, or the .img beside it
  std::int64_t offset = 0;                                    ///< of the first voxel in it, bytes
  std::vector<std::string> extensions;

  /// Numbers in each voxel, which dim[5] counts.
  [[nodiscard]] int layers() const { return dim[0] >= 5 ? static_cast<int>(dim[5]) : 1; }
  [[nodiscard]] bool is_scaled() const { return slope != 0 && (slope != 1 || intercept != 0); }
};

/// The header of a file; that of NAME.hdr for NAME.img. nullopt where the bytes are none of these formats. Throws
/// InputError where they are, and cut off or contradictory.
std::optional<NiftiHeader> read_nifti_header(const ForeignFile& file);

/// What the header says. Of sform and qform it takes the one in coordinates of the scanner (codes 1 and 2) before one
/// in those of a template (3 and more), then the sform before the qform, and warns where the other one, or pixdim,
/// places a voxel more than a tenth of a voxel elsewhere. Without both, spacings along left, posterior and superior,
/// with a warning. Throws InputError: no finite placement, no volume of single real numbers (of several with
/// `allow_layers`), larger than the memory.
ImageFacts facts_of(const NiftiHeader& header, const ForeignFile& file, bool allow_layers);

/// Whether the file of the voxels has all of them.
bool is_complete(const NiftiHeader& header);

/// Writes the values in `box` of a layer to `out`, scaled. Throws InputError: cut off.
void read_nifti_voxels(const NiftiHeader& header, const IndexBox& box, int layer, const ForeignFile& file, float* out);

/// Opens a folder of DICOM slices, or a multi-frame file (dicom_stack.cpp). Throws InputError: no DICOM, slices that do
/// not form a volume.
ScanSource open_dicom(const std::string& path, const CtSettings& settings, Diagnostics& report);

/// Opens a DICOM segmentation (SEG), or a folder with one (dicom_seg.cpp). Each segment is named by its label; its
/// value is its number. Throws InputError: no segmentation, several, damaged, frames that do not form a volume.
ScanSource open_dicom_seg(const ForeignFile& file, Diagnostics& report);

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

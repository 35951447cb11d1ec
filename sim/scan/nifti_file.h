// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scan/image_io.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

// NIfTI-1, NIfTI-2 and Analyze 7.5, compressed or not, read from their bytes: the geometry does not depend on the
// version of a library, and headers that libraries refuse are read. For child processes. Source:
// https://nifti.nimh.nih.gov/nifti-1 and /nifti-2, nifti1.h and nifti2.h.

/// What a header says, in its own units.
struct NiftiHeader {
  std::array<std::int64_t, 8> dim{};  ///< number of axes, and voxels along each
  int datatype = 0;                   ///< NIFTI_TYPE_…
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
std::optional<NiftiHeader> read_nifti_header(const std::string& path, const std::string& key);

/// "uint16", ...; "" for a type whose values are no single real numbers.
std::string type_of(const NiftiHeader& header);
/// Of a stored value.
int bytes_of_value(const NiftiHeader& header);

/// Where the voxels lie, in LPS mm, and what the header leaves open or contradicts.
struct NiftiPlacement {
  ScanGeometry geometry;
  std::string frame;  ///< "sform, scanner coordinates (code 1)"
  std::vector<std::string> warnings;
};

/// Of sform and qform the one in coordinates of the scanner (codes 1 and 2) before one in those of a template (3 and
/// more), then the sform before the qform. Warns where the other one, or pixdim, places a voxel more than a tenth of a
/// voxel elsewhere. Without both, spacings along left, posterior and superior, with a warning. Throws InputError where
/// no placement is finite.
NiftiPlacement placement_of(const NiftiHeader& header, const std::string& path, const std::string& key);

/// The header, checked against the file of the voxels, which is read to its end. Throws InputError: no volume of single
/// real numbers (of several with `allow_layers`), larger than the memory, cut off.
ImageFacts facts_of(const NiftiHeader& header, const std::string& path, const std::string& key, bool allow_layers);

/// Whether the file of the voxels has all of them.
bool is_complete(const NiftiHeader& header);

/// Writes the values in `box` of a layer to `out`, scaled. Throws InputError: cut off.
void read_nifti_voxels(const NiftiHeader& header, const IndexBox& box, int layer, const std::string& path,
                       const std::string& key, float* out);

}  // namespace reamsim::ct

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <itkImageIOBase.h>
#include <nifti1_io.h>
#include <memory>
#include <string>

#include "sim/scan/scan_transfer.h"

namespace reamsim::ct {

// What ITK reads otherwise than the format says, by version, and what a header leaves open. All after
// ReadImageInformation().

/// The geometry that ITK gives, mm in LPS, as the file means it: NRRD in the space left-anterior-superior or in one
/// with time, which versions of ITK convert differently, NRRD in other units than mm, and NIfTI in metres or
/// micrometres, whose origin ITK 5.4 converts and 5.2 does not.
ScanGeometry apply_format_conventions(const itk::ImageIOBase& io, ScanGeometry geometry);

/// What ITK adds to each value though the file says that values are not scaled: a NIfTI with a slope of 0.
double offset_in_error(const itk::ImageIOBase& io);

/// What the header leaves open. Orientation: NRRD without an anatomical space, NIfTI without qform and sform, Analyze.
/// ITK takes their axes as left, posterior, superior. Units: NRRD in units that are unknown, which are taken as mm.
HeaderGaps gaps_of(const itk::ImageIOBase& io);

/// Whether a part of the image can be read. ITK loses voxels of a part of a compressed MetaImage.
bool can_be_read_in_part(itk::ImageIOBase& io);

/// The header of a NIfTI file; freed with the pointer.
using NiftiHeader = std::unique_ptr<nifti_image, decltype(&nifti_image_free)>;

/// Null if missing.
inline NiftiHeader read_nifti_header(const std::string& path) {
  return {nifti_image_read(path.c_str(), 0), &nifti_image_free};
}

}  // namespace reamsim::ct

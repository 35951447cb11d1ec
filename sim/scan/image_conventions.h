// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <itkImageIOBase.h>
#include <string>

#include "sim/scan/scan_transfer.h"

namespace reamsim::ct {

// What ITK reads otherwise than the format says, by version, and what a header leaves open. All after
// ReadImageInformation().

/// The geometry that ITK gives, mm in LPS, as the file means it: NRRD in the space left-anterior-superior or in one
/// with time, which versions of ITK convert differently, and NRRD in other units than mm.
ScanGeometry apply_format_conventions(const itk::ImageIOBase& io, ScanGeometry geometry);

/// What in the header places the voxels, and warnings of what it leaves open. Orientation: NRRD without an anatomical
/// space; ITK takes the axes as left, posterior, superior. Units: NRRD in units that are unknown, which are taken as
/// mm.
void describe_header(const itk::ImageIOBase& io, ImageFacts& facts);

/// Throws InputError where the voxels of an NRRD are encoded in a way that ITK cannot read.
void check_encoding(const std::string& path, const std::string& key);

/// Whether a part of the image can be read. ITK loses voxels of a part of a compressed MetaImage.
bool can_be_read_in_part(itk::ImageIOBase& io);

}  // namespace reamsim::ct

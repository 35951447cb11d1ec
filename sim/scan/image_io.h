// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <itkImageIOBase.h>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/scan/scan.h"
#include "sim/scan/scan_transfer.h"

namespace reamsim::ct {

// Reading with ITK, for child processes. Private to sim/scan: only its sources include this header.

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

/// Opens a folder of DICOM slices, or a multi-frame file (dicom_scan.cpp). Throws InputError: no DICOM, slices that do
/// not form a volume.
std::unique_ptr<ScanSource> open_dicom(const std::string& path, const std::string& key, const DicomChoice& choice,
                                       Diagnostics& report);

/// Opens a DICOM segmentation (SEG), or a folder with one (dicom_seg.cpp). Each segment is named by its label; its
/// value is its number. Throws InputError: no segmentation, several, damaged, frames that do not form a volume.
std::unique_ptr<LabelSource> open_dicom_seg(const std::string& path, const std::string& key, Diagnostics& report);

}  // namespace reamsim::ct

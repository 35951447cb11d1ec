#pragma once

#include <itkImageIOBase.h>

#include <memory>
#include <string>
#include <vector>

#include "sim/bone/ct/scan.h"

namespace reamsim::ct {

// Private to sim/bone/ct: only its sources include this header, because it includes ITK.

/// Throws InputError when the header is damaged.
void read_header(itk::ImageIOBase& io, const std::string& path, const std::string& key, const std::string& format);

/// The geometry in the header. Throws InputError unless the image is a volume (or a slice with `allow_slice`) with one
/// value per voxel (or several with `allow_layers`).
ScanGeometry geometry_of(const itk::ImageIOBase& io, const std::string& path, const std::string& key, bool allow_slice,
                         bool allow_layers = false);

/// "int16", "float", ...
std::string pixel_type_of(const itk::ImageIOBase& io);

/// The values in `box` as floats, of one layer. Throws InputError: truncated, damaged.
std::vector<float> read_voxels(itk::ImageIOBase& io, const IndexBox& box, const std::string& path,
                               const std::string& key, int layer = 0);

/// Opens a folder of DICOM slices (dicom_stack.cpp). Throws InputError: no DICOM, slices that do not form a volume.
std::unique_ptr<ScanSource> open_dicom_folder(const std::string& path, const std::string& key,
                                              const DicomChoice& choice, Report& report);

}  // namespace reamsim::ct

#pragma once

#include <itkImageIOBase.h>

#include <memory>
#include <string>
#include <vector>

#include "sim/bone/ct/scan.h"

namespace reamsim::ct {

// Private to sim/bone/ct: the only headers of this folder that mention ITK are included by its sources alone.

/// The reader of one format, without ITK's global list of factories. `path` is what the messages name.
itk::ImageIOBase::Pointer open_image_io(const std::string& path, const std::string& key, std::string& format);

/// Reads the header. Throws InputError when it is damaged.
void read_header(itk::ImageIOBase& io, const std::string& path, const std::string& key, const std::string& format);

/// Geometry by the header. Throws InputError unless the image is a volume (or a slice, where `allow_slice`) of single
/// numbers (or of several, where `allow_layers`).
ScanGeometry geometry_of(const itk::ImageIOBase& io, const std::string& path, const std::string& key, bool allow_slice,
                         bool allow_layers = false);

/// "int16", "float", ...
std::string pixel_type_of(const itk::ImageIOBase& io);
bool has_unsigned_pixels(const itk::ImageIOBase& io);

/// The values of `box` as floats, the one at `layer` where voxels hold several. Throws InputError: truncated, damaged.
std::vector<float> read_voxels(itk::ImageIOBase& io, const IndexBox& box, const std::string& path,
                               const std::string& key, int layer = 0);

/// A folder of DICOM slices (dicom_scan.cpp). Throws InputError: no DICOM in it, slices that do not form a volume.
std::unique_ptr<ScanSource> open_dicom_folder(const std::string& path, const std::string& key,
                                              const DicomChoice& choice, Report& report);

}  // namespace reamsim::ct

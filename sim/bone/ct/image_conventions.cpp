// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/ct/image_conventions.h"

#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <cctype>
#include <sstream>
#include <string>

#include "sim/base/file.h"
#include "sim/bone/ct/nifti_header.h"

namespace reamsim::ct {

namespace {

/// Letters and digits in lower case.
std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) out += static_cast<char>(std::tolower(c));
  }
  return out;
}

/// The value of a field of an NRRD header; empty without it. Fields are written in any case; `space:=value` and
/// comments are none.
std::string nrrd_field(const std::string& path, const std::string& name) {
  constexpr std::size_t kMostBytes = 1 << 24;  // of a header, which may hold any texts
  std::istringstream header(read_file_start(path, kMostBytes));
  for (std::string line; std::getline(header, line) && !line.empty() && line != "\r";) {
    const std::size_t colon = line.starts_with('#') ? std::string::npos : line.find(": ");
    if (colon != std::string::npos && plain(line.substr(0, colon)) == plain(name)) return line.substr(colon + 2);
  }
  return "";
}

/// The space of an NRRD, plain(). ITK names the space into which it converted.
std::string nrrd_space(const std::string& path) {
  return plain(nrrd_field(path, "space"));
}

bool is_anatomical(const std::string& space) {
  return space.find("superior") != std::string::npos || space.starts_with("lps") || space.starts_with("ras") ||
         space.starts_with("las");
}

/// By what ITK's axes differ from LPS: of LAS it mirrors x instead of y, and spaces with time it leaves as they are.
Vec3 signs_of(const std::string& space) {
  if (space == "leftanteriorsuperior" || space == "las") return {-1, -1, 1};
  if (space == "leftanteriorsuperiortime" || space == "last") return {1, -1, 1};
  if (space == "rightanteriorsuperiortime" || space == "rast") return {-1, -1, 1};
  return Vec3::Ones();
}

/// Millimetres in a length unit of NRRD; 1 for mm and for an unknown unit.
double mm_of_unit(const std::string& unit) {
  if (unit == "m" || unit == "meter" || unit == "meters" || unit == "metre" || unit == "metres") return 1e3;
  if (unit == "cm" || unit == "centimeter" || unit == "centimeters") return 10;
  // µ is U+00B5 or the Greek letter U+03BC.
  if (unit == "um" || unit == "\xC2\xB5m" || unit == "\xCE\xBCm" || unit == "micron" || unit == "microns") return 1e-3;
  return 1;
}

/// Millimetres in the units of the axes of the space of an NRRD, of its field `space units`: "cm" "cm" "cm".
Vec3 mm_of_space_units(const std::string& path) {
  const std::string units = nrrd_field(path, "space units");
  Vec3 out = Vec3::Ones();
  std::size_t at = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t open = units.find('"', at);
    const std::size_t close = open == std::string::npos ? open : units.find('"', open + 1);
    if (close == std::string::npos) return out;
    out[axis] = mm_of_unit(units.substr(open + 1, close - open - 1));
    at = close + 1;
  }
  return out;
}

bool is_nrrd(const itk::ImageIOBase& io) {
  return dynamic_cast<const itk::NrrdImageIO*>(&io) != nullptr;
}
bool is_nifti(const itk::ImageIOBase& io) {
  return dynamic_cast<const itk::NiftiImageIO*>(&io) != nullptr;
}

double mm_of(int nifti_units) {
  return nifti_units == NIFTI_UNITS_METER ? 1e3 : nifti_units == NIFTI_UNITS_MICRON ? 1e-3 : 1.0;
}

}  // namespace

ScanGeometry as_the_file_means(const itk::ImageIOBase& io, ScanGeometry geometry) {
  if (is_nrrd(io)) {
    const Vec3 signs = signs_of(nrrd_space(io.GetFileName()));
    const Vec3 to_mm = signs.cwiseProduct(mm_of_space_units(io.GetFileName()));
    geometry.step_mm = to_mm.asDiagonal() * geometry.step_mm;
    geometry.origin_mm = to_mm.cwiseProduct(geometry.origin_mm);
  }
  if (is_nifti(io)) {
    if (const NiftiHeader header = read_nifti_header(io.GetFileName())) geometry.origin_mm *= mm_of(header->xyz_units);
  }
  return geometry;
}

double offset_in_error(const itk::ImageIOBase& io) {
  if (!is_nifti(io)) return 0;
  const NiftiHeader header = read_nifti_header(io.GetFileName());
  return header && header->scl_slope == 0 ? header->scl_inter : 0;
}

bool says_orientation(const itk::ImageIOBase& io) {
  if (is_nrrd(io)) return is_anatomical(nrrd_space(io.GetFileName()));
  if (!is_nifti(io)) return true;
  const NiftiHeader header = read_nifti_header(io.GetFileName());
  return header && (header->qform_code > 0 || header->sform_code > 0);
}

bool can_be_read_in_part(itk::ImageIOBase& io) {
  auto* meta = dynamic_cast<itk::MetaImageIO*>(&io);
  return meta == nullptr || !meta->GetMetaImagePointer()->CompressedData();
}

}  // namespace reamsim::ct

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/ct/image_conventions.h"

#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <string>

#include "sim/bone/ct/nifti_header.h"
#include "sim/bone/ct/nrrd_header.h"

namespace reamsim::ct {

namespace {

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

bool is_nrrd(const itk::ImageIOBase& io) {
  return dynamic_cast<const itk::NrrdImageIO*>(&io) != nullptr;
}
bool is_nifti(const itk::ImageIOBase& io) {
  return dynamic_cast<const itk::NiftiImageIO*>(&io) != nullptr;
}

double mm_of(int nifti_units) {
  return nifti_units == NIFTI_UNITS_METER ? 1e3 : nifti_units == NIFTI_UNITS_MICRON ? 1e-3 : 1.0;
}

/// Whether ITK gives the origin as one of the header's two transforms has it: in LPS, but in the unit of the file.
bool is_origin_of(const nifti_image& header, const Vec3& origin) {
  const auto stands_in = [&](const mat44& ras) {
    const Vec3 stored(-ras.m[0][3], -ras.m[1][3], ras.m[2][3]);
    return (origin - stored).norm() <= 1e-5 * stored.norm();
  };
  return stands_in(header.qto_xyz) || stands_in(header.sto_xyz);
}

}  // namespace

ScanGeometry as_the_file_means(const itk::ImageIOBase& io, ScanGeometry geometry) {
  if (is_nrrd(io)) {
    const NrrdHeader header = read_nrrd_header(io.GetFileName());
    const Vec3 to_mm = signs_of(header.space).cwiseProduct(header.to_mm);
    geometry.step_mm = to_mm.asDiagonal() * geometry.step_mm;
    geometry.origin_mm = to_mm.cwiseProduct(geometry.origin_mm);
  }
  if (is_nifti(io)) {
    const NiftiHeader header = read_nifti_header(io.GetFileName());
    if (header && is_origin_of(*header, geometry.origin_mm)) geometry.origin_mm *= mm_of(header->xyz_units);
  }
  return geometry;
}

double offset_in_error(const itk::ImageIOBase& io) {
  if (!is_nifti(io)) return 0;
  const NiftiHeader header = read_nifti_header(io.GetFileName());
  return header && header->scl_slope == 0 ? header->scl_inter : 0;
}

HeaderGaps gaps_of(const itk::ImageIOBase& io) {
  if (is_nrrd(io)) {
    const NrrdHeader header = read_nrrd_header(io.GetFileName());
    return {.says_orientation = is_anatomical(header.space), .unknown_unit = header.unknown_unit};
  }
  if (!is_nifti(io)) return {};
  const NiftiHeader header = read_nifti_header(io.GetFileName());
  return {.says_orientation = header && (header->qform_code > 0 || header->sform_code > 0)};
}

bool can_be_read_in_part(itk::ImageIOBase& io) {
  auto* meta = dynamic_cast<itk::MetaImageIO*>(&io);
  return meta == nullptr || !meta->GetMetaImagePointer()->CompressedData();
}

}  // namespace reamsim::ct

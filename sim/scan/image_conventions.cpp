// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/image_conventions.h"

#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <map>
#include <optional>
#include <string>

#include "sim/scan/nifti_header.h"
#include "sim/scan/nrrd_header.h"

namespace reamsim::ct {

namespace {

/// The signs that take coordinates of an anatomical space to LPS; nullopt for other spaces.
std::optional<Vec3> lps_from(const std::string& space) {
  static const std::map<std::string, Vec3> kSpaces{{"leftposteriorsuperior", {1, 1, 1}},
                                                   {"lps", {1, 1, 1}},
                                                   {"rightanteriorsuperior", {-1, -1, 1}},
                                                   {"ras", {-1, -1, 1}},
                                                   {"las", {1, -1, 1}},
                                                   {"leftanteriorsuperior", {1, -1, 1}}};
  std::string name = space;
  if (name.ends_with("time")) name.resize(name.size() - 4);
  if (name.size() == 4 && name.ends_with("t")) name.resize(3);
  const auto found = kSpaces.find(name);
  return found == kSpaces.end() ? std::nullopt : std::optional(found->second);
}

/// A named space without directions does not say how the axes lie in it.
bool says_orientation(const NrrdHeader& header) {
  return lps_from(header.space).has_value() && header.directions.size() >= 3;
}

/// The signs that take ITK's axes to LPS. Versions of ITK convert different spaces, some wrongly; comparing their
/// result with the directions in the header shows what this version did.
Vec3 signs_of(const NrrdHeader& header, const Mat3& steps_of_itk) {
  const std::optional<Vec3> wanted = lps_from(header.space);
  if (!says_orientation(header)) return Vec3::Ones();
  Vec3 out = *wanted;
  for (int row = 0; row < 3; ++row) {
    double along = 0;
    for (int axis = 0; axis < 3; ++axis) {
      along += steps_of_itk(row, axis) * header.directions[static_cast<std::size_t>(axis)][row];
    }
    if (along < 0) out[row] = -out[row];
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

/// Whether ITK's origin (LPS) is that of the qform or the sform without conversion from the unit of the file to mm.
bool is_origin_of(const nifti_image& header, const Vec3& origin) {
  const auto stands_in = [&](const mat44& ras) {
    const Vec3 stored(-ras.m[0][3], -ras.m[1][3], ras.m[2][3]);
    return (origin - stored).norm() <= 1e-5 * stored.norm();
  };
  return stands_in(header.qto_xyz) || stands_in(header.sto_xyz);
}

}  // namespace

ScanGeometry apply_format_conventions(const itk::ImageIOBase& io, ScanGeometry geometry) {
  if (is_nrrd(io)) {
    const NrrdHeader header = read_nrrd_header(io.GetFileName());
    const Vec3 to_mm = signs_of(header, geometry.step_mm).cwiseProduct(header.to_mm);
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
    return {.says_orientation = says_orientation(header), .unknown_unit = header.unknown_unit};
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

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "sim/scan/image_io.h"
#include "sim/scan/segment.h"

namespace reamsim::ct {

namespace {

/// Of a voxel: larger distances between two placements are worth a warning.
constexpr double kWorthWarning_voxels = 0.1;

double mm_of_unit(int units) {
  constexpr int kMetre = 1, kMicron = 3;
  return units == kMetre ? 1e3 : units == kMicron ? 1e-3 : 1.0;
}

/// Coordinates of a template count after those of the scanner.
bool is_of_template(int code) {
  constexpr int kTalairach = 3;
  return code >= kTalairach;
}

/// The geometry of a transform from indices to RAS in the unit of the file.
ScanGeometry geometry_of(const NiftiHeader& header, const Mat3& steps, const Vec3& origin) {
  const Vec3 to_lps_mm = mm_of_unit(header.units) * Vec3(-1, -1, 1);
  ScanGeometry out;
  for (std::size_t axis = 0; axis < 3; ++axis)
    out.dims[static_cast<int>(axis)] = static_cast<int>(header.dim[axis + 1]);
  out.step_mm = to_lps_mm.asDiagonal() * steps;
  out.origin_mm = to_lps_mm.cwiseProduct(origin);
  return out;
}

Vec3 spacing_of(const NiftiHeader& header) {
  return {header.pixdim[1], header.pixdim[2], header.pixdim[3]};
}

/// The rotation of the qform: a quaternion of which b, c and d are stored, and a reflection of the third axis.
Mat3 rotation_of(const NiftiHeader& header) {
  const Vec3 v = header.quaternion;
  const double a2 = 1 - v.squaredNorm();
  // A sum of squares above 1 by rounding, as nifti1_io.c treats it.
  Quat q = a2 < 1e-7 ? Quat(0, v.x(), v.y(), v.z()).normalized() : Quat(std::sqrt(a2), v.x(), v.y(), v.z());
  Mat3 out = q.toRotationMatrix();
  if (header.pixdim[0] < 0) out.col(2) = -out.col(2);
  return out;
}

/// A placement that the header has.
struct Form {
  ScanGeometry geometry;
  std::string name;
  int code = 0;
};

Form form_of(const NiftiHeader& header, const char* form, int code, const Mat3& steps, const Vec3& origin) {
  const char* of = code == 1   ? "scanner coordinates"
                   : code == 2 ? "coordinates aligned to another scan"
                   : code == 3 ? "Talairach coordinates"
                   : code == 4 ? "MNI 152 coordinates"
                               : "coordinates of a template";
  return {geometry_of(header, steps, origin), fmt::format("{} (code {}, {})", form, code, of), code};
}

/// The largest distance between the places that two geometries give a voxel, mm.
double largest_distance_mm(const ScanGeometry& a, const ScanGeometry& b) {
  const Aabb centers{Vec3::Zero(), a.dims.cast<double>() - Vec3::Ones()};
  double out = 0;
  for (int corner = 0; corner < 8; ++corner) {
    out = std::max(out, (a.point_mm(centers.corner(corner)) - b.point_mm(centers.corner(corner))).norm());
  }
  return out;
}

std::string text_of(const Vec3& spacing_mm) {
  return fmt::format("{:.5g} x {:.5g} x {:.5g} mm", spacing_mm.x(), spacing_mm.y(), spacing_mm.z());
}

/// Warns where pixdim has other spacings than the columns of the sform.
void compare_with_pixdim(const NiftiHeader& header, const Form& form, std::vector<std::string>& warnings) {
  const Vec3 stated = mm_of_unit(header.units) * spacing_of(header), found = form.geometry.spacing_mm();
  const Vec3 extent = form.geometry.dims.cast<double>();
  const Vec3 apart_voxels = (stated - found).cwiseAbs().cwiseProduct(extent).cwiseQuotient(found);
  if (apart_voxels.maxCoeff() <= kWorthWarning_voxels) return;
  warnings.push_back(
      fmt::format("the NIfTI header contradicts itself: pixdim says voxels of {}, the columns of the sform "
                  "say {}, which are taken. Check the size of the bone",
                  text_of(stated), text_of(found)));
}

void compare(const Form& taken, const Form& other, std::vector<std::string>& warnings) {
  const double apart_mm = largest_distance_mm(taken.geometry, other.geometry);
  if (!(apart_mm > kWorthWarning_voxels * taken.geometry.spacing_mm().minCoeff())) return;
  warnings.push_back(
      fmt::format("the NIfTI header contradicts itself: {} and {} differ by up to {:.3g} mm; the {} is "
                  "taken. Check side and orientation of the bone",
                  taken.name, other.name, apart_mm, taken.name.substr(0, 5)));
}

/// Leaves out a form that no image can have, with a warning.
void leave_out_damaged(std::optional<Form>& form, std::vector<std::string>& warnings) {
  if (!form || form->geometry.is_valid()) return;
  warnings.push_back(
      fmt::format("the {} of the NIfTI header is not finite, zero or degenerate, and is not used", form->name));
  form.reset();
}

void place_by_spacing(const NiftiHeader& header, const ForeignFile& file, ImageFacts& out) {
  // As ITK reads such files.
  out.geometry = geometry_of(header, Vec3(-1, -1, 1).cwiseProduct(spacing_of(header)).asDiagonal(), Vec3::Zero());
  out.frame = "no orientation in the header";
  out.warnings.emplace_back(kNoOrientation);
  if (out.geometry.is_valid()) return;
  throw file.error("the spacing of the voxels (pixdim) in the NIfTI header is zero, not finite or degenerate",
                   "the file is damaged: export it again");
}

/// Sets where the voxels lie, in LPS mm, and what the header leaves open or contradicts.
void place(const NiftiHeader& header, const ForeignFile& file, ImageFacts& out) {
  std::optional<Form> sform, qform;
  if (header.sform_code > 0) {
    sform = form_of(header, "sform", header.sform_code, header.srow.leftCols<3>(), header.srow.col(3));
  }
  if (header.qform_code > 0) {
    const Mat3 steps = rotation_of(header) * spacing_of(header).asDiagonal();
    qform = form_of(header, "qform", header.qform_code, steps, header.q_offset);
  }
  if (!sform && !qform) return place_by_spacing(header, file, out);
  leave_out_damaged(sform, out.warnings);
  leave_out_damaged(qform, out.warnings);
  if (!sform && !qform) {
    throw file.error("the axes or the origin in the NIfTI header (sform, qform) are not finite, zero or degenerate",
                     "the file is damaged: export it again");
  }
  const bool takes_qform = qform && (!sform || (is_of_template(sform->code) && !is_of_template(qform->code)));
  const Form& taken = takes_qform ? *qform : *sform;
  if (!takes_qform) compare_with_pixdim(header, taken, out.warnings);
  if (sform && qform) compare(taken, takes_qform ? *sform : *qform, out.warnings);
  out.geometry = taken.geometry;
  out.frame = taken.name;
}

}  // namespace

ImageFacts facts_of(const NiftiHeader& header, const ForeignFile& file, bool allow_layers) {
  std::vector<std::int64_t> sizes(header.dim.begin() + 1, header.dim.begin() + 1 + header.dim[0]);
  if (allow_layers && sizes.size() >= 5) sizes[4] = 1;
  check_volume(sizes, file);
  ImageFacts out;
  out.format = header.is_analyze ? "Analyze" : "NIfTI";
  out.pixel_type = header.type;
  if (out.pixel_type.empty()) {
    throw file.error(fmt::format("values of NIfTI datatype {}, which are no single real numbers", header.datatype),
                     "expected one integer or real number (HU) in each voxel");
  }
  place(header, file, out);
  out.layers = header.layers();
  out.bytes_per_voxel = double(header.bytes_of_value) * out.layers;
  check_fits_in_memory(static_cast<double>(out.geometry.size()), out.bytes_per_voxel, file);
  if (allow_layers) out.segments = segments_of_nifti(header.extensions);
  return out;
}

}  // namespace reamsim::ct

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <map>
#include <utility>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scan/image_io.h"
#include "sim/scan/segment.h"

namespace reamsim::ct {

namespace {

/// What ITK leaves out of the header of an NRRD, or converts by rules that differ between its versions.
struct NrrdHeader {
  std::string space = {};             ///< as written. ITK names the space into which it converted
  std::vector<Vec3> directions = {};  ///< of the axes that have one, in the space and its units
  Vec3 to_mm = Vec3::Ones();          ///< millimetres in the length unit of each axis of the space
  std::string unknown_unit = {};      ///< the first that is no known length unit, taken as mm; empty: none
};

/// Letters and digits in lower case.
std::string plain(const std::string& text) {
  std::string out;
  std::ranges::copy_if(lower_case(text), std::back_inserter(out), [](unsigned char c) { return std::isalnum(c) != 0; });
  return out;
}

/// The fields of a header by plain() name; the first counts. `space:=value` and comments are none.
std::map<std::string, std::string> fields_of(const std::string& path) {
  std::map<std::string, std::string> out;
  constexpr std::size_t kMostBytes = 1 << 22;  // of a header, which may hold any texts; voxels follow its blank line
  std::istringstream header(read_file_start(path, kMostBytes));
  for (std::string line; std::getline(header, line) && !line.empty() && line != "\r";) {
    const std::size_t colon = line.starts_with('#') ? std::string::npos : line.find(": ");
    if (colon != std::string::npos) out.try_emplace(plain(line.substr(0, colon)), line.substr(colon + 2));
  }
  return out;
}

/// The texts between quotation marks, without the blanks around them.
std::vector<std::string> quoted_in(const std::string& text) {
  std::vector<std::string> out;
  const std::vector<std::string> parts = split(text, '"');
  for (std::size_t n = 1; n + 1 < parts.size(); n += 2) out.emplace_back(without_blanks(parts[n], " "));
  return out;
}

/// The units of the axes of the space, without those of the values of a voxel, such as layers.
std::vector<std::string> of_space_axes(const std::vector<std::string>& units, const std::string& kinds) {
  static constexpr std::array kOfSpace{"space", "domain", "time", "none", "???"};
  std::istringstream in(kinds);
  std::vector<std::string> out;
  for (const std::string& unit : units) {
    std::string kind;
    if (!(in >> kind) || std::ranges::find(kOfSpace, lower_case(kind)) != kOfSpace.end()) out.push_back(unit);
  }
  return out;
}

/// Millimetres in a length unit; 0 for an unknown one. The standard has no list of units.
double mm_of_unit(const std::string& unit) {
  static const std::vector<std::pair<double, std::vector<std::string>>> kUnits{
      {1, {"", "mm", "millimeter", "millimeters", "millimetre", "millimetres"}},
      {10, {"cm", "centimeter", "centimeters", "centimetre", "centimetres"}},
      {1e3, {"m", "meter", "meters", "metre", "metres"}},
      {1e-3, {"um", "micrometer", "micrometers", "micrometre", "micrometres", "micron", "microns"}},
      {1e-3, {"\xC2\xB5m", "\xCE\xBCm"}},  // µ is U+00B5 or the Greek letter U+03BC
      {25.4, {"in", "inch", "inches"}}};
  const std::string name = lower_case(unit);
  for (const auto& [mm, names] : kUnits) {
    if (std::ranges::find(names, name) != names.end()) return mm;
  }
  return 0;
}

/// The units of the axes of the space. Axes with a direction have those of the space, others their own.
std::vector<std::string> space_units(std::map<std::string, std::string>& fields) {
  const std::vector<std::string> own = of_space_axes(quoted_in(fields["units"]), fields["kinds"]);
  const std::vector<std::string> of_space = quoted_in(fields["spaceunits"]);
  return fields.contains("spacedirections") || own.empty() ? of_space : own;
}

/// The vectors "(x,y,z)" of a text; others, such as "none", are left out.
std::vector<Vec3> vectors_in(const std::string& text) {
  std::vector<Vec3> out;
  for (std::size_t open = text.find('('); open != std::string::npos; open = text.find('(', open + 1)) {
    Vec3 v = Vec3::Zero();
    const char* at = text.c_str() + open + 1;
    for (double& value : v.reshaped()) {
      char* end = nullptr;
      value = std::strtod(at, &end);
      at = *end == ',' ? end + 1 : end;
    }
    out.push_back(v);
  }
  return out;
}

NrrdHeader read_nrrd_header(const std::string& path) {
  std::map<std::string, std::string> fields = fields_of(path);
  const std::vector<std::string> units = space_units(fields);
  const std::string& space = fields["space"];
  NrrdHeader out{.space = space.substr(0, space.find_last_not_of(" \t\r") + 1),
                 .directions = vectors_in(fields["spacedirections"])};
  for (std::size_t axis = 0; axis < std::min<std::size_t>(units.size(), 3); ++axis) {
    const double mm = mm_of_unit(units[axis]);
    if (mm > 0) {
      out.to_mm[static_cast<Eigen::Index>(axis)] = mm;
    } else if (out.unknown_unit.empty()) {
      out.unknown_unit = units[axis];
    }
  }
  return out;
}

/// The signs that take coordinates of an anatomical space to LPS; nullopt for other spaces.
std::optional<Vec3> lps_from(const std::string& space) {
  static const std::map<std::string, Vec3> kSpaces{{"leftposteriorsuperior", {1, 1, 1}},
                                                   {"lps", {1, 1, 1}},
                                                   {"rightanteriorsuperior", {-1, -1, 1}},
                                                   {"ras", {-1, -1, 1}},
                                                   {"las", {1, -1, 1}},
                                                   {"leftanteriorsuperior", {1, -1, 1}}};
  std::string name = plain(space);
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

/// Of a voxel: larger distances between two placements are worth a warning.
constexpr double kWorthWarning_voxels = 0.1;

double mm_of_unit(int units) {
  constexpr int kMetre = 1, kMicron = 3;
  return units == kMetre ? 1e3 : units == kMicron ? 1e-3 : 1.0;
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
  constexpr int kTalairach = 3;  // from here on, coordinates of a template, which count after those of the scanner
  const bool takes_qform = qform && (!sform || (sform->code >= kTalairach && qform->code < kTalairach));
  const Form& taken = takes_qform ? *qform : *sform;
  if (!takes_qform) compare_with_pixdim(header, taken, out.warnings);
  if (sform && qform) compare(taken, takes_qform ? *sform : *qform, out.warnings);
  out.geometry = taken.geometry;
  out.frame = taken.name;
}

}  // namespace

bool is_nrrd(const itk::ImageIOBase& io) {
  return dynamic_cast<const itk::NrrdImageIO*>(&io) != nullptr;
}

void apply_conventions(const itk::ImageIOBase& io, ImageFacts& facts) {
  facts.frame = "TransformMatrix, taken as LPS";
  if (!is_nrrd(io)) return;
  const NrrdHeader header = read_nrrd_header(io.GetFileName());
  const Vec3 to_mm = signs_of(header, facts.geometry.step_mm).cwiseProduct(header.to_mm);
  facts.geometry.step_mm = to_mm.asDiagonal() * facts.geometry.step_mm;
  facts.geometry.origin_mm = to_mm.cwiseProduct(facts.geometry.origin_mm);
  constexpr std::size_t kLongestUnit = 40;
  if (!header.unknown_unit.empty()) {
    facts.warnings.push_back(
        "lengths are in \"" + header.unknown_unit.substr(0, kLongestUnit) +
        "\", an unknown unit; mm are assumed. Check the size of the scan, or export the file in mm");
  }
  facts.frame = "space " + header.space;
  if (says_orientation(header)) return;
  facts.frame = "no orientation in the header";
  facts.warnings.emplace_back(kNoOrientation);
}

void check_encoding(const ForeignFile& file) {
  static constexpr std::array kKnown{"raw", "txt", "text", "ascii", "hex", "gz", "gzip", ""};
  const std::string encoding = plain(fields_of(file.path)["encoding"]);
  if (std::ranges::find(kKnown, encoding) != kKnown.end()) return;
  throw file.error("the voxels are encoded as " + printable(encoding) + ", which this program cannot read",
                   "save the file as raw or gzip (3D Slicer, or unu save -f nrrd -e gzip)");
}

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

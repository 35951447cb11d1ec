// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fcntl.h>
#include <itkNrrdImageIO.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <iterator>
#include <sstream>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scan/image_io.h"

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
  for (std::size_t at = 0;;) {
    const std::size_t open = text.find('"', at);
    const std::size_t close = open == std::string::npos ? open : text.find('"', open + 1);
    if (close == std::string::npos) return out;
    out.emplace_back(without_blanks(std::string_view(text).substr(open + 1, close - open - 1), " "));
    at = close + 1;
  }
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

QuietLibraries::QuietLibraries()
    : cerr_(std::cerr.rdbuf(captured_.rdbuf())), cout_(std::cout.rdbuf(captured_.rdbuf())) {
  std::fflush(stderr);
  stderr_ = dup(STDERR_FILENO);
  const int null_device = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (stderr_ >= 0 && null_device >= 0) dup2(null_device, STDERR_FILENO);
  if (null_device >= 0) close(null_device);
}

QuietLibraries::~QuietLibraries() {
  std::fflush(stderr);
  if (stderr_ >= 0) {
    dup2(stderr_, STDERR_FILENO);
    close(stderr_);
  }
  std::cout.rdbuf(cout_);
  std::cerr.rdbuf(cerr_);
}

bool QuietLibraries::reports_missing_voxels() const {
  constexpr std::array<const char*, 3> kMessages{"data not read completely", "Uncompress failed",
                                                 "Incomplete Pixel Data"};
  const std::string output = captured_.str();
  return std::ranges::any_of(kMessages, [&](const char* text) { return output.find(text) != std::string::npos; });
}

}  // namespace reamsim::ct

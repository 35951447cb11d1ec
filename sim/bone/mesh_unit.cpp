// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/mesh_unit.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/base/error.h"
#include "sim/mesh/mesh_io.h"

namespace reamsim {

namespace {

struct LengthRange {
  double least_mm;
  double most_mm;

  [[nodiscard]] bool contains(double mm) const { return mm >= least_mm && mm <= most_mm; }
};

/// From an isolated glenoid to a long bone with a glenoid.
constexpr LengthRange kBoneWithGlenoid{20, 400};
/// Without a glenoid frame; beyond this the unit is probably wrong.
constexpr LengthRange kAnySolid{10, 400};
/// Superior to inferior, of an adult; for the estimate of a scale if no unit fits.
constexpr double kScapula_mm = 150;
constexpr LengthRange kScapulas{100, 220};
constexpr const char* kSetScale = "set bone.mesh.scale";

double length_of(const Aabb& bounds) {
  return (bounds.max - bounds.min).maxCoeff();
}

struct UnitOfLength {
  const char* name;
  double mm;
};
constexpr std::array kUnits{UnitOfLength{"metres", 1000}, UnitOfLength{"centimetres", 10}, UnitOfLength{"inches", 25.4},
                            UnitOfLength{"micrometres", 0.001}};

/// The units for which the length lies in the range, sorted by the similarity to a scapula.
std::vector<UnitOfLength> units_that_fit(double file_length, const LengthRange& range) {
  std::vector<UnitOfLength> out;
  std::ranges::copy_if(kUnits, std::back_inserter(out),
                       [&](const UnitOfLength& unit) { return range.contains(unit.mm * file_length); });
  const auto distance = [&](const UnitOfLength& unit) {
    return std::abs(std::log(unit.mm * file_length / kScapula_mm));
  };
  std::ranges::sort(out, {}, distance);
  return out;
}

/// The scales that would fit, the most likely first: that of a unit, or else the estimate from a scapula.
std::string scale_advice(double file_length, const std::string& what_to_set) {
  std::vector<std::string> scales;
  const std::vector<UnitOfLength> units = units_that_fit(file_length, kBoneWithGlenoid);
  for (const UnitOfLength& unit : units) {
    scales.push_back(fmt::format("{:g} if the file is in {} ({:.0f} mm)", unit.mm, unit.name, unit.mm * file_length));
  }
  const std::string estimate =
      fmt::format("about {:.2g} for a scapula of {:.0f} mm", kScapula_mm / file_length, kScapula_mm);
  const bool unit_is_likely = !units.empty() && kScapulas.contains(units.front().mm * file_length);
  scales.insert(unit_is_likely ? scales.end() : scales.begin(), estimate);
  std::string out = what_to_set + ": ";
  for (std::size_t n = 0; n < scales.size(); ++n) {
    out += (n == 0 ? "" : n + 1 < scales.size() ? ", " : " or ") + scales[n];
  }
  return out;
}

void require_length(const std::string& path, double length_mm, double scale, const std::string& what_to_set) {
  if (kBoneWithGlenoid.contains(length_mm)) return;
  throw InputError(
      {path, 0, 0}, "bone.mesh.scale",
      fmt::format("the mesh is {:.3g} mm long, expected {:.0f} to {:.0f} mm for a bone with a glenoid frame", length_mm,
                  kBoneWithGlenoid.least_mm, kBoneWithGlenoid.most_mm),
      scale_advice(length_mm / scale, what_to_set));
}

}  // namespace

std::optional<FoundScale> find_scale(double file_length) {
  const FoundScale in_mm{.scale = 1, .unit = "mm", .length_mm = file_length};
  if (kScapulas.contains(file_length)) return in_mm;
  if (kBoneWithGlenoid.contains(file_length)) {
    FoundScale out = in_mm;
    out.assumed = true;
    return out;
  }
  const std::vector<UnitOfLength> units = units_that_fit(file_length, kScapulas);
  if (units.size() != 1) return std::nullopt;
  return FoundScale{.scale = units.front().mm, .unit = units.front().name, .length_mm = units.front().mm * file_length};
}

FoundScale find_scale_of(const std::string& path, const std::string& what_to_set) {
  const double length = length_of(read_mesh(path, 1).bounds());
  if (const auto found = find_scale(length)) return *found;
  throw InputError({path, 0, 0}, "bone.mesh.scale",
                   fmt::format("the mesh is {:.3g} long, in a unit that is unknown", length),
                   scale_advice(length, what_to_set));
}

void require_scale(const std::string& path, double scale, const std::string& what_to_set) {
  require_length(path, length_of(read_mesh(path, scale).bounds()), scale, what_to_set);
}

bool is_likely_length(const Aabb& bounds_mm) {
  return kAnySolid.contains(length_of(bounds_mm));
}

void check_mesh_unit(const std::string& path, const Aabb& bounds_mm, double scale, bool has_glenoid,
                     Diagnostics& report) {
  const double length_mm = length_of(bounds_mm);
  if (has_glenoid) return require_length(path, length_mm, scale, kSetScale);
  if (is_likely_length(bounds_mm)) return;
  report.warn(fmt::format("{}: the mesh is {:.3g} mm long; if that is wrong, {}", path, length_mm,
                          scale_advice(length_mm / scale, kSetScale)));
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/reforce.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <tuple>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/engine/common/tables.h"
#include "sim/record/force_log.h"
#include "sim/record/recorder.h"
#include "sim/record/result_json.h"
#include "sim/record/summary.h"

namespace reamsim {

namespace {

Vec3 vector_of(const float* values) {
  return {double{values[0]}, double{values[1]}, double{values[2]}};
}

}  // namespace

double Recalibration::density(int grade) const {
  return now.density_from_hu(
      of_run.hu_from_density(DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade))));
}

ForceConstants force_constants(const CuttingSettings& cutting, const std::optional<Recalibration>& recalibration) {
  ForceConstants out;
  for (int grade = 1; grade <= DensityMapping::kMaxGrade; ++grade) {
    const double density = recalibration ? recalibration->density(grade)
                                         : DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade));
    out.specific_energy_n_mm2[static_cast<std::size_t>(grade)] = cutting_energy_mj(cutting, density, 1);
  }
  out.normal_ratio = cutting.normal_ratio;
  if (const auto& edge = cutting.edge_force) {
    out.edge_tangential_n_mm = edge->tangential_n_mm;
    out.edge_normal_n_mm = edge->normal_n_mm;
  }
  return out;
}

std::span<const BasisRow> ForceBasis::of(std::int64_t frame) const {
  const auto begin = std::ranges::lower_bound(rows_, frame, {}, &BasisRow::frame);
  return {begin, std::ranges::upper_bound(begin, rows_.end(), frame, {}, &BasisRow::frame)};
}

FrameForces ForceBasis::forces(std::int64_t frame, const ForceConstants& constants) const {
  FrameForces out;
  for (const BasisRow& row : of(frame)) {
    const bool edge = row.grade == 0;
    const double u =
        edge ? constants.edge_tangential_n_mm : constants.specific_energy_n_mm2[static_cast<std::size_t>(row.grade)];
    const double normal = edge ? constants.edge_normal_n_mm : u * constants.normal_ratio;
    out.force_n += u * vector_of(row.p_mm2) + normal * vector_of(row.n_mm2);
    out.torque_nmm += u * vector_of(row.p_torque_mm3) + normal * vector_of(row.n_torque_mm3);
    out.work_mj += u * double{row.p_work_mm3} + normal * double{row.n_work_mm3};
    out.energy_mj += u * double{row.energy_mm3};
    out.floor_energy_mj += u * double{row.floor_energy_mm3};
  }
  return out;
}

std::array<double, 256> ForceBasis::volume_mm3() const {
  std::array<double, 256> out{};
  for (const BasisRow& row : rows_) {
    if (row.grade > 0) out[static_cast<std::size_t>(row.grade)] += double{row.energy_mm3};
  }
  return out;
}

namespace {

DensityMapping mapping_of(const DensitySettings& density) {
  return {density.ash_slope_g_cm3_per_hu, density.ash_offset_g_cm3, density.ash_fraction};
}

bool same_calibration(const DensitySettings& a, const DensitySettings& b) {
  const auto values = [](const DensitySettings& d) {
    return std::array{d.ash_slope_g_cm3_per_hu, d.ash_offset_g_cm3, d.ash_fraction};
  };
  return values(a) == values(b);
}

double voxel_of(const std::string& dir) {
  const std::string path = dir + "/summary.json";
  const auto json = parse_result_json(read_file(path, "the summary of a run"));
  const bool has = json.is_object() && json.contains("bone") && json["bone"].is_object() &&
                   json["bone"].contains("voxel_mm") && json["bone"]["voxel_mm"].is_number();
  if (!has || !(json["bone"]["voxel_mm"].get<double>() > 0)) {
    throw InputError({path, 0, 0}, "bone.voxel_mm", "missing or not positive",
                     "expected a file written by `reamsim run`");
  }
  return json["bone"]["voxel_mm"].get<double>();
}

[[noreturn]] void fail_for(const std::string& key, const std::string& why) {
  throw InputError({}, "--set", key + " is part of the force basis" + why, "run the scenario again with it");
}

bool same_size_effect(const CuttingSettings& a, const CuttingSettings& b) {
  const auto values = [](const SizeEffectSettings& s) {
    return std::tuple(s.exponent, s.reference_mm, s.cutting_edges, s.least_mm, s.most_mm);
  };
  const auto &was = a.size_effect, &is = b.size_effect;
  return was.has_value() == is.has_value() && (!was || values(*was) == values(*is));
}

/// Throws InputError where the basis does not hold for `is`.
void require_linear(const CuttingSettings& was, const CuttingSettings& is) {
  if (was.law != is.law) fail_for("cutting.law", "");
  if (was.erosion != is.erosion) fail_for("cutting.erosion", "");
  if (was.speed_floor_mm_s != is.speed_floor_mm_s) fail_for("cutting.speed_floor_mm_s", "");
  if (!same_size_effect(was, is)) fail_for("cutting.size_effect", ", and forces are not linear in it");
  if (is.edge_force && !was.edge_force) {
    throw InputError({}, "--set", "cutting.edge_force: the run had no edge force, so that its basis has no part for it",
                     "run the scenario again with it");
  }
  if (is.edge_force && is.edge_force->cutting_edges != was.edge_force->cutting_edges)
    fail_for("cutting.edge_force.cutting_edges", "");
}

}  // namespace

BasisRun open_basis_run(const std::string& dir) {
  LawSettings law = parse_law_settings(dir + "/scenario.yaml");
  if (!law.force_basis) {
    throw InputError({dir + "/scenario.yaml", 0, 0}, "output.force_basis", "is false: the run has no force basis",
                     "run the scenario again with --set output.force_basis=true");
  }
  return {dir, std::move(law), ForceBasis(read_force_basis(dir + "/" + kForceBasisName)), voxel_of(dir)};
}

LawSettings changed_law(const BasisRun& run, const std::vector<std::string>& overrides) {
  LawSettings law = parse_law_settings(run.dir + "/scenario.yaml", overrides);
  require_linear(run.law.cutting, law.cutting);
  if (!same_calibration(run.law.density, law.density) && law.bone_source != "ct") {
    throw InputError({}, "--set", "bone.density: the bone is a " + law.bone_source + ", whose densities are given",
                     "change the relation from HU to density of a run on a CT only");
  }
  return law;
}

std::optional<Recalibration> recalibration(const BasisRun& run, const LawSettings& law) {
  if (same_calibration(run.law.density, law.density)) return std::nullopt;
  return Recalibration{mapping_of(run.law.density), mapping_of(law.density)};
}

ClampedVolume clamped_volume(const BasisRun& run, const std::optional<Recalibration>& recalibration) {
  ClampedVolume out;
  const std::array<double, 256> volume = run.basis.volume_mm3();
  for (std::size_t grade = 1; grade < volume.size(); ++grade) {
    out.whole_mm3 += volume[grade];
    const int g = static_cast<int>(grade);
    if (g == DensityMapping::kMaxGrade) {
      out.at_most_mm3 += volume[grade];
    } else if (recalibration && recalibration->density(g) >= DensityMapping::kMaxDensity_g_cm3) {
      out.beyond_mm3 += volume[grade];
    }
  }
  return out;
}

namespace {

/// Calls visit() with every row of the run's forces.csv, with the forces of other constants.
template <class Visit>
void for_each_reforced(const BasisRun& run, const ForceConstants& constants, const Visit& visit) {
  const std::vector<std::string_view> columns = csv_cells(kForceColumns);
  CsvReader log(run.dir + "/forces.csv", columns, "the log of a run");
  double work_mj = 0, floor_mj = 0, cut_mj = 0;
  for (std::vector<double> row; log.next(row);) {
    FrameResult result = result_of(row, log.where());
    const FrameForces now = run.basis.forces(result.frame, constants);
    work_mj += now.work_mj;
    floor_mj += now.floor_energy_mj;
    cut_mj += now.energy_mj;
    result.force_n = now.force_n;
    result.torque_nmm = now.torque_nmm;
    result.energy_mj = now.energy_mj;
    result.floor_energy_mj = now.floor_energy_mj;
    result.balance = cut_mj > 0 ? (work_mj + floor_mj - cut_mj) / cut_mj : 0;
    const Vec3 tool_z = result.pose.orientation * Vec3::UnitZ();
    result.axial_force_n = result.force_n.dot(tool_z);
    result.spin_torque_nmm = result.torque_nmm.dot(tool_z);
    visit(result);
  }
}

}  // namespace

RunTotals write_reforced(const BasisRun& run, const LawSettings& law, const std::string& to) {
  const ForceConstants constants = force_constants(law.cutting, recalibration(run, law));
  RunTotals totals(run.voxel_mm);
  // Under another name until it is complete, because the rows are read from a file that this one may replace.
  const std::string path = to + "/forces.csv.tmp";
  {
    CsvWriter forces(path, kForceColumns);
    for_each_reforced(run, constants, [&](const FrameResult& result) {
      forces.row(force_row(result));
      totals.add(result);
    });
    forces.sync();
    forces.close();
  }
  const std::string summary = reforced_summary(run.dir, law.cutting, totals);
  replace_file(to + "/forces.csv", read_file(path, "the forces"));
  std::filesystem::remove(path);
  replace_file(to + "/scenario.yaml", law.yaml);
  replace_file(to + "/summary.json", summary);
  return totals;
}

}  // namespace reamsim

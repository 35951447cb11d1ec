// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/reforce.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/engine/common/tables.h"
#include "sim/record/force_log.h"
#include "sim/record/recorder.h"
#include "sim/record/result_json.h"
#include "sim/record/summary.h"
#include "sim/scenario/show.h"

namespace reamsim {

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

FrameForces ForceBasis::forces(std::int64_t frame, const ForceConstants& constants) const {
  const auto vector_of = [](const float* values) -> Vec3 {
    return Eigen::Map<const Eigen::Vector3f>(values).cast<double>();
  };
  FrameForces out;
  for (const BasisRow& row : std::ranges::equal_range(rows_, frame, {}, &BasisRow::frame)) {
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

double voxel_mm_of(const std::string& dir) {
  const std::string path = dir + "/summary.json";
  const auto json = parse_result_json(read_file(path, "the summary of a run"));
  const nlohmann::ordered_json::json_pointer key("/bone/voxel_mm");
  if (!json.contains(key) || !json[key].is_number() || !(json[key].get<double>() > 0)) {
    throw InputError({path, 0, 0}, "bone.voxel_mm", "missing or not positive",
                     "expected a file written by `reamsim run`");
  }
  return json[key].get<double>();
}

namespace {

[[noreturn]] void fail_for(const std::string& key, const std::string& why) {
  throw InputError({}, "--set", key + " is part of the force basis" + why, "run the scenario again with it");
}

/// Throws InputError where the basis does not hold for `is`.
void require_linear(const CuttingSettings& was, const CuttingSettings& is) {
  if (was.law != is.law) fail_for("cutting.law", "");
  if (was.erosion != is.erosion) fail_for("cutting.erosion", "");
  if (was.speed_floor_mm_s != is.speed_floor_mm_s) fail_for("cutting.speed_floor_mm_s", "");
  if (was.size_effect != is.size_effect) fail_for("cutting.size_effect", ", and forces are not linear in it");
  if (is.edge_force && !was.edge_force) {
    throw InputError({}, "--set", "cutting.edge_force: the run had no edge force, so that its basis has no part for it",
                     "run the scenario again with it");
  }
  if (is.edge_force && is.edge_force->cutting_edges != was.edge_force->cutting_edges)
    fail_for("cutting.edge_force.cutting_edges", "");
}

constexpr const char* kExpected = "a CSV file with time_s and any of axial_force_n, spin_torque_nmm, force_x_n, ...";

std::size_t place_of(const std::vector<std::string_view>& names, std::string_view name) {
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

/// The columns of forces and torques that a file has.
std::vector<std::string> force_columns_in(const std::vector<std::string_view>& names) {
  static constexpr std::array<std::string_view, 8> kColumns{"force_x_n",     "force_y_n",      "force_z_n",
                                                            "torque_x_nmm",  "torque_y_nmm",   "torque_z_nmm",
                                                            "axial_force_n", "spin_torque_nmm"};
  const auto has = [&](std::size_t i) { return place_of(names, kColumns[i]) < names.size(); };
  const bool force = has(0) && has(1) && has(2), torque = has(3) && has(4) && has(5);
  std::vector<std::string> out;
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    if (has(i) && !(i == 6 && force) && !(i == 7 && torque)) out.emplace_back(kColumns[i]);
  }
  return out;
}

}  // namespace

BasisRun open_basis_run(const std::string& dir) {
  LawSettings law = parse_law_settings(dir + "/scenario.yaml");
  if (!law.force_basis) {
    throw InputError({dir + "/scenario.yaml", 0, 0}, "output.force_basis", "is false: the run has no force basis",
                     "run the scenario again with --set output.force_basis=true");
  }
  return {dir, std::move(law), ForceBasis(read_force_basis(dir + "/" + kForceBasisName)), voxel_mm_of(dir)};
}

LawSettings changed_law(const BasisRun& run, const std::vector<std::string>& overrides) {
  LawSettings law = parse_law_settings(run.dir + "/scenario.yaml", overrides);
  require_linear(run.law.cutting, law.cutting);
  if (run.law.density != law.density && law.bone_source != "ct") {
    throw InputError({}, "--set", "bone.density: the bone is a " + law.bone_source + ", whose densities are given",
                     "change the relation from HU to density of a run on a CT only");
  }
  return law;
}

std::optional<Recalibration> recalibration(const BasisRun& run, const LawSettings& law) {
  if (run.law.density == law.density) return std::nullopt;
  return Recalibration{DensityMapping{run.law.density}, DensityMapping{law.density}};
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

RunTotals write_reforced(const BasisRun& run, const LawSettings& law, const std::string& to) {
  const ForceConstants constants = force_constants(law.cutting, recalibration(run, law));
  RunTotals totals(run.voxel_mm);
  // Under another name until it is complete, because the rows are read from a file that this one may replace.
  const std::string path = to + "/forces.csv.tmp";
  {
    CsvWriter forces(path, force_columns({}));
    double work_mj = 0, floor_mj = 0, cut_mj = 0;
    for_each_result(run.dir + "/forces.csv", {}, [&](FrameResult result) {
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

MeasuredForces read_measured_forces(const std::string& path) {
  const std::vector<std::string> lines = split(read_file(path, kExpected), '\n');
  const auto fail = [&](int line, const std::string& column, const std::string& found) {
    throw InputError({path, line, 0}, column, found, std::string("expected ") + kExpected);
  };
  const std::string header = csv_header(lines.front(), {path, 1, 0});
  const std::vector<std::string_view> names = csv_cells(header);
  MeasuredForces out{.columns = force_columns_in(names), .time_s = {}, .values = {}};
  out.values.resize(out.columns.size());
  if (place_of(names, "time_s") == names.size()) fail(1, "time_s", "column missing");
  if (out.columns.empty()) fail(1, "", "no measured column");
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::string& line = lines[i];
    const SourceLocation where{path, static_cast<int>(i) + 1, 0};
    if (line.empty() || line == "\r") continue;
    const std::vector<std::string_view> cells = csv_cells(line);
    if (cells.size() == 1) refuse_other_separator(line, where);
    if (cells.size() < names.size())
      throw InputError(where, "", "has fewer cells than the header", "expected a cell for each column");
    const auto value = [&](const std::string& column) {
      const std::string_view cell = cells[place_of(names, column)];
      if (cell.empty()) return std::nan("");
      const auto number = parse_number(cell);
      if (number && std::isfinite(*number)) return *number;
      throw InputError(where, column, "is not a finite number", "expected a number or an empty cell");
    };
    const double t = value("time_s");
    if (std::isnan(t) || (!out.time_s.empty() && t <= out.time_s.back()))
      throw InputError(where, "time_s", "does not ascend", "expected ascending times");
    out.time_s.push_back(t);
    for (std::size_t c = 0; c < out.columns.size(); ++c) out.values[c].push_back(value(out.columns[c]));
  }
  if (out.time_s.empty()) fail(0, "", "has no rows");
  return out;
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/record/results.h"
#include "sim/record/run_totals.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The constants in which forces are linear, or products of two (docs/physics.md, 4).
struct ForceConstants {
  std::array<double, 256> specific_energy_n_mm2{};  ///< u by grade, N/mm² = mJ/mm³
  double normal_ratio = 0;                          ///< k_n
  double edge_tangential_n_mm = 0;                  ///< K_t
  double edge_normal_n_mm = 0;                      ///< K_n
};

/// Another relation from HU to density than that of the run.
struct Recalibration {
  DensityMapping of_run;
  DensityMapping now;

  /// The density that a voxel of that grade has now, g/cm³.
  [[nodiscard]] double density(int grade) const;
};

ForceConstants force_constants(const CuttingSettings& cutting, const std::optional<Recalibration>& recalibration = {});

/// Force and torque of the bone on the tool (B), and energies of a frame.
struct FrameForces {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nmm = Vec3::Zero();
  double energy_mj = 0;
  double floor_energy_mj = 0;
  double work_mj = 0;  ///< on the bone
};

class ForceBasis {
 public:
  /// `rows`: in ascending frames.
  explicit ForceBasis(std::vector<BasisRow> rows) : rows_(std::move(rows)) {}

  [[nodiscard]] const std::vector<BasisRow>& rows() const { return rows_; }
  [[nodiscard]] FrameForces forces(std::int64_t frame, const ForceConstants& constants) const;
  /// Removed volume by grade over all frames, mm³; with a size effect, weighted by its factor.
  [[nodiscard]] std::array<double, 256> volume_mm3() const;

 private:
  std::vector<BasisRow> rows_;
};

/// A finished run whose forces can be computed for other constants.
struct BasisRun {
  std::string dir;
  LawSettings law;  ///< of the run
  ForceBasis basis;
  double voxel_mm = 0;
};

/// bone.voxel_mm in the summary.json of a run. Throws InputError.
double voxel_mm_of(const std::string& dir);

/// Throws InputError where a file of the run is missing or damaged, or it has no force basis.
BasisRun open_basis_run(const std::string& dir);

/// The settings of the run with overrides. Throws InputError where the basis does not hold for them.
LawSettings changed_law(const BasisRun& run, const std::vector<std::string>& overrides);

/// The relation from HU to density of `law` where it differs from that of the run.
std::optional<Recalibration> recalibration(const BasisRun& run, const LawSettings& law);

/// Removed volume whose density is not known exactly after a recalibration: a voxel stores at most 2 g/cm³.
struct ClampedVolume {
  double at_most_mm3 = 0;  ///< voxels of 2 g/cm³ in the run, whose radiodensity may be higher
  double beyond_mm3 = 0;   ///< voxels that would exceed 2 g/cm³ now, and count as 2
  double whole_mm3 = 0;    ///< all
};
ClampedVolume clamped_volume(const BasisRun& run, const std::optional<Recalibration>& recalibration);

/// Writes forces.csv, scenario.yaml and summary.json with other constants into `to`, perhaps the run's own folder.
/// Returns the totals. Throws RunError, and InputError where forces.csv of the run is damaged.
RunTotals write_reforced(const BasisRun& run, const LawSettings& law, const std::string& to);

struct MeasuredForces {
  std::vector<std::string> columns;  ///< "axial_force_n", ...
  std::vector<double> time_s;
  std::vector<std::vector<double>> values;  ///< by column and time; NaN where nothing was measured
};

/// Reads a CSV file with `time_s` and any columns of forces and torques, as forces.csv has them; others are skipped,
/// and cells may be empty. Axial force and spin torque are left out where all three components are given, whose
/// projections they are. Throws InputError: no such file, no column, no row, times not ascending.
MeasuredForces read_measured_forces(const std::string& path);

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "kernels/window.h"
#include "sim/engine/common/engine.h"

namespace reamsim {

using BasisValues = std::array<double, kBasisValues>;

/// The arguments of a substep with the constants to which its forces are linear, one at a time: the law itself,
/// evaluated with each of them, gives the basis.
struct UnitArgs {
  /// `edges_per_turn`: cutting edges/2π, mm of edge per mm² of face at a radius of 1 mm; 0: no edge force.
  UnitArgs(const SubstepArgs& args, float edges_per_turn);

  SubstepArgs without_normal;  ///< k_n = 0
  SubstepArgs with_normal;     ///< k_n = 1
  SubstepArgs edge_along;      ///< K_t = 1 N/mm, K_n = 0
  SubstepArgs edge_normal;     ///< K_t = 0, K_n = 1 N/mm
};

/// The basis of a voxel next to `clip` that loses a unit of fill. `volume_mm3`: of the whole voxel.
BasisValues unit_response(const UnitArgs& args, const Clip& clip, float volume_mm3);

/// The basis of cutting edges in contact with a voxel; see rs_edge_force().
BasisValues edge_response(const UnitArgs& args, const Clip& clip, rs_i32 face, rs_i32 remaining, rs_i32 kept);

/// Sums of one brick, added voxel by voxel.
struct BrickBasis {
  int substeps;
  std::map<int, std::vector<BasisValues>> by_grade{};  ///< by substep

  /// Adds `factor` times `values` to a grade in a substep.
  void add(std::size_t substep, int grade, double factor, const BasisValues& values);
};

/// Sums over the bricks, by substep and grade. A brick's are rounded to integers once: their order does not matter.
class VisitBasis {
 public:
  explicit VisitBasis(int substeps) : sums_(static_cast<std::size_t>(substeps) * kGrades) {}

  /// From any thread.
  void add(const BrickBasis& brick);
  /// The basis of each substep.
  [[nodiscard]] std::vector<SubstepBasis> substeps() const;

 private:
  static constexpr std::size_t kGrades = 256;
  using Units = std::array<std::int64_t, kBasisValues>;

  std::mutex mutex_;
  std::vector<Units> sums_;
};

/// An engine that adds the force basis to the batches of another one.
class BasisEngine : public Engine {
 public:
  explicit BasisEngine(std::unique_ptr<Engine> engine) : engine_(std::move(engine)) {}

  [[nodiscard]] bool full() const override { return engine_->full(); }
  RemovedFrames take_removed() override { return engine_->take_removed(); }
  void read_fill(const Voxmap& voxmap, FillBricks& fill) override { engine_->read_fill(voxmap, fill); }
  void restore(const BoneView& bone) override { engine_->restore(bone); }
  [[nodiscard]] std::string device() const override { return engine_->device(); }
  [[nodiscard]] std::size_t device_bytes() const override { return engine_->device_bytes(); }
  [[nodiscard]] StructureBytes structure_bytes() const override { return engine_->structure_bytes(); }

 protected:
  std::unique_ptr<Engine> engine_;
  std::vector<SubstepArgs> args_;  ///< of the batch
};

/// For `erosion: exact`. The basis is found apart from the engine: the voxels of a copy of the bone are cut on the
/// host, by the law and the windows of the engine (kernels/window.h, kernels/clip.h), and so lose the same.
std::unique_ptr<Engine> make_exact_basis_engine(std::unique_ptr<Engine> engine, const Scenario& scenario,
                                                const BoneView& bone, const Tool& tool);

}  // namespace reamsim

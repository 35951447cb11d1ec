// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/base/parallel.h"
#include "sim/engine/basis/basis.h"
#include "sim/engine/common/tables.h"
#include "sim/tool/tool.h"

namespace reamsim {

namespace {

/// Units per mm², mm³ and, of the edge, mm: fine against a voxel's part, and room for 8·10⁶ of them.
constexpr double kBasisScale = 1099511627776.0;  // 2^40

/// Force, torque and energy of the sums, in N, N·mm and mJ.
void add_edge(const LaneSums& sums, std::size_t first, BasisValues& out) {
  for (std::size_t i = 0; i < 3; ++i) {
    out[first + i] = static_cast<double>(sums.force[i]) / RS_FORCE_SCALE;
    out[first + 3 + i] = static_cast<double>(sums.torque[i]) / RS_TORQUE_SCALE;
  }
  out[12] += static_cast<double>(sums.energy) / RS_ENERGY_SCALE;
}

/// `erosion: remove`: the basis of the voxels that the engine removed. The engine gets the place of a substep in the
/// batch as its frame, and so tells which substep removed a voxel.
class TouchedBasisEngine final : public BasisEngine {
 public:
  TouchedBasisEngine(std::unique_ptr<Engine> engine, const BoneView& bone, const Tool& tool)
      : BasisEngine(std::move(engine)),
        voxmap_(bone.voxmap),
        outline_(make_outline_table(tool.profile, bone.voxmap.grid.voxel_mm)) {}

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) override {
    SubstepArgs placed = args;
    placed.frame = static_cast<std::int32_t>(args_.size());
    args_.push_back(args);
    engine_->enqueue(placed, std::move(window));
  }
  Batch collect() override {
    Batch out = engine_->collect();
    removed_ = engine_->take_removed();
    out.basis = substep_bases();
    for (auto& [voxel, place] : removed_) place = args_[static_cast<std::size_t>(place)].frame;
    args_.clear();
    return out;
  }
  RemovedFrames take_removed() override { return std::exchange(removed_, {}); }

 private:
  /// The basis of each substep. removed_ has the places in args_ of the substeps that removed its voxels.
  [[nodiscard]] std::vector<SubstepBasis> substep_bases() const {
    std::vector<std::vector<std::int64_t>> voxels(args_.size());
    for (const auto& [voxel, place] : removed_) voxels[static_cast<std::size_t>(place)].push_back(voxel);
    std::vector<SubstepBasis> out(args_.size());
    parallel_items(args_.size(), [&](std::size_t slot) {
      if (voxels[slot].empty()) return;
      std::ranges::sort(voxels[slot]);
      const UnitArgs units(args_[slot], 0);
      BrickBasis sums{1};
      for (const std::int64_t index : voxels[slot]) {
        const Vec3i voxel = voxmap_.grid.coord(index);
        sums.add(0, voxmap_.grade.get(voxel), RS_WHOLE_FILL, response(units, voxel));
      }
      VisitBasis whole(1);
      whole.add(sums);
      out[slot] = std::move(whole.substeps().front());
    });
    return out;
  }

  /// As rs_voxel_force().
  [[nodiscard]] BasisValues response(const UnitArgs& args, const Vec3i& voxel) const {
    const OutlineView outline = view_of(outline_);
    const SubstepArgs& a = args.without_normal;
    BrickMiddle brick;
    rs_brick_in_tool(&a, voxel.x(), voxel.y(), voxel.z(), &brick);
    Clip clip{};
    const float r = rs_voxel_in_tool(&a, &brick, static_cast<float>(voxel.x() & 7), static_cast<float>(voxel.y() & 7),
                                     static_cast<float>(voxel.z() & 7), clip.p);
    rs_outline_normal(&outline, rs_pieces_near(&outline, r, clip.p[2]), clip.p, clip.n);
    return unit_response(args, clip, static_cast<float>(voxmap_.grid.voxel_mm3()));
  }

  const Voxmap& voxmap_;
  OutlineTable outline_;
  RemovedFrames removed_;
};

}  // namespace

UnitArgs::UnitArgs(const SubstepArgs& args, float edges_per_turn)
    : without_normal(args), with_normal(args), edge_along(args), edge_normal(args) {
  without_normal.normal_ratio = 0;
  with_normal.normal_ratio = 1;
  edge_along.edge_tangential = edge_normal.edge_normal = edges_per_turn;
  edge_along.edge_normal = edge_normal.edge_tangential = 0;
}

BasisValues unit_response(const UnitArgs& args, const Clip& clip, float volume_mm3) {
  float without[RS_WINDOW_SUMS], with[RS_WINDOW_SUMS];
  rs_window_response(&args.without_normal, &clip, volume_mm3, without);
  rs_window_response(&args.with_normal, &clip, volume_mm3, with);
  BasisValues out{};
  for (std::size_t i = 0; i < RS_SUM_OF_ENERGY; ++i) {
    out[i] = double{without[i]};
    out[6 + i] = double{with[i]} - double{without[i]};
  }
  out[12] = double{without[RS_SUM_OF_ENERGY]};
  out[13] = double{without[RS_SUM_OF_FLOOR]};
  return out;
}

BasisValues edge_response(const UnitArgs& args, const Clip& clip, rs_i32 face, rs_i32 remaining, rs_i32 kept) {
  LaneSums along{}, normal{};
  rs_edge_force(&args.edge_along, &clip, face, remaining, kept, &along);
  rs_edge_force(&args.edge_normal, &clip, face, remaining, kept, &normal);
  BasisValues out{};
  add_edge(along, 0, out);
  add_edge(normal, 6, out);
  return out;
}

void BrickBasis::add(std::size_t substep, int grade, double factor, const BasisValues& values) {
  BasisValues& sum = by_grade.try_emplace(grade, static_cast<std::size_t>(substeps)).first->second[substep];
  for (std::size_t i = 0; i < kBasisValues; ++i) sum[i] += factor * values[i];
}

void VisitBasis::add(const BrickBasis& brick) {
  const std::lock_guard lock(mutex_);
  for (const auto& [grade, sums] : brick.by_grade) {
    for (std::size_t s = 0; s < sums.size(); ++s) {
      Units& to = sums_[s * kGrades + static_cast<std::size_t>(grade)];
      for (std::size_t i = 0; i < kBasisValues; ++i) to[i] += std::llround(sums[s][i] * kBasisScale);
    }
  }
}

std::vector<SubstepBasis> VisitBasis::substeps() const {
  std::vector<SubstepBasis> out(sums_.size() / kGrades);
  for (std::size_t s = 0; s < out.size(); ++s) {
    for (std::size_t grade = 0; grade < kGrades; ++grade) {
      const Units& units = sums_[s * kGrades + grade];
      if (std::ranges::all_of(units, [](std::int64_t unit) { return unit == 0; })) continue;
      GradeBasis& basis = out[s].emplace_back(GradeBasis{static_cast<int>(grade), {}});
      for (std::size_t i = 0; i < kBasisValues; ++i) basis.values[i] = static_cast<double>(units[i]) / kBasisScale;
    }
  }
  return out;
}

std::unique_ptr<Engine> make_basis_engine(std::unique_ptr<Engine> engine, const Scenario& scenario,
                                          const BoneView& bone, const Tool& tool) {
  if (scenario.cutting.erosion == ErosionMode::exact)
    return make_exact_basis_engine(std::move(engine), scenario, bone, tool);
  return std::make_unique<TouchedBasisEngine>(std::move(engine), bone, tool);
}

}  // namespace reamsim

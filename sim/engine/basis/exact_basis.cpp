// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "kernels/distance_grid.h"
#include "kernels/reach.h"
#include "sim/base/parallel.h"
#include "sim/engine/basis/basis.h"
#include "sim/engine/common/bone_faces.h"
#include "sim/engine/common/tables.h"
#include "sim/engine/exact/brick_batch_plan.h"
#include "sim/tool/distance_grid.h"

namespace reamsim {

namespace {

/// The arguments at the nodes of a window of smooth motion.
struct NodeUnits {
  UnitArgs first, middle, last;
};

/// The grade of the edge force in a basis.
constexpr int kEdge = 0;

BrickMiddle middle_of(const SubstepArgs& args, const Vec3i& brick) {
  BrickMiddle out;
  const Vec3i voxel = RS_BRICK_SIDE * brick;
  rs_brick_in_tool(&args, voxel.x(), voxel.y(), voxel.z(), &out);
  return out;
}

/// A voxel's place in its brick.
struct Place {
  explicit Place(int offset)
      : x(static_cast<float>(offset & 7)), y(static_cast<float>(offset >> 3 & 7)), z(static_cast<float>(offset >> 6)) {}
  float x, y, z;
};

/// The line through the responses of a voxel at the three nodes that deviates least on average: as rs_fit_force().
class ForceLine {
 public:
  ForceLine(const MotionWindow& w, const NodeUnits& units, const Clip& first, const Clip& middle, const Clip& last,
            float volume_mm3) {
    const BasisValues a = unit_response(units.first, first, volume_mm3),
                      b = unit_response(units.middle, middle, volume_mm3),
                      c = unit_response(units.last, last, volume_mm3);
    const double t0 = double{w.first_time}, t2 = double{w.last_time};
    for (std::size_t i = 0; i < kBasisValues; ++i) {
      const double before = (a[i] - b[i]) / t0, after = (c[i] - b[i]) / t2, bend = (after - before) / (t2 - t0);
      base_[i] = b[i] + bend / 3;
      slope_[i] = before - bend * t0;
    }
  }

  [[nodiscard]] BasisValues at(float time) const {
    BasisValues out{};
    for (std::size_t i = 0; i < kBasisValues; ++i) out[i] = base_[i] + slope_[i] * double{time};
    return out;
  }

 private:
  BasisValues base_{}, slope_{};
};

/// Cuts its own copy of the bone.
class ExactBasisEngine final : public BasisEngine {
 public:
  ExactBasisEngine(std::unique_ptr<Engine> engine, const Scenario& scenario, const BoneView& bone, const Tool& tool)
      : BasisEngine(std::move(engine)),
        tool_(tool),
        lattice_(BrickLattice::over(bone.voxmap.grid.dims)),
        faces_(bone),
        extent_(bone_extent(bone.voxmap)),
        outline_(make_outline_table(tool.profile, bone.voxmap.grid.voxel_mm)),
        view_(view_of(outline_)),
        tool_box_(tool.clip_bounds().expanded(outline_.bulge_mm)),
        table_(brick_distances(tool.profile, bone.voxmap.grid.voxel_mm, tool.clip_slack_mm() + outline_.bulge_mm)),
        coarse_(coarse_grid(table_)),
        slack_mm_(static_cast<float>(tool.clip_slack_mm() + outline_.bulge_mm)),
        volume_mm3_(static_cast<float>(bone.voxmap.grid.voxel_mm3())) {
    set_bone(bone);
    if (tool.teeth) teeth_ = distance_lattice(*tool.teeth);
    const EnergyTable table = make_energy_table(scenario.cutting, bone.voxmap.grid.voxel_mm);
    std::ranges::transform(table.energy_mj, energy_mj_.begin(), [](double mj) { return static_cast<float>(mj); });
    if (const auto& edge = scenario.cutting.edge_force)
      edges_per_turn_ = static_cast<float>(edge->cutting_edges / (2 * M_PI));
  }

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) override {
    args_.push_back(args);
    motions_.push_back(window);
    engine_->enqueue(args, std::move(window));
  }
  Batch collect() override {
    Batch out = engine_->collect();
    for (int first = 0; first < std::ssize(args_);) first = cut_visit(first, out.basis);
    args_.clear();
    motions_.clear();
    return out;
  }
  void restore(const BoneView& bone) override {
    engine_->restore(bone);
    set_bone(bone);
  }

 private:
  using Page = std::array<std::uint16_t, RS_BRICK_VOXELS>;

  /// What the bricks of a visit share.
  struct Visit {
    const BrickBatchPlan& plan;
    std::vector<UnitArgs> units;   ///< by substep of the visit
    std::vector<NodeUnits> nodes;  ///< of the plan's motions

    [[nodiscard]] std::size_t place(rs_u32 slot) const { return slot - static_cast<rs_u32>(plan.first); }
  };

  /// A brick in a visit.
  struct BrickVisit {
    const GradeBricks::Brick& grades;
    Page& fill;
    Vec3i at;
    BrickBasis sums;
    std::vector<BrickMiddle> middles;  ///< by substep of the visit
    PieceList list{};                  ///< pieces of the outline that can be nearest in the current window
  };

  void set_bone(const BoneView& bone) {
    grades_ = &bone.voxmap.grade;
    fill_before_ = bone.fill;
    pages_ = std::vector<std::unique_ptr<Page>>(lattice_.count());
  }

  /// Cuts through a visit from slot `first` on, and appends the basis of its substeps. Returns the slot after the last.
  int cut_visit(int first, std::vector<SubstepBasis>& out) {
    const BrickBatchPlan plan = plan_brick_batch(args_, motions_, first, RS_VISIT_SUBSTEPS, tool_box_, extent_);
    Visit visit{plan, {}, {}};
    for (int slot = plan.first; slot < plan.end; ++slot)
      visit.units.emplace_back(args_[static_cast<std::size_t>(slot)], edges_per_turn_);
    for (const MotionWindow& w : plan.motions)
      visit.nodes.push_back({UnitArgs(w.first, 0), UnitArgs(w.middle, 0), UnitArgs(w.last, 0)});
    VisitBasis sums(plan.end - plan.first);
    const std::vector<Vec3i> bricks = bricks_in_reach(args_[static_cast<std::size_t>(first)], plan);
    parallel_items(bricks.size(), [&](std::size_t i) { cut_brick(visit, bricks[i], sums); });
    std::ranges::move(sums.substeps(), std::back_inserter(out));
    return plan.end;
  }

  /// As kernels/list_bricks.cl.
  [[nodiscard]] std::vector<Vec3i> bricks_in_reach(const SubstepArgs& args, const BrickBatchPlan& plan) const {
    std::vector<Vec3i> out;
    if (plan.superbricks.empty()) return out;
    const Vec3i first = 4 * plan.superbricks.first;
    const Vec3i last = (4 * plan.superbricks.last + Vec3i::Constant(3)).cwiseMin(lattice_.dims - Vec3i::Ones());
    const float reach = RS_BRICK_RADIUS * args.voxel_mm + plan.shift_mm + slack_mm_;
    for_each_voxel(first, last, [&](const Vec3i& at) {
      if (grades_->brick(at) == nullptr) return;
      float middle[3];
      rs_box_middle(&args, 8 * at.x(), 8 * at.y(), 8 * at.z(), 8, middle);
      if (rs_near_surface(&coarse_, table_.mm.data(), middle, reach) != 0) out.push_back(at);
    });
    return out;
  }

  Page& page_of(const Vec3i& brick) {
    std::unique_ptr<Page>& page = pages_[lattice_.index(brick)];
    if (page) return *page;
    page = std::make_unique<Page>();
    if (const FillBricks::Brick* fill = fill_before_.brick(brick)) {
      std::ranges::copy(*fill, page->begin());
    } else {
      page->fill(FillBricks::kWhole);
    }
    return *page;
  }

  void cut_brick(const Visit& visit, const Vec3i& at, VisitBasis& sums) {
    BrickVisit brick{*grades_->brick(at), page_of(at), at, {visit.plan.end - visit.plan.first}, {}, {}};
    for (int slot = visit.plan.first; slot < visit.plan.end; ++slot)
      brick.middles.push_back(middle_of(args_[static_cast<std::size_t>(slot)], at));
    for (const SubstepWindow& window : visit.plan.windows) {
      const SubstepArgs& args = args_[window.first];
      const BrickMiddle& middle = brick.middles[visit.place(window.first)];
      brick.list = rs_pieces_near_brick(&view_, &middle);
      const float shift = window.shift_mm * args.per_voxel_mm;
      const unsigned blocks = blocks_in_reach(args, shift, brick, middle);
      for (int offset = 0; offset < RS_BRICK_VOXELS; ++offset) {
        const auto i = static_cast<std::size_t>(offset);
        const int block = (offset >> 2 & 1) | (offset >> 5 & 1) << 1 | (offset >> 8 & 1) << 2;  // of 4×4×4 voxels
        if ((blocks >> block & 1U) == 0 || brick.grades[i] == 0 || brick.fill[i] == 0) continue;
        if (!in_reach(args, shift, brick, middle, offset)) continue;
        if (window.motion < 0 || !cut_smoothly(visit, window, brick, offset))
          cut_by_frames(visit, window, brick, offset);
      }
    }
    sums.add(brick.sums);
  }

  /// The blocks of 4×4×4 voxels of a brick that the surface can reach while the tool moves by `shift` voxels, a bit
  /// each; as list_places() of kernels/candidates.h.
  [[nodiscard]] unsigned blocks_in_reach(const SubstepArgs& args, float shift, const BrickVisit& brick,
                                         const BrickMiddle& middle) const {
    constexpr float kBlockRadius = 2.6F, kBulge = 0.1F;
    const float near = RS_CLIP_REACH + kBlockRadius + kBulge + shift + teeth_.slack_mm * args.per_voxel_mm;
    unsigned out = 0;
    for (int block = 0; block < 8; ++block) {
      const float x = static_cast<float>((block & 1) << 2) + 1.5F, y = static_cast<float>((block & 2) << 1) + 1.5F,
                  z = static_cast<float>(block & 4) + 1.5F;
      const float distance = rs_clip_distance(&args, &view_, brick.list, &middle, x, y, z);
      if (distance * args.per_voxel_mm <= near) out |= 1U << block;
    }
    return out;
  }

  /// Whether the surface can intersect a voxel, or contains it, meanwhile.
  [[nodiscard]] bool in_reach(const SubstepArgs& args, float shift, const BrickVisit& brick, const BrickMiddle& middle,
                              int offset) const {
    const Place at(offset);
    if (!tool_.teeth) return rs_distance_beyond_reach(&args, &view_, brick.list, &middle, at.x, at.y, at.z, shift) <= 0;
    const DistanceView teeth{&teeth_, tool_.teeth->slot_of_brick.data(), tool_.teeth->samples.data()};
    const float slack = RS_CLIP_REACH + RS_GRID_STEEPEST * shift + RS_POSITION_SLACK * args.per_voxel_mm;
    return rs_clip_grid_distance(&args, &teeth, &middle, at.x, at.y, at.z) * args.per_voxel_mm <= slack;
  }

  /// The tool next to a voxel: the surface of resolved cutting edges, else the envelope.
  [[nodiscard]] Clip clip(const SubstepArgs& args, const BrickVisit& brick, const BrickMiddle& middle,
                          int offset) const {
    const Place at(offset);
    if (!tool_.teeth) return rs_clip(&args, &view_, brick.list, &middle, at.x, at.y, at.z);
    const DistanceView teeth{&teeth_, tool_.teeth->slot_of_brick.data(), tool_.teeth->samples.data()};
    return rs_clip_grid(&args, &teeth, &middle, at.x, at.y, at.z);
  }

  /// Cuts a voxel in a window of smooth motion. Returns false where it must be cut frame by frame.
  [[nodiscard]] bool cut_smoothly(const Visit& visit, const SubstepWindow& window, BrickVisit& brick,
                                  int offset) const {
    const auto i = static_cast<std::size_t>(offset), number = static_cast<std::size_t>(window.motion);
    const MotionWindow& w = visit.plan.motions[number];
    const Clip first = clip(w.first, brick, middle_of(w.first, brick.at), offset),
               middle = clip(w.middle, brick, middle_of(w.middle, brick.at), offset),
               last = clip(w.last, brick, middle_of(w.last, brick.at), offset);
    WindowVoxel fit;
    rs_fit_voxel(&w, &first, &middle, &last, energy_mj_[brick.grades[i]], &fit);
    if (fit.pieces == 0) return false;
    std::optional<ForceLine> line;
    const rs_i32 face = faces_.at(BrickLattice::voxel_at(brick.at, offset));
    const FaceCut cut = rs_face_cut(face, &middle.plane);
    rs_i32 fill = brick.fill[i];
    for (rs_u32 slot = window.first; slot < window.end; ++slot) {
      const SubstepArgs& args = args_[slot];
      const std::size_t place = visit.place(slot);
      const float time = rs_window_time(&w, args.frame);
      const rs_i32 outside = rs_window_outside(&fit, time, RS_WINDOW_PIECES);
      const rs_i32 kept = rs_kept_fill(&cut, outside), lost = rs_clip_loss(&args, fill, kept);
      fill -= lost;
      if (rs_has_edge(&args) != 0) {
        const Clip now = clip(args, brick, brick.middles[place], offset);
        brick.sums.add(place, kEdge, 1, edge_response(visit.units[place], now, face, fill, kept));
      }
      if (lost == 0) continue;
      if (!line) line.emplace(w, visit.nodes[number], first, middle, last, volume_mm3_);
      brick.sums.add(place, brick.grades[i], lost, line->at(time));
    }
    brick.fill[i] = static_cast<std::uint16_t>(fill);
    return true;
  }

  void cut_by_frames(const Visit& visit, const SubstepWindow& window, BrickVisit& brick, int offset) const {
    const auto i = static_cast<std::size_t>(offset);
    const rs_i32 face = faces_.at(BrickLattice::voxel_at(brick.at, offset));
    for (rs_u32 slot = window.first; slot < window.end && brick.fill[i] > 0; ++slot) {
      const SubstepArgs& args = args_[slot];
      const std::size_t place = visit.place(slot);
      Clip now = clip(args, brick, brick.middles[place], offset);
      const rs_i32 kept = rs_clip_kept(&now, face), lost = rs_clip_loss(&args, brick.fill[i], kept);
      brick.fill[i] = static_cast<std::uint16_t>(brick.fill[i] - lost);
      if (args.law != RS_LAW_ENERGY) continue;
      if (rs_has_edge(&args) != 0)
        brick.sums.add(place, kEdge, 1, edge_response(visit.units[place], now, face, brick.fill[i], kept));
      if (lost == 0) continue;
      if (tool_.teeth) rs_use_envelope_normal(&view_, brick.list, &now);
      brick.sums.add(place, brick.grades[i], lost, unit_response(visit.units[place], now, volume_mm3_));
    }
  }

  const Tool& tool_;
  MotionsOfSlots motions_;  ///< of the batch
  const GradeBricks* grades_ = nullptr;
  FillBricks fill_before_;
  BrickLattice lattice_;
  BoneFaces faces_;
  std::vector<std::unique_ptr<Page>> pages_;  ///< fill by brick; none: that before the run
  VoxelBox extent_;
  OutlineTable outline_;
  OutlineView view_;
  Aabb tool_box_;
  DistanceTable table_;
  CoarseGrid coarse_;
  float slack_mm_;
  DistanceLattice teeth_{};
  std::array<float, 256> energy_mj_{};  ///< of a whole voxel, by grade
  float volume_mm3_;
  float edges_per_turn_ = 0;
};

}  // namespace

std::unique_ptr<Engine> make_exact_basis_engine(std::unique_ptr<Engine> engine, const Scenario& scenario,
                                                const BoneView& bone, const Tool& tool) {
  return std::make_unique<ExactBasisEngine>(std::move(engine), scenario, bone, tool);
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/make_engine.h"

#include <array>
#include <functional>
#include <unordered_map>
#include <utility>

#include "kernels/distance_grid.h"
#include "kernels/window.h"
#include "sim/base/stopwatch.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/substep.h"
#include "sim/engine/common/tables.h"
#include "sim/tool/point_shell.h"

namespace reamsim {

namespace {

/// Data that detection and cut share.
struct SerialState {
  const Tool* tool = nullptr;
  OutlineTable outline;
  DistanceLattice lattice{};  ///< of the resolved cutting edges
  VoxelGrid grid;
  std::vector<std::uint8_t> bone;   ///< grade, 0 = air or removed
  std::vector<std::uint16_t> fill;  ///< dense
  std::vector<std::int64_t> contacts;
  RemovedFrames removed;
};

void set_bone(const BoneView& bone, SerialState& state) {
  state.grid = bone.voxmap.grid;
  state.bone = dense_remaining_grades(bone);
  state.fill = dense_fill(bone);
}

SerialState make_serial_state(const BoneView& bone, const Tool& tool) {
  SerialState state;
  state.tool = &tool;
  state.outline = full_outline_table(tool.profile, bone.voxmap.grid.voxel_mm);
  if (tool.teeth) state.lattice = distance_lattice(*tool.teeth);
  set_bone(bone, state);
  return state;
}

/// Appends to `state.contacts` the voxels that the tool touches in a substep, each once. Forces of points (`law:
/// per_point`) are added to `sums`.
using FindContacts = std::function<void(SerialState& state, const SubstepArgs& args, SubstepSums& sums)>;

/// The voxels that contain a shell point. Without culling, so that it also verifies the VOI. `claimed`: by voxel, all
/// false before and after.
void find_by_points(SerialState& state, const SubstepArgs& args, std::vector<bool>& claimed, SubstepSums& sums) {
  const OutlineView outline = view_of(state.outline);
  LaneSums point_sums{};
  for (const std::uint64_t code : state.tool->shell.codes) {
    const Vec3i cell = morton_decode(code);
    const int x = cell.x(), y = cell.y(), z = cell.z();
    const Vec3i voxel(rs_voxel_coordinate(&args, 0, x, y, z), rs_voxel_coordinate(&args, 1, x, y, z),
                      rs_voxel_coordinate(&args, 2, x, y, z));
    if (!state.grid.contains(voxel)) continue;
    const auto e = static_cast<std::size_t>(state.grid.index(voxel));
    if (state.bone[e] == 0) continue;
    if (args.law == RS_LAW_PER_POINT) rs_point_force(&args, &outline, x, y, z, &point_sums);
    if (claimed[e]) continue;
    claimed[e] = true;
    state.contacts.push_back(static_cast<std::int64_t>(e));
  }
  rs_add_lanes(&sums, &point_sums);
  for (const std::int64_t e : state.contacts) claimed[static_cast<std::size_t>(e)] = false;
}

/// The reference of `implicit`: every voxel against the tool's solid of revolution, without culling.
void find_in_outline(SerialState& state, const SubstepArgs& args, SubstepSums& /*sums*/) {
  const OutlineView outline = view_of(state.outline);
  for (std::int64_t e = 0; e < state.grid.size(); ++e) {
    if (state.bone[static_cast<std::size_t>(e)] == 0) continue;
    const Vec3i voxel = state.grid.coord(e);
    if (rs_contains_voxel(&args, &outline, voxel.x(), voxel.y(), voxel.z())) state.contacts.push_back(e);
  }
}

/// Appends the voxels with bone of a brick that lie in `box`, in the order of their places.
void find_in_brick(const Vec3i& brick, const VoxelBox& box, SerialState& state) {
  for (int place = 0; place < RS_BRICK_VOXELS; ++place) {
    const Vec3i voxel = RS_BRICK_SIDE * brick + Vec3i(rs_offset_x(place), rs_offset_y(place), rs_offset_z(place));
    if (!box.contains(voxel)) continue;
    const std::int64_t e = state.grid.index(voxel);
    if (state.bone[static_cast<std::size_t>(e)] != 0) state.contacts.push_back(e);
  }
}

/// For `exact`, which clips every contact: all voxels with bone in the tool's box.
void find_in_tool_box(SerialState& state, const SubstepArgs& args, SubstepSums& /*sums*/) {
  const VoxelGrid& grid = state.grid;
  // A surface that intersects a voxel passes less than the voxel's diagonal from its centre.
  const Aabb tool = state.tool->clip_bounds().expanded(grid.voxel_mm + state.outline.bulge_mm);
  const VoxelBox box = voxel_voi(args, tool, {Vec3i::Zero(), grid.dims - Vec3i::Ones()});
  if (box.empty()) return;
  // Brick by brick, because sums of windows are rounded once per brick.
  for_each_voxel(box.first / RS_BRICK_SIDE, box.last / RS_BRICK_SIDE,
                 [&](const Vec3i& brick) { find_in_brick(brick, box, state); });
}

FindContacts choose_detection(const Scenario& scenario, const SerialState& state) {
  if (scenario.cutting.erosion == ErosionMode::exact) return find_in_tool_box;
  if (engine_of(scenario) == EngineKind::implicit) return find_in_outline;
  return [claimed = std::vector<bool>(state.bone.size(), false)](SerialState& now, const SubstepArgs& args,
                                                                 SubstepSums& sums) mutable {
    find_by_points(now, args, claimed, sums);
  };
}

/// The fill that voxel `e` loses for `remove` and `wear`. Its forces are added to `law`.
rs_i32 cut_touched(const SerialState& state, const EnergyTable& table, const SubstepArgs& args, std::int64_t e,
                   LaneSums& law) {
  const auto i = static_cast<std::size_t>(e);
  const std::uint8_t grade = state.bone[i];
  const rs_i32 lost = rs_lost_fill(&args, table.density_g_cm3[grade], state.fill[i]);
  const double energy = rs_lost_energy(table.energy_mj[grade], lost);
  law.energy += rs_energy_units(energy);
  if (args.law == RS_LAW_ENERGY) {
    const Vec3i voxel = state.grid.coord(e);
    const OutlineView outline = view_of(state.outline);
    rs_voxel_force(&args, &outline, voxel.x(), voxel.y(), voxel.z(), static_cast<float>(energy), &law);
  }
  return lost;
}

/// The tool's surface next to a voxel: that of the resolved cutting edges, else the envelope.
Clip clip_voxel(const SerialState& state, const SubstepArgs& args, const OutlineView& outline, const Vec3i& voxel) {
  BrickMiddle middle;
  rs_brick_in_tool(&args, voxel.x(), voxel.y(), voxel.z(), &middle);
  const auto x = static_cast<float>(voxel.x() & 7), y = static_cast<float>(voxel.y() & 7),
             z = static_cast<float>(voxel.z() & 7);
  if (!state.tool->teeth) return rs_clip(&args, &outline, outline.lists[0], &middle, x, y, z);
  const DistanceGrid& grid = *state.tool->teeth;
  const DistanceView teeth{&state.lattice, grid.slot_of_brick.data(), grid.samples.data()};
  return rs_clip_grid(&args, &teeth, &middle, x, y, z);
}

/// A voxel in a window, from the tool next to it at the three nodes.
WindowVoxel fit_voxel(const SerialState& state, const EnergyTable& table, const MotionWindow& w, std::int64_t e) {
  const OutlineView outline = view_of(state.outline);
  const Vec3i voxel = state.grid.coord(e);
  const Clip first = clip_voxel(state, w.first, outline, voxel), middle = clip_voxel(state, w.middle, outline, voxel),
             last = clip_voxel(state, w.last, outline, voxel);
  WindowVoxel out;
  rs_fit_voxel(&w, &first, &middle, &last, static_cast<float>(table.energy_mj[state.bone[static_cast<std::size_t>(e)]]),
               &out);
  return out;
}

/// As cut_touched(), for `exact`.
rs_i32 cut_by_clipping(const SerialState& state, const EnergyTable& table, const SubstepArgs& args, std::int64_t e,
                       LaneSums& law) {
  const auto i = static_cast<std::size_t>(e);
  const OutlineView outline = view_of(state.outline);
  Clip clip = clip_voxel(state, args, outline, state.grid.coord(e));
  const rs_i32 outside = rs_fill_outside(&clip), lost = rs_clip_loss(&args, state.fill[i], outside);
  if (rs_has_edge(&args)) rs_edge_force(&args, &clip, state.fill[i] - lost, outside, &law);
  if (lost == 0) return lost;
  if (state.tool->teeth) rs_use_envelope_normal(&outline, outline.lists[0], &clip);
  rs_clip_force(&args, &clip, static_cast<float>(table.energy_mj[state.bone[i]]), lost, &law);
  return lost;
}

class SerialEngine final : public Engine {
 public:
  SerialEngine(const Scenario& scenario, const BoneView& bone, const Tool& tool)
      : state_(make_serial_state(bone, tool)),
        find_(choose_detection(scenario, state_)),
        energy_(make_energy_table(scenario.cutting, bone.voxmap.grid.voxel_mm)),
        exact_(scenario.cutting.erosion == ErosionMode::exact) {}

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) override {
    if (window != window_) fits_.clear();
    window_ = std::move(window);
    SubstepSums& sums = batch_.sums.emplace_back();
    StageTimes& times = batch_.times.emplace_back();
    const Stopwatch watch;
    find_(state_, args, sums);
    times.detect_s = watch.seconds();
    cut_contacts(args, sums);
    times.cut_s = watch.seconds() - times.detect_s;
  }

  [[nodiscard]] bool full() const override { return batch_.sums.size() >= 4096; }
  Batch collect() override { return std::exchange(batch_, {}); }
  RemovedFrames take_removed() override { return std::exchange(state_.removed, {}); }
  void read_fill(const Voxmap& voxmap, FillBricks& fill) override { copy_fill(state_.fill, voxmap, fill); }
  void restore(const BoneView& bone) override { set_bone(bone, state_); }
  [[nodiscard]] std::string device() const override { return "serial"; }
  [[nodiscard]] std::size_t device_bytes() const override { return 0; }
  [[nodiscard]] StructureBytes structure_bytes() const override { return {}; }

 private:
  /// Cuts the voxels of the contact list in order, adds to `sums`, and empties the list.
  void cut_contacts(const SubstepArgs& args, SubstepSums& sums) {
    LaneSums law{};
    for (const std::int64_t e : state_.contacts) {
      const auto i = static_cast<std::size_t>(e);
      const rs_i32 lost = window_ ? cut_in_window(args, e, law, sums)
                                  : (exact_ ? cut_by_clipping : cut_touched)(state_, energy_, args, e, law);
      if (lost == 0) continue;
      sums.contacts += 1;
      sums.removed += lost;
      if (rs_is_trial(&args)) continue;
      state_.fill[i] = static_cast<std::uint16_t>(state_.fill[i] - lost);
      if (state_.fill[i] > 0) continue;
      state_.bone[i] = 0;
      state_.removed.emplace_back(e, args.frame);
    }
    if (window_) finish_brick(args, -1, sums);
    rs_add_lanes(&sums, &law);
    state_.contacts.clear();
  }

  /// As cut_by_clipping(), in a window of smooth motion: adds to the sums of the voxel's brick.
  rs_i32 cut_in_window(const SubstepArgs& args, std::int64_t e, LaneSums& law, SubstepSums& sums) {
    const Vec3i brick = state_.grid.coord(e) / RS_BRICK_SIDE;
    finish_brick(args, state_.grid.index(brick), sums);
    auto found = fits_.find(e);
    if (found == fits_.end()) found = fits_.emplace(e, fit_voxel(state_, energy_, *window_, e)).first;
    const WindowVoxel& fit = found->second;
    if (fit.pieces == 0) return cut_by_clipping(state_, energy_, args, e, law);
    const rs_i32 outside = rs_window_outside(&fit, rs_window_time(window_.get(), args.frame), RS_WINDOW_PIECES);
    const rs_i32 lost = rs_clip_loss(&args, state_.fill[static_cast<std::size_t>(e)], outside);
    if (rs_has_edge(&args)) {
      const Clip clip = clip_voxel(state_, args, view_of(state_.outline), state_.grid.coord(e));
      rs_edge_force(&args, &clip, state_.fill[static_cast<std::size_t>(e)] - lost, outside, &law);
    }
    const auto loss = static_cast<float>(lost);
    for (std::size_t i = 0; i < RS_WINDOW_SUMS; ++i) {
      brick_sums_[i] = RS_FMA(loss, fit.base[i], brick_sums_[i]);
      brick_sums_[RS_WINDOW_SUMS + i] = RS_FMA(loss, fit.slope[i], brick_sums_[RS_WINDOW_SUMS + i]);
    }
    return lost;
  }

  /// Adds the sums of the last brick, when `brick` is another one.
  void finish_brick(const SubstepArgs& args, std::int64_t brick, SubstepSums& sums) {
    if (brick == brick_) return;
    rs_finish_window_sums(brick_sums_.data(), rs_window_time(window_.get(), args.frame), &sums);
    brick_sums_ = {};
    brick_ = brick;
  }

  SerialState state_;
  FindContacts find_;
  EnergyTable energy_;
  bool exact_;
  std::shared_ptr<const MotionWindow> window_;                       ///< of the current substep
  std::unordered_map<std::int64_t, WindowVoxel> fits_;               ///< of its voxels
  std::array<float, std::size_t{2} * RS_WINDOW_SUMS> brick_sums_{};  ///< of the current brick
  std::int64_t brick_ = -1;
  Batch batch_;
};

}  // namespace

std::unique_ptr<Engine> make_serial_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool) {
  return std::make_unique<SerialEngine>(scenario, bone, tool);
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/engine.h"

#include <array>
#include <unordered_map>
#include <utility>

#include "kernels/distance_grid.h"
#include "kernels/window.h"
#include "sim/base/stopwatch.h"
#include "sim/engine/common/bone_faces.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/substep.h"
#include "sim/engine/common/tables.h"
#include "sim/tool/point_shell.h"

namespace reamsim {

namespace {

class SerialEngine final : public Engine {
 public:
  SerialEngine(const Scenario& scenario, const BoneView& bone, const Tool& tool)
      : tool_(tool),
        kind_(engine_of(scenario)),
        exact_(scenario.cutting.erosion == ErosionMode::exact),
        table_(full_outline_table(tool.profile, bone.voxmap.grid.voxel_mm)),
        outline_(view_of(table_)),
        energy_(make_energy_table(scenario.cutting, bone.voxmap.grid.voxel_mm)),
        faces_(bone) {
    if (tool.teeth) lattice_ = distance_lattice(*tool.teeth);
    restore(bone);
    if (!exact_ && kind_ != EngineKind::implicit) claimed_.resize(bone_.size(), false);
  }

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) override {
    if (window != window_) fits_.clear();
    window_ = std::move(window);
    SubstepSums& sums = batch_.sums.emplace_back();
    StageTimes& times = batch_.times.emplace_back();
    const Stopwatch watch;
    if (exact_) {
      find_in_tool_box(args);
    } else if (kind_ == EngineKind::implicit) {
      find_in_outline(args);
    } else {
      find_by_points(args, sums);
    }
    times.detect_s = watch.seconds();
    cut_contacts(args, sums);
    times.cut_s = watch.seconds() - times.detect_s;
  }

  [[nodiscard]] bool full() const override { return batch_.sums.size() >= 4096; }
  Batch collect() override { return std::exchange(batch_, {}); }
  RemovedFrames take_removed() override { return std::exchange(removed_, {}); }
  void read_fill(const Voxmap& voxmap, FillBricks& fill) override { copy_fill(fill_, voxmap, fill); }
  void restore(const BoneView& bone) override {
    grid_ = bone.voxmap.grid;
    bone_ = dense_remaining_grades(bone);
    fill_ = dense_fill(bone);
  }
  [[nodiscard]] std::string device() const override { return "serial"; }
  [[nodiscard]] std::size_t device_bytes() const override { return 0; }
  [[nodiscard]] StructureBytes structure_bytes() const override { return {}; }

 private:
  /// The contacts: the voxels that contain a shell point, each once. Without culling, so that it also verifies the VOI.
  /// Forces of points (`law: per_point`) are added to `sums`.
  void find_by_points(const SubstepArgs& args, SubstepSums& sums) {
    LaneSums point_sums{};
    for (const std::uint64_t code : tool_.shell.codes) {
      const Vec3i cell = morton_decode(code);
      const Vec3i voxel = voxel_of_cell(args, cell);
      if (!grid_.contains(voxel)) continue;
      const auto e = static_cast<std::size_t>(grid_.index(voxel));
      if (bone_[e] == 0) continue;
      if (args.law == RS_LAW_PER_POINT) rs_point_force(&args, &outline_, cell.x(), cell.y(), cell.z(), &point_sums);
      if (claimed_[e]) continue;
      claimed_[e] = true;
      contacts_.push_back(static_cast<std::int64_t>(e));
    }
    rs_add_lanes(&sums, &point_sums);
    for (const std::int64_t e : contacts_) claimed_[static_cast<std::size_t>(e)] = false;
  }

  /// The reference of `implicit`: every voxel against the tool's solid of revolution, without culling.
  void find_in_outline(const SubstepArgs& args) {
    for (std::int64_t e = 0; e < grid_.size(); ++e) {
      if (bone_[static_cast<std::size_t>(e)] == 0) continue;
      const Vec3i voxel = grid_.coord(e);
      if (rs_contains_voxel(&args, &outline_, voxel.x(), voxel.y(), voxel.z())) contacts_.push_back(e);
    }
  }

  /// For `exact`, which clips every contact: all voxels with bone in the tool's box.
  void find_in_tool_box(const SubstepArgs& args) {
    // A surface that intersects a voxel passes less than the voxel's diagonal from its centre.
    const Aabb tool = tool_.clip_bounds().expanded(grid_.voxel_mm + table_.bulge_mm);
    const VoxelBox box = voxel_voi(args, tool, {Vec3i::Zero(), grid_.dims - Vec3i::Ones()});
    if (box.empty()) return;
    // Brick by brick, because sums of windows are rounded once per brick.
    for_each_voxel(box.first / RS_BRICK_SIDE, box.last / RS_BRICK_SIDE, [&](const Vec3i& brick) {
      for (int place = 0; place < RS_BRICK_VOXELS; ++place) {
        const Vec3i voxel = RS_BRICK_SIDE * brick + Vec3i(rs_offset_x(place), rs_offset_y(place), rs_offset_z(place));
        if (!box.contains(voxel)) continue;
        const std::int64_t e = grid_.index(voxel);
        if (bone_[static_cast<std::size_t>(e)] != 0) contacts_.push_back(e);
      }
    });
  }

  /// Cuts the voxels of the contact list in order, adds to `sums`, and empties the list.
  void cut_contacts(const SubstepArgs& args, SubstepSums& sums) {
    LaneSums law{};
    for (const std::int64_t e : contacts_) {
      const auto i = static_cast<std::size_t>(e);
      const rs_i32 lost = window_  ? cut_in_window(args, e, law, sums)
                          : exact_ ? cut_by_clipping(args, e, law)
                                   : cut_touched(args, e, law);
      if (lost == 0) continue;
      sums.contacts += 1;
      sums.removed += lost;
      if (rs_is_trial(&args)) continue;
      fill_[i] = static_cast<std::uint16_t>(fill_[i] - lost);
      if (fill_[i] > 0) continue;
      bone_[i] = 0;
      removed_.emplace_back(e, args.frame);
    }
    if (window_) finish_brick(args, -1, sums);
    rs_add_lanes(&sums, &law);
    contacts_.clear();
  }

  /// The fill that voxel `e` loses for `remove` and `wear`. Its forces are added to `law`.
  rs_i32 cut_touched(const SubstepArgs& args, std::int64_t e, LaneSums& law) const {
    const auto i = static_cast<std::size_t>(e);
    const std::uint8_t grade = bone_[i];
    const rs_i32 lost = rs_lost_fill(&args, energy_.density[grade], fill_[i]);
    const rs_i64 energy = rs_lost_energy(energy_.units[grade], lost);
    law.energy += energy;
    if (args.law == RS_LAW_ENERGY) {
      const Vec3i voxel = grid_.coord(e);
      rs_voxel_force(&args, &outline_, voxel.x(), voxel.y(), voxel.z(), rs_energy_mj(energy), &law);
    }
    return lost;
  }

  /// The tool's surface next to a voxel: that of the resolved cutting edges, else the envelope.
  [[nodiscard]] Clip clip_voxel(const SubstepArgs& args, std::int64_t e) const {
    const Vec3i voxel = grid_.coord(e);
    BrickMiddle middle;
    rs_brick_in_tool(&args, voxel.x(), voxel.y(), voxel.z(), &middle);
    const auto x = static_cast<float>(voxel.x() & 7), y = static_cast<float>(voxel.y() & 7),
               z = static_cast<float>(voxel.z() & 7);
    if (!tool_.teeth) return rs_clip(&args, &outline_, outline_.lists[0], &middle, x, y, z);
    const DistanceView teeth{&lattice_, tool_.teeth->slot_of_brick.data(), tool_.teeth->samples.data()};
    return rs_clip_grid(&args, &teeth, &middle, x, y, z);
  }

  /// Energy of the whole voxel, mJ.
  [[nodiscard]] float whole_energy(std::int64_t e) const {
    return static_cast<float>(energy_.energy_mj[bone_[static_cast<std::size_t>(e)]]);
  }

  /// As cut_touched(), for `exact`.
  rs_i32 cut_by_clipping(const SubstepArgs& args, std::int64_t e, LaneSums& law) const {
    const auto fill = fill_[static_cast<std::size_t>(e)];
    Clip clip = clip_voxel(args, e);
    const rs_i32 face = faces_.at(grid_.coord(e)), kept = rs_clip_kept(&clip, face);
    const rs_i32 lost = rs_clip_loss(&args, fill, kept);
    if (rs_has_edge(&args)) rs_edge_force(&args, &clip, face, fill - lost, kept, &law);
    if (lost == 0) return lost;
    if (tool_.teeth) rs_use_envelope_normal(&outline_, outline_.lists[0], &clip);
    rs_clip_force(&args, &clip, whole_energy(e), lost, &law);
    return lost;
  }

  /// A voxel in the current window.
  struct FittedVoxel {
    WindowVoxel window;
    FaceCut face;  ///< of the bone
  };

  /// A voxel in the current window, from the tool next to it at the three nodes.
  [[nodiscard]] FittedVoxel fit_voxel(std::int64_t e) const {
    const MotionWindow& w = *window_;
    const Clip first = clip_voxel(w.first, e), middle = clip_voxel(w.middle, e), last = clip_voxel(w.last, e);
    FittedVoxel out{.window = {}, .face = rs_face_cut(faces_.at(grid_.coord(e)), &middle.plane)};
    rs_fit_voxel(&w, &first, &middle, &last, whole_energy(e), &out.window);
    return out;
  }

  /// As cut_by_clipping(), in a window of smooth motion: adds to the sums of the voxel's brick.
  rs_i32 cut_in_window(const SubstepArgs& args, std::int64_t e, LaneSums& law, SubstepSums& sums) {
    const Vec3i brick = grid_.coord(e) / RS_BRICK_SIDE;
    finish_brick(args, grid_.index(brick), sums);
    auto found = fits_.find(e);
    if (found == fits_.end()) found = fits_.emplace(e, fit_voxel(e)).first;
    const WindowVoxel& fit = found->second.window;
    if (fit.pieces == 0) return cut_by_clipping(args, e, law);
    const auto fill = fill_[static_cast<std::size_t>(e)];
    const rs_i32 outside = rs_window_outside(&fit, rs_window_time(window_.get(), args.frame), RS_WINDOW_PIECES);
    const rs_i32 face = faces_.at(grid_.coord(e)), kept = rs_kept_fill(&found->second.face, outside);
    const rs_i32 lost = rs_clip_loss(&args, fill, kept);
    if (rs_has_edge(&args)) {
      const Clip clip = clip_voxel(args, e);
      rs_edge_force(&args, &clip, face, fill - lost, kept, &law);
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

  const Tool& tool_;
  EngineKind kind_;
  bool exact_;
  OutlineTable table_;
  OutlineView outline_;        ///< of the table
  DistanceLattice lattice_{};  ///< of the resolved cutting edges
  EnergyTable energy_;
  BoneFaces faces_;
  VoxelGrid grid_;
  std::vector<std::uint8_t> bone_;   ///< grade, 0 = air or removed
  std::vector<std::uint16_t> fill_;  ///< dense
  std::vector<std::int64_t> contacts_;
  std::vector<bool> claimed_;  ///< by voxel, all false between two substeps
  RemovedFrames removed_;
  std::shared_ptr<const MotionWindow> window_;                       ///< of the current substep
  std::unordered_map<std::int64_t, FittedVoxel> fits_;               ///< of its voxels
  std::array<float, std::size_t{2} * RS_WINDOW_SUMS> brick_sums_{};  ///< of the current brick
  std::int64_t brick_ = -1;
  Batch batch_;
};

}  // namespace

std::unique_ptr<Engine> make_serial_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool) {
  return std::make_unique<SerialEngine>(scenario, bone, tool);
}

}  // namespace reamsim

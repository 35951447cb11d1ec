// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/contact_forecast.h"

#include <fmt/core.h>
#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

#include "sim/base/parallel.h"
#include "sim/tool/profile.h"

namespace reamsim {

namespace {

/// Half a voxel's diagonal, voxels: bone of a voxel is no further from its centre.
constexpr double kVoxelRadius_voxels = 0.5 * 1.7320508;
/// Half a brick's diagonal, voxels.
constexpr double kBrickRadius_voxels = 0.5 * BrickLattice::kSide * 1.7320508;
/// Smallest step along the path, voxels.
constexpr double kStep_voxels = 0.5;
/// The same where the first contact is searched for, and where the tool turns.
constexpr double kFineStep_voxels = 0.05, kTurnStep_voxels = 0.005;

constexpr double kNoContact = std::numeric_limits<double>::infinity();

/// A brick with bone, and the smallest distance of the tool from its middle.
struct Brick {
  Vec3i coord;
  Vec3 middle_mm;
  double least_mm = kNoContact;
};

/// Where along the path the tool is within reach of a brick for the first time, and where it first is as close, or as
/// deep in it, as it ever is.
struct BrickVisit {
  double enter_mm = kNoContact;
  double closest_mm = 0;
  double least_mm = kNoContact;  ///< distance from the brick's middle there
};

/// Distances between the voxels of a bone and the profile of a tool along its path.
class ContactSearch {
 public:
  /// Holds references to all arguments.
  ContactSearch(const Voxmap& voxmap, const FillBricks& fill, const Profile& tool, const ToolPath& path)
      : voxmap_(voxmap), fill_(fill), profile_(tool), voxel_mm_(voxmap_.grid.voxel_mm), path_(path) {
    voxmap_.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
      bool has_bone = fill_.brick(coord) == nullptr;  // an earlier pass may have removed all of it
      if (!has_bone) for_each_bone_voxel(coord, [&](const Vec3&, double) { has_bone = true; });
      if (has_bone) bricks_.push_back({coord, voxmap_.grid.brick_center_mm(coord)});
    });
  }

  /// Bone in the tool at its first pose, mm³.
  [[nodiscard]] double start_mm3() const {
    const Rigid first = tool_from_bone(0);
    double voxels = 0;
    for (const Brick& brick : bricks_) {
      if (distance_mm(first, brick.middle_mm) > radius_mm()) continue;
      for_each_bone_voxel(brick.coord, [&](const Vec3& center_mm, double fill) {
        // The fraction of a voxel in the tool, whose surface is approximated by a plane.
        voxels += fill * std::clamp(0.5 - distance_mm(first, center_mm) / voxel_mm_, 0.0, 1.0);
      });
    }
    return voxels * voxmap_.grid.voxel_mm3();
  }

  /// Finds the smallest distance between the tool and a voxel's face. The tool touches the bone unless it stays out of
  /// reach for certain: beyond half a voxel's diagonal from each centre, the distance that a step along the path may
  /// hide, and `margin_mm`.
  void find_nearest(double margin_mm, ContactForecast& out) {
    double bound_mm = kNoContact;  // upper bound of the distance
    for (Brick& brick : bricks_) {
      follow(brick.middle_mm, [&](double mm, double) {
        brick.least_mm = std::min(brick.least_mm, mm);
        bound_mm = std::min(bound_mm, mm + radius_mm());
        return bound_mm > 0 ? std::optional(bound_mm + radius_mm()) : std::nullopt;
      });
      if (bound_mm > 0) continue;
      out.touches = true;  // a whole brick passes through the tool
      return;
    }
    std::ranges::stable_sort(bricks_, {}, &Brick::least_mm);
    double best_mm = kNoContact;
    for (const Brick& brick : bricks_) {
      if (brick.least_mm - radius_mm() - kStep_voxels * voxel_mm_ > best_mm) break;
      for_each_bone_voxel(brick.coord, [&](const Vec3& center_mm, double) {
        if (best_mm <= 0) return;
        follow(center_mm, [&](double mm, double at_mm) {
          const double gap_mm = mm - 0.5 * voxel_mm_;
          if (gap_mm < best_mm) {
            best_mm = gap_mm;
            out.frame = static_cast<std::int64_t>(path_.frame_at(at_mm));
            out.bone_mm = center_mm;
          }
          return best_mm > 0 ? std::optional(best_mm + 0.5 * voxel_mm_) : std::nullopt;
        });
      });
      if (best_mm <= 0) break;
    }
    out.touches = best_mm <= (kVoxelRadius_voxels - 0.5 * kStep_voxels) * voxel_mm_ + margin_mm;
    out.nearest_mm = std::max(0.0, best_mm);
  }

  /// From the first contact to the last removal of bone.
  [[nodiscard]] std::optional<FrameSpan> frames() const {
    std::vector<BrickVisit> visits(bricks_.size());
    parallel_items(bricks_.size(), [&](std::size_t i) { visits[i] = visit_of(bricks_[i].middle_mm); });
    const double first_mm = first_contact_mm(visits);
    if (first_mm == kNoContact) return std::nullopt;
    return FrameSpan{static_cast<std::int64_t>(path_.frame_at(first_mm)),
                     static_cast<std::int64_t>(path_.frame_at(last_removal_mm(visits, first_mm)))};
  }

 private:
  [[nodiscard]] double distance_at_mm(const Vec3& point_mm, double at_mm) const {
    return distance_mm(tool_from_bone(at_mm), point_mm);
  }

  [[nodiscard]] BrickVisit visit_of(const Vec3& middle_mm) const {
    BrickVisit out;
    double before_mm = 0;  // where the previous distance was taken
    follow(middle_mm, [&](double mm, double at_mm) {
      if (mm < radius_mm()) out.enter_mm = std::min(out.enter_mm, at_mm);
      // A tool that is drawn back passes the same places again, sampled at others.
      const double gain_mm = out.closest_mm == before_mm ? 0 : kStep_voxels * voxel_mm_;
      if (mm < out.least_mm - gain_mm) {
        out.least_mm = mm;
        out.closest_mm = at_mm;
      }
      before_mm = at_mm;
      const double bound_mm = out.enter_mm == kNoContact ? radius_mm() : out.least_mm;
      const bool removed = mm <= -radius_mm();
      return removed ? std::nullopt : std::optional(bound_mm);
    });
    return out;
  }

  /// Where the last brick is removed as far as it ever is.
  [[nodiscard]] double last_removal_mm(const std::vector<BrickVisit>& visits, double first_mm) const {
    double last_mm = first_mm;
    std::size_t last = visits.size();
    for (std::size_t i = 0; i < visits.size(); ++i) {
      if (visits[i].least_mm >= 0.5 * BrickLattice::kSide * voxel_mm_ || visits[i].closest_mm <= last_mm) continue;
      last_mm = visits[i].closest_mm;
      last = i;
    }
    if (last == visits.size()) return first_mm;
    // The steps of visit_of() may miss the place where the tool turns, and the frame must be before it rests there.
    const Vec3& middle_mm = bricks_[last].middle_mm;
    const double from_mm = std::max(first_mm, last_mm - kStep_voxels * voxel_mm_);
    const double to_mm = std::min(path_.length_mm(), last_mm + kStep_voxels * voxel_mm_);
    double least_mm = kNoContact;
    for (double at_mm = from_mm; at_mm <= to_mm; at_mm += kTurnStep_voxels * voxel_mm_) {
      least_mm = std::min(least_mm, distance_at_mm(middle_mm, at_mm));
    }
    return first_within(middle_mm, least_mm + kTurnStep_voxels * voxel_mm_, from_mm, to_mm, kTurnStep_voxels);
  }

  /// Where, between these places, the tool is first within `reach_mm` of a point; `to_mm` if nowhere.
  [[nodiscard]] double first_within(const Vec3& point_mm, double reach_mm, double from_mm, double to_mm,
                                    double step_voxels) const {
    const double end_mm = std::min(to_mm, path_.length_mm());
    for (double at_mm = from_mm; at_mm < end_mm;) {
      const double mm = distance_at_mm(point_mm, at_mm);
      if (mm < reach_mm) return at_mm;
      at_mm += std::max(step_voxels * voxel_mm_, mm - reach_mm);
    }
    return to_mm;
  }

  /// Where the tool first touches what is filled of a voxel, or kNoContact.
  [[nodiscard]] double first_contact_mm(const std::vector<BrickVisit>& visits) const {
    std::vector<std::size_t> order(visits.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return visits[i].enter_mm; });
    double best_mm = kNoContact;
    for (const std::size_t i : order) {
      if (visits[i].enter_mm >= best_mm) break;
      for_each_bone_voxel(bricks_[i].coord, [&](const Vec3& center_mm, double fill) {
        best_mm = first_within(center_mm, (fill - 0.5) * voxel_mm_, visits[i].enter_mm, best_mm, kFineStep_voxels);
      });
    }
    return best_mm;
  }

  [[nodiscard]] double radius_mm() const { return kBrickRadius_voxels * voxel_mm_; }

  [[nodiscard]] Rigid tool_from_bone(double at_mm) const { return path_.pose_at(at_mm).bone_from_tool().inverse(); }

  [[nodiscard]] double distance_mm(const Rigid& tool_from_bone, const Vec3& point_mm) const {
    return profile_.nearest(rz_of(tool_from_bone * point_mm)).distance_mm;
  }

  /// Follows the tool's distance from a point along the path. visit(distance, place) returns the distance of interest,
  /// or nullopt to stop. Where the distance is larger, the tool must move by at least the difference, which is skipped.
  template <class Visit>
  void follow(const Vec3& point_mm, const Visit& visit) const {
    double at_mm = 0;
    for (;;) {
      const double mm = distance_at_mm(point_mm, at_mm);
      const std::optional<double> bound_mm = visit(mm, at_mm);
      if (!bound_mm || at_mm >= path_.length_mm()) return;
      at_mm = std::min(path_.length_mm(), at_mm + std::max(kStep_voxels * voxel_mm_, mm - *bound_mm));
    }
  }

  /// Calls visit(centre, fill 0…1) for the voxels of a brick with bone.
  template <class Visit>
  void for_each_bone_voxel(const Vec3i& coord, const Visit& visit) const {
    for_each_bone_voxel_in({voxmap_, fill_}, coord, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t fill) {
      if (fill != 0) visit(voxmap_.grid.center_mm(voxel), static_cast<double>(fill) / FillBricks::kWhole);
    });
  }

  const Voxmap& voxmap_;
  const FillBricks& fill_;
  const Profile& profile_;
  double voxel_mm_;
  const ToolPath& path_;
  std::vector<Brick> bricks_;
};

/// Bound of the distance outside the tool's profile at which a run finds contact with a point of a voxel.
double margin_mm(const Scenario& scenario, const Tool& tool) {
  if (scenario.cutting.erosion == ErosionMode::exact) return tool.clip_slack_mm() + fit_outline(tool.profile).bulge_mm;
  return kVoxelRadius_voxels * tool.shell.cell_mm;  // a point of the shell lies in a cell that the surface cuts
}

/// `most`: at least the bone that the pass meets.
ContactForecast forecast_pass(const SimulationInput& scene, const FillBricks& fill, const FillBricks& most,
                              const Tool& tool, const Motion& motion) {
  const Voxmap& voxmap = *scene.bone.voxmap;
  ContactForecast out;
  if (motion.poses.empty()) return out;
  // Every pose of the motion, or those of a long one at the smallest step.
  BoundedPath poses(tool.reach_mm, kStep_voxels * voxmap.grid.voxel_mm);
  poses.add(motion.poses);
  const ToolPath path(poses.finish(), tool.reach_mm);
  ContactSearch search(voxmap, fill, tool.profile, path);
  out.start_mm3 = search.start_mm3();
  if (out.start_mm3 > voxmap.grid.voxel_mm3()) {
    out.touches = true;
  } else {
    const double reach_mm = margin_mm(scene.scenario, tool) + poses.deviation_mm();
    search.find_nearest(reach_mm, out);
    if (!out.touches && &most != &fill) {
      ContactForecast before;
      ContactSearch(voxmap, most, tool.profile, path).find_nearest(reach_mm, before);
      out.touches = before.touches;
    }
    out.frame += motion.first_frame;
  }
  if (out.touches) out.frames = search.frames();
  if (out.frames) out.frames = FrameSpan{out.frames->first + motion.first_frame, out.frames->last + motion.first_frame};
  return out;
}

}  // namespace

std::vector<ContactForecast> forecast_passes(const SimulationInput& scene) {
  std::vector<ContactForecast> out;
  // Whether earlier passes leave what is predicted, to within a voxel. Wear, springs, a hand, cutting edges that turn
  // and points of a shell can leave more bone.
  const auto is_envelope = [](const Tool& tool) { return !tool.teeth; };
  const bool predictable = scene.scenario.cutting.erosion == ErosionMode::exact &&
                           scene.scenario.motion.is_prescribed() && is_envelope(scene.tool) &&
                           std::ranges::all_of(scene.later_passes, is_envelope, &Pass::tool);
  for_each_predicted_pass(scene, [&](const FillBricks& fill, const Tool& tool, const Motion& motion) {
    out.push_back(forecast_pass(scene, fill, predictable ? fill : scene.bone.fill, tool, motion));
  });
  return out;
}

ContactForecast of_whole_run(const std::vector<ContactForecast>& passes) {
  ContactForecast out = *std::ranges::min_element(passes, {}, &ContactForecast::nearest_mm);
  out.start_mm3 = passes.front().start_mm3;
  for (const ContactForecast& pass : passes) {
    out.touches = out.touches || pass.touches;
    if (!pass.frames) continue;
    if (!out.frames) out.frames = pass.frames;
    out.frames =
        FrameSpan{std::min(out.frames->first, pass.frames->first), std::max(out.frames->last, pass.frames->last)};
  }
  return out;
}

FrameSpans contact_frames(const std::vector<ContactForecast>& passes) {
  FrameSpans out;
  for (const ContactForecast& pass : passes) {
    if (pass.frames) out.push_back(*pass.frames);
  }
  return out;
}

std::optional<FrameSpan> forecast_contact_frames(const Voxmap& voxmap, const FillBricks& fill, const Profile& tool,
                                                 const ToolPath& path) {
  return ContactSearch(voxmap, fill, tool, path).frames();
}

void warn_of_contact(const SimulationInput& scene, const std::vector<ContactForecast>& forecasts, Diagnostics& report) {
  const bool exact = scene.scenario.cutting.erosion == ErosionMode::exact;
  for (std::size_t i = 0; i < forecasts.size(); ++i) {
    const ContactForecast& forecast = forecasts[i];
    const std::string pass = forecasts.size() > 1 ? "pass " + std::to_string(i + 1) + ": " : "";
    if (forecast.start_mm3 > scene.bone.voxmap->grid.voxel_mm3()) {
      report.warn(fmt::format(
          "{}the tool starts in the bone: at its first pose it contains about {:.3g} mm3 of bone{}; start further out "
          "(motion)",
          pass, forecast.start_mm3,
          exact ? ", which is removed without force" : ", so the force of the first frames is not meaningful"));
    }
    if (forecast.touches) continue;
    report.warn(fmt::format(
        "{}the tool never touches the bone: its smallest distance is {:.2f} mm, in frame {}, from the bone at {} mm; "
        "check motion and, if it is used, the glenoid frame",
        pass, forecast.nearest_mm, forecast.frame, point_text(forecast.bone_mm)));
  }
}

}  // namespace reamsim

#include "sim/predict/contact_forecast.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/motion/bounded_path.h"
#include "sim/predict/swept_bone.h"

namespace reamsim {

namespace {

/// Half a brick's diagonal, voxels.
constexpr double kBrickRadius_voxels = 0.5 * BrickLattice::kSide * 1.7320508;
/// Smallest step along the path, voxels.
constexpr double kStep_voxels = 0.5;

/// Every pose of the motion, or those of a long one at the smallest step.
std::vector<PathSample> path_of(const Tool& tool, const Motion& motion, double voxel_mm) {
  BoundedPath path(tool.reach_mm, kStep_voxels * voxel_mm);
  path.add(motion.poses);
  return path.finish();
}

/// A brick with bone, and the smallest distance of the tool from its middle.
struct Brick {
  Vec3i coord;
  Vec3 middle_mm;
  double least_mm = std::numeric_limits<double>::infinity();
};

/// Distances between the voxels of a bone and the profile of a tool along its path.
class ContactSearch {
 public:
  /// Holds references to voxmap, fill and profile.
  ContactSearch(const Voxmap& voxmap, const FillBricks& fill, const Tool& tool, const Motion& motion)
      : voxmap_(voxmap),
        fill_(fill),
        profile_(tool.profile),
        voxel_mm_(voxmap_.grid.voxel_mm),
        path_(path_of(tool, motion, voxel_mm_), tool.reach_mm) {
    voxmap_.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
      const Vec3 middle =
          voxmap_.grid.origin_mm + voxel_mm_ * BrickLattice::kSide * (coord.cast<double>() + Vec3::Constant(0.5));
      bricks_.push_back({coord, middle});
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

  /// Finds the smallest distance between the tool and a voxel's face.
  void find_nearest(ContactForecast& out) {
    double bound_mm = std::numeric_limits<double>::infinity();  // upper bound of the distance
    for (Brick& brick : bricks_) {
      follow(brick.middle_mm, [&](double mm, double) {
        brick.least_mm = std::min(brick.least_mm, mm);
        bound_mm = std::min(bound_mm, mm + radius_mm());
        return bound_mm > 0 ? bound_mm + radius_mm() : 0;
      });
      if (bound_mm > 0) continue;
      out.touches = true;  // a whole brick passes through the tool
      return;
    }
    std::ranges::stable_sort(bricks_, {}, &Brick::least_mm);
    double best_mm = std::numeric_limits<double>::infinity();
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
          return best_mm > 0 ? best_mm + 0.5 * voxel_mm_ : 0;
        });
      });
      if (best_mm <= 0) break;
    }
    out.touches = best_mm <= 0;
    out.nearest_mm = std::max(0.0, best_mm);
  }

 private:
  [[nodiscard]] double radius_mm() const { return kBrickRadius_voxels * voxel_mm_; }

  [[nodiscard]] Rigid tool_from_bone(double at_mm) const { return path_.pose_at(at_mm).bone_from_tool().inverse(); }

  [[nodiscard]] double distance_mm(const Rigid& tool_from_bone, const Vec3& point_mm) const {
    const Vec3 p = tool_from_bone * point_mm;
    return profile_.nearest({p.head<2>().norm(), p.z()}).distance_mm;
  }

  /// Follows the tool's distance from a point along the path. visit(distance, place) returns the distance of interest,
  /// or 0 to stop. Where the distance is larger, the tool must move by at least the difference, which is skipped.
  template <class Visit>
  void follow(const Vec3& point_mm, const Visit& visit) const {
    double at_mm = 0;
    for (;;) {
      const double mm = distance_mm(tool_from_bone(at_mm), point_mm);
      const double bound_mm = visit(mm, at_mm);
      if (bound_mm <= 0 || at_mm >= path_.length_mm()) return;
      at_mm = std::min(path_.length_mm(), at_mm + std::max(kStep_voxels * voxel_mm_, mm - bound_mm));
    }
  }

  /// Calls visit(centre, fill 0…1) for the voxels of a brick with bone.
  template <class Visit>
  void for_each_bone_voxel(const Vec3i& coord, const Visit& visit) const {
    const GradeBricks::Brick& grades = *voxmap_.grade.brick(coord);
    const FillBricks::Brick* fills = fill_.brick(coord);
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      const auto at = static_cast<std::size_t>(offset);
      const std::uint16_t fill = fills == nullptr ? FillBricks::kWhole : (*fills)[at];
      if (grades[at] == 0 || fill == 0) continue;
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      visit(voxmap_.grid.center_mm(voxel), static_cast<double>(fill) / FillBricks::kWhole);
    }
  }

  const Voxmap& voxmap_;
  const FillBricks& fill_;
  const Profile& profile_;
  double voxel_mm_;
  ToolPath path_;
  std::vector<Brick> bricks_;
};

ContactForecast forecast_pass(const Voxmap& voxmap, const FillBricks& fill, const Tool& tool, const Motion& motion) {
  ContactForecast out;
  if (motion.poses.empty()) return out;
  ContactSearch search(voxmap, fill, tool, motion);
  out.start_mm3 = search.start_mm3();
  if (out.start_mm3 > voxmap.grid.voxel_mm3()) {
    out.touches = true;
  } else {
    search.find_nearest(out);
    out.frame += motion.first_frame;
  }
  return out;
}

}  // namespace

ContactForecast forecast_contact(const ReamingScene& scene) {
  return forecast_pass(*scene.bone.voxmap, scene.bone.fill, scene.tool, scene.motion);
}

std::vector<ContactForecast> forecast_passes(const ReamingScene& scene) {
  std::vector<ContactForecast> out{forecast_contact(scene)};
  const Voxmap& voxmap = *scene.bone.voxmap;
  const bool whole_voxels = scene.scenario.cutting.erosion != ErosionMode::exact;
  FillBricks fill = scene.bone.fill;
  const Tool* tool = &scene.tool;
  const Motion* motion = &scene.motion;
  for (const Pass& pass : scene.later_passes) {
    std::vector<ToolPose> poses;
    for (const PathSample& sample : path_of(*tool, *motion, voxmap.grid.voxel_mm)) poses.push_back(sample.pose);
    fill = predict_swept_bone(voxmap, fill, tool->profile, poses, whole_voxels).fill;
    out.push_back(forecast_pass(voxmap, fill, pass.tool, pass.motion));
    tool = &pass.tool;
    motion = &pass.motion;
  }
  return out;
}

void warn_of_contact(const ReamingScene& scene, const ContactForecast& forecast, Report& report,
                     const std::string& pass) {
  if (forecast.start_mm3 > scene.bone.voxmap->grid.voxel_mm3()) {
    const bool exact = scene.scenario.cutting.erosion == ErosionMode::exact;
    report.warn(fmt::format(
        "{}the tool starts in the bone: at its first pose it contains about {:.3g} mm3 of bone{}; start further out "
        "(motion)",
        pass, forecast.start_mm3,
        exact ? ", which is removed without force" : ", so the force of the first frames is not meaningful"));
  }
  if (!forecast.touches) {
    const Vec3& p = forecast.bone_mm;
    report.warn(fmt::format(
        "{}the tool never touches the bone: its smallest distance is {:.2f} mm, in frame {}, from the bone at "
        "({:.1f}, {:.1f}, {:.1f}) mm; check motion and, if it is used, the glenoid frame",
        pass, forecast.nearest_mm, forecast.frame, p.x(), p.y(), p.z()));
  }
}

void warn_of_contact(const ReamingScene& scene, const std::vector<ContactForecast>& forecasts, Report& report) {
  for (std::size_t i = 0; i < forecasts.size(); ++i) {
    warn_of_contact(scene, forecasts[i], report, forecasts.size() > 1 ? "pass " + std::to_string(i + 1) + ": " : "");
  }
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/clearance.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <tuple>

#include "sim/bone/mesh_source.h"
#include "sim/bone/voxel_surface.h"
#include "sim/mesh/mesh_io.h"
#include "sim/scenario/parse.h"
#include "sim/scene/swept_bone.h"
#include "sim/tool/tool_path.h"

namespace reamsim {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
/// Poses that are measured, at most, and the bound of the motion between two of them where there are more, voxels.
constexpr std::size_t kMostMeasured = 4000;
constexpr double kMeasuredStepVoxels = 0.1;
/// Projections between a part and a polygon, and the change that ends them, voxels.
constexpr int kProjections = 60;
constexpr double kSettledVoxels = 1e-4;
constexpr double kHalfDiagonalVoxels = 0.8660254;
/// Side of the cells in which triangles of an envelope are collected, voxels.
constexpr double kCellVoxels = 8;

/// A convex part of the holder.
Profile profile_of(const HolderPartSettings& part) {
  const double radius = part.diameter_mm / 2;
  const double end = part.end_diameter_mm > 0 ? part.end_diameter_mm / 2 : radius;
  return Profile{{{0, part.from_z_mm}, {radius, part.from_z_mm}, {end, part.to_z_mm}, {0, part.to_z_mm}}};
}

/// A voxel that the tool has not finished cutting before the frame `until`.
struct PassingVoxel {
  Vec3 center;
  std::optional<VoxelPlane> surface;  ///< at the start; nullopt: it is whole
  std::int64_t until;
};

/// Polygons close to each other: of a brick of bone, or of a cell of the envelope.
struct Cluster {
  Obstacle obstacle = Obstacle::bone;
  Vec3i brick = Vec3i::Zero();
  Vec3 middle = Vec3::Zero();
  double radius_mm = 0;
  bool built = false;
  std::vector<SurfacePatch> patches = {};  ///< that are there all the time
  std::vector<PassingVoxel> passing = {};
  double bound_mm = -kFar;  ///< lower bound of its distance at `bound_at_mm` of the path
  double bound_at_mm = 0;
};

/// The surfaces that the holder must not touch. Polygons of the bone are made when the holder comes near.
class Surfaces {
 public:
  Surfaces(const BoneView& bone, const Tool& tool, const Motion& motion, const ClearanceSettings& settings)
      : bone_(bone), cuts_(bone_.voxmap.grid, tool.profile, motion.poses) {
    const VoxelGrid& grid = bone_.voxmap.grid;
    const double radius_mm = 0.5 * std::sqrt(3.0) * (BrickLattice::kSide * grid.voxel_mm);
    bone_.voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
      clusters.push_back({.brick = coord, .middle = grid.brick_center_mm(coord), .radius_mm = radius_mm});
    });
    if (settings.envelope) add_envelope(*settings.envelope, kCellVoxels * grid.voxel_mm);
  }

  /// Makes the polygons of a cluster of bone, once.
  void build(Cluster& cluster) const {
    if (cluster.built) return;
    cluster.built = true;
    const VoxelCuts::Brick cuts = cuts_.of_brick(cluster.brick);
    for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
      const Vec3i voxel = BrickLattice::voxel_at(cluster.brick, offset);
      if (bone_fraction(bone_, voxel) > 0) add_voxel(voxel, cuts[static_cast<std::size_t>(offset)], cluster);
    }
  }

  /// The surface of what a plane beside the tool leaves of a voxel.
  void add_solid(const PassingVoxel& voxel, const VoxelPlane& left, std::vector<SurfacePatch>& out) const {
    const VoxelPlane planes[] = {left, voxel.surface.value_or(left)};
    add_solid_patches(voxel.center, bone_.voxmap.grid.voxel_mm, std::span(planes, voxel.surface ? 2 : 1), out);
  }

  /// Whether a point lies in bone that no tool comes near.
  [[nodiscard]] bool in_bone(const Vec3& point) const {
    const Vec3i voxel = bone_.voxmap.grid.voxel_of(point);
    if (bone_fraction(bone_, voxel) < 1) return false;
    const auto offset = static_cast<std::size_t>(BrickLattice::offset_of(voxel));
    return cuts_.of_brick(BrickLattice::brick_of(voxel))[offset].frame == VoxelCut::kNever;
  }

  std::vector<Cluster> clusters;
  Diagnostics envelope;  ///< what is said of its mesh

 private:
  void add_voxel(const Vec3i& voxel, const VoxelCut& cut, Cluster& cluster) const {
    if (cut.frame == VoxelCut::kNever) return add_surface_patches(bone_, voxel, cluster.patches);
    const PassingVoxel passing{bone_.voxmap.grid.center_mm(voxel), voxel_plane(bone_, voxel, Vec3::UnitZ()), cut.frame};
    cluster.passing.push_back(passing);
    // Bone is only removed, so what remains at the end was there all the time.
    if (cut.plane) add_solid(passing, *cut.plane, cluster.patches);
  }

  TriangleMesh read_envelope(const ClearanceEnvelopeSettings& settings) {
    MeshContents contents = read_mesh_contents(settings.path, settings.scale, "clearance.envelope.path");
    Diagnostics report = contents.report;
    bring_into_lps(contents, MeshFrame::file, settings.path, "", report);
    if (meet_after_half_turn_only(contents.mesh.bounds(), bone_.voxmap.grid.bounds_mm())) {
      report.warn(
          "its box does not meet that of the bone, and would after a half turn about z: it or the bone is in RAS");
    }
    envelope.append(report, "clearance.envelope: ");
    return std::move(contents.mesh);
  }

  void add_envelope(const ClearanceEnvelopeSettings& settings, double cell_mm) {
    const TriangleMesh mesh = read_envelope(settings);
    std::map<std::tuple<int, int, int>, std::vector<SurfacePatch>> cells;
    for (const auto& triangle : mesh.triangles) {
      SurfacePatch patch;
      for (const Vec3& corner : mesh.corners(triangle)) patch.vertices[patch.count++] = corner;
      const auto& v = patch.vertices;
      const Vec3 normal = (v[1] - v[0]).cross(v[2] - v[0]);
      if (normal.norm() > 0) patch.normal = normal.normalized();
      patch.measure();
      const Vec3i cell = (patch.center / cell_mm).array().floor().cast<int>();
      cells[{cell.x(), cell.y(), cell.z()}].push_back(patch);
    }
    for (auto& [cell, patches] : cells) {
      Cluster cluster;
      cluster.obstacle = Obstacle::envelope;
      for (const SurfacePatch& patch : patches) cluster.middle += patch.center / static_cast<double>(patches.size());
      for (const SurfacePatch& patch : patches) {
        cluster.radius_mm = std::max(cluster.radius_mm, (patch.center - cluster.middle).norm() + patch.radius_mm);
      }
      cluster.patches = std::move(patches);
      cluster.built = true;
      clusters.push_back(std::move(cluster));
    }
  }

  BoneView bone_;
  VoxelCuts cuts_;
};

/// A holder at a pose.
class PosedHolder {
 public:
  PosedHolder(const std::vector<Profile>& parts, const ToolPose& pose)
      : parts_(parts), bone_from_tool_(pose.bone_from_tool()), tool_from_bone_(bone_from_tool_.inverse()) {}

  /// The smallest signed distance of a part from a point.
  [[nodiscard]] double distance_mm(const Vec3& point) const {
    double out = kFar;
    for (std::size_t part = 0; part < parts_.size(); ++part) out = std::min(out, distance_mm(part, point));
    return out;
  }
  [[nodiscard]] double distance_mm(std::size_t part, const Vec3& point) const {
    return parts_[part].nearest(rz_of(tool_from_bone_ * point)).distance_mm;
  }

  /// The distance of a part from a polygon, and the nearest point of that: by turns the nearest point of the one and of
  /// the other, because both are convex. Where they overlap, that of the deepest vertex.
  [[nodiscard]] std::pair<double, Vec3> between(std::size_t part, const SurfacePatch& patch, double voxel_mm) const {
    std::pair<double, Vec3> best{distance_mm(part, patch.center), patch.center};
    for (std::size_t i = 0; i < patch.count; ++i) {
      const double mm = distance_mm(part, patch.vertices[i]);
      if (mm < best.first) best = {mm, patch.vertices[i]};
    }
    for (int i = 0; i < kProjections && best.first > 0; ++i) {
      const Vec3 next = patch.nearest(nearest_point(part, best.second));
      const double mm = distance_mm(part, next);
      const bool settled = best.first - mm < kSettledVoxels * voxel_mm;
      if (mm < best.first) best = {mm, next};
      if (settled) break;
    }
    return best;
  }

  [[nodiscard]] Vec3 point_on_axis(double z) const { return bone_from_tool_ * Vec3(0, 0, z); }

 private:
  [[nodiscard]] Vec3 nearest_point(std::size_t part, const Vec3& point) const {
    const Vec3 p = tool_from_bone_ * point;
    const Profile::Nearest near = parts_[part].nearest(rz_of(p));
    return bone_from_tool_ * (p - near.distance_mm * Profile::normal_at(p, near));
  }

  const std::vector<Profile>& parts_;
  Rigid bone_from_tool_;
  Rigid tool_from_bone_;
};

/// Follows the holder along the motion.
class ClearanceSearch {
 public:
  ClearanceSearch(const BoneView& bone, const Tool& tool, const Motion& motion, const ClearanceSettings& settings)
      : settings_(tool.holder),
        motion_(motion),
        voxel_mm_(bone.voxmap.grid.voxel_mm),
        tool_(tool.profile),
        surfaces_(bone, tool, motion, settings) {
    for (const HolderPartSettings& part : settings_) {
      parts_.push_back(profile_of(part));
      reach_mm_ = std::max(reach_mm_, parts_.back().bounds().reach());
    }
  }

  [[nodiscard]] double reach_mm() const { return reach_mm_; }
  [[nodiscard]] const Diagnostics& said_of_envelope() const { return surfaces_.envelope; }

  /// The clearance at the next sample of the path.
  FrameClearance at(const PathSample& sample) {
    if (before_) way_mm_ += motion_bound_mm(*before_, sample.pose, reach_mm_);
    before_ = sample.pose;
    const PosedHolder holder(parts_, sample.pose);
    const Rigid tool_from_bone = sample.pose.bone_from_tool().inverse();
    FrameClearance best{.frame = static_cast<std::int64_t>(sample.frame), .mm = kFar};
    if (nearest_ != nullptr) measure(holder, tool_from_bone, *nearest_, best);
    std::vector<Cluster*> near;
    for (Cluster& cluster : surfaces_.clusters) {
      if (cluster.bound_mm - (way_mm_ - cluster.bound_at_mm) >= best.mm || &cluster == nearest_) continue;
      cluster.bound_mm = holder.distance_mm(cluster.middle) - cluster.radius_mm;
      cluster.bound_at_mm = way_mm_;
      if (cluster.bound_mm < best.mm) near.push_back(&cluster);
    }
    std::ranges::sort(near, {}, &Cluster::bound_mm);
    for (Cluster* cluster : near) {
      if (cluster->bound_mm >= best.mm) break;
      if (measure(holder, tool_from_bone, *cluster, best)) nearest_ = cluster;
    }
    if (best.mm > 0 && lies_in_bone(holder, best)) best.mm = -best.mm;
    best.pass = motion_.pass;
    best.frame += motion_.first_frame;
    return best;
  }

 private:
  /// Returns whether the cluster has a smaller distance than `best`, which is replaced.
  bool measure(const PosedHolder& holder, const Rigid& tool_from_bone, Cluster& cluster, FrameClearance& best) {
    surfaces_.build(cluster);
    bool found = false;
    for (const SurfacePatch& patch : cluster.patches) found |= measure(holder, patch, cluster.obstacle, best);
    for (const PassingVoxel& voxel : cluster.passing) {
      if (best.frame >= voxel.until) continue;
      if (holder.distance_mm(voxel.center) - kHalfDiagonalVoxels * voxel_mm_ >= best.mm) continue;
      const auto left = plane_beside(tool_, tool_from_bone, voxel.center, voxel_mm_);
      if (!left) continue;
      solid_.clear();
      surfaces_.add_solid(voxel, *left, solid_);
      for (const SurfacePatch& patch : solid_) found |= measure(holder, patch, cluster.obstacle, best);
    }
    return found;
  }

  bool measure(const PosedHolder& holder, const SurfacePatch& patch, Obstacle obstacle, FrameClearance& best) const {
    bool found = false;
    for (std::size_t part = 0; part < parts_.size(); ++part) {
      if (holder.distance_mm(part, patch.center) - patch.radius_mm >= best.mm) continue;
      const auto [mm, point] = holder.between(part, patch, voxel_mm_);
      if (mm >= best.mm) continue;
      best = {.frame = best.frame, .mm = mm, .part = part, .obstacle = obstacle, .point_mm = point};
      found = true;
    }
    return found;
  }

  /// A part may lie in bone so deep that it meets no surface.
  [[nodiscard]] bool lies_in_bone(const PosedHolder& holder, FrameClearance& best) const {
    for (std::size_t part = 0; part < parts_.size(); ++part) {
      const double middle_mm = 0.5 * (settings_[part].from_z_mm + settings_[part].to_z_mm);
      if (!surfaces_.in_bone(holder.point_on_axis(middle_mm))) continue;
      best.part = part;
      return true;
    }
    return false;
  }

  const std::vector<HolderPartSettings>& settings_;
  const Motion& motion_;
  double voxel_mm_;
  const Profile& tool_;
  Surfaces surfaces_;
  std::vector<Profile> parts_;
  std::vector<SurfacePatch> solid_;
  double reach_mm_ = 0;
  Cluster* nearest_ = nullptr;  ///< at the sample before
  std::optional<ToolPose> before_;
  double way_mm_ = 0;
};

/// Adds the frames of a pass.
void add_pass(const BoneView& bone, const Tool& tool, const Motion& motion, const ClearanceSettings& settings,
              HolderClearance& out) {
  ClearanceSearch search(bone, tool, motion, settings);
  out.envelope = search.said_of_envelope();
  BoundedPath path(search.reach_mm(), kMeasuredStepVoxels * bone.voxmap.grid.voxel_mm, {}, kMostMeasured);
  path.add(motion.poses);
  for (const PathSample& sample : path.finish()) {
    const FrameClearance here = search.at(sample);
    if (here.mm == kFar) continue;
    out.frames.push_back(here);
    if (here.mm < out.least.mm) out.least = here;
    if (here.mm > 0 && here.mm >= settings.least_mm) continue;
    if (!out.first_below) out.first_below = here.frame;
    out.last_below = here.frame;
  }
}

}  // namespace

std::string holder_part_name(const Scenario& scenario, const FrameClearance& clearance) {
  const PassSpec pass = passes_of(scenario)[static_cast<std::size_t>(clearance.pass) - 1];
  const std::string& name = pass.tool.holder[clearance.part].name;
  return name.empty() ? "holder " + std::to_string(clearance.part + 1) : name;
}

std::optional<HolderClearance> find_clearance(const SimulationInput& scene) {
  HolderClearance out;
  out.least.mm = kFar;
  for_each_predicted_pass(scene, [&](const FillBricks& fill, const Tool& tool, const Motion& motion) {
    if (tool.holder.empty() || motion.poses.empty()) return;
    add_pass({*scene.bone.voxmap, fill}, tool, motion, scene.scenario.clearance, out);
  });
  return out.frames.empty() ? std::nullopt : std::optional(out);
}

std::string sentence_of(const HolderClearance& clearance, const SimulationInput& scene) {
  const FrameClearance& least = clearance.least;
  const std::string part = holder_part_name(scene.scenario, least);
  const std::string place =
      fmt::format("the {} at {} mm, in frame {} ({:.3f} s)", name_of(least.obstacle), point_text(least.point_mm),
                  least.frame, static_cast<double>(least.frame) * scene.motion.frame_s());
  if (least.mm <= 0) {
    return fmt::format("clearance of the holder: none, {} touches {}, {:.2f} mm deep", part, place, -least.mm);
  }
  return fmt::format("clearance of the holder: at least {:.2f} mm, {} from {}", least.mm, part, place);
}

void warn_of_clearance(const HolderClearance& clearance, const SimulationInput& scene, Diagnostics& report) {
  report.append(clearance.envelope);
  if (!clearance.first_below) return;
  report.warn(fmt::format("{}; less than clearance.least_mm ({:g} mm) between frames {} and {}",
                          sentence_of(clearance, scene), scene.scenario.clearance.least_mm, *clearance.first_below,
                          *clearance.last_below));
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/scene.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/base/parallel.h"
#include "sim/bone/voxel_surface.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

struct Ray {
  Vec3 from_mm;
  Vec3 direction;
};

/// A part of a ray, mm along it.
struct Span {
  double begin_mm;
  double end_mm;
};

/// The part of a ray in a box; empty where begin ≥ end.
Span clipped(const Ray& ray, const Aabb& box, Span span) {
  for (int axis = 0; axis < 3; ++axis) {
    if (ray.direction[axis] == 0) {
      if (ray.from_mm[axis] < box.min[axis] || ray.from_mm[axis] >= box.max[axis]) return {0, 0};
      continue;
    }
    const double a = (box.min[axis] - ray.from_mm[axis]) / ray.direction[axis];
    const double b = (box.max[axis] - ray.from_mm[axis]) / ray.direction[axis];
    span = {std::max(span.begin_mm, std::min(a, b)), std::min(span.end_mm, std::max(a, b))};
  }
  return span;
}

/// Calls visit(cell, span) for the cells from `first` to `last` of a lattice with cell (0,0,0) at `origin_mm`, in the
/// order of the ray within `span`, until a visit returns true (Amanatides and Woo 1987).
template <class Visit>
bool walk(const Ray& ray, const Vec3& origin_mm, double cell_mm, const Vec3i& first, const Vec3i& last, Span span,
          const Visit& visit) {
  const Vec3 place = (ray.from_mm + span.begin_mm * ray.direction - origin_mm) / cell_mm;
  Vec3i cell = place.array().floor().cast<int>();
  cell = cell.cwiseMax(first).cwiseMin(last);
  Vec3 next_mm;
  for (int axis = 0; axis < 3; ++axis) {
    const double side_mm = origin_mm[axis] + cell_mm * (cell[axis] + (ray.direction[axis] > 0 ? 1 : 0));
    next_mm[axis] = ray.direction[axis] == 0 ? kNever : (side_mm - ray.from_mm[axis]) / ray.direction[axis];
  }
  double at_mm = span.begin_mm;
  for (;;) {
    int axis = 0;
    next_mm.minCoeff(&axis);
    const double end_mm = std::min(next_mm[axis], span.end_mm);
    if (visit(cell, Span{at_mm, end_mm})) return true;
    if (next_mm[axis] >= span.end_mm) return false;
    at_mm = std::max(at_mm, end_mm);
    cell[axis] += ray.direction[axis] > 0 ? 1 : -1;
    if (cell[axis] < first[axis] || cell[axis] > last[axis]) return false;
    next_mm[axis] += cell_mm / std::abs(ray.direction[axis]);
  }
}

/// Where a ray meets the bone of a voxel.
std::optional<double> met_in_voxel(const BoneView& bone, const Ray& ray, const Vec3i& voxel, const Span& span) {
  const std::optional<VoxelPlane> plane = voxel_plane(bone, voxel, -ray.direction);
  if (!plane) return span.begin_mm;
  const double begin =
      plane->normal.dot(ray.from_mm + span.begin_mm * ray.direction - bone.voxmap.grid.center_mm(voxel)) -
      plane->offset_mm;
  if (begin <= 0) return span.begin_mm;
  const double slope = plane->normal.dot(ray.direction);
  const double at_mm = slope < 0 ? span.begin_mm - begin / slope : kNever;
  return at_mm <= span.end_mm ? std::optional(at_mm) : std::nullopt;
}

/// Distance along `direction`, a unit vector, at which a ray from `from_mm` (B) first meets bone: a whole voxel, or the
/// part of another one below its plane (voxel_plane()). nullopt where it meets none within `most_mm`.
std::optional<double> first_bone_mm(const BoneView& bone, const Vec3& from_mm, const Vec3& direction, double most_mm) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const Ray ray{from_mm, direction};
  const Span within = clipped(ray, grid.bounds_mm(), {0, most_mm});
  if (within.begin_mm >= within.end_mm) return std::nullopt;
  std::optional<double> met;
  const auto visit_brick = [&](const Vec3i& coord, const Span& in_brick) {
    const GradeBricks::Brick* grades = bone.voxmap.grade.brick(coord);
    if (grades == nullptr || in_brick.begin_mm >= in_brick.end_mm) return false;
    const Vec3i first = BrickLattice::kSide * coord;
    const Vec3i last = (first + Vec3i::Constant(BrickLattice::kSide)).cwiseMin(grid.dims) - Vec3i::Ones();
    return walk(ray, grid.origin_mm, grid.voxel_mm, first, last, in_brick, [&](const Vec3i& voxel, const Span& span) {
      if ((*grades)[static_cast<std::size_t>(BrickLattice::offset_of(voxel))] == 0) return false;
      if (bone.fill.get(voxel) == 0) return false;
      met = met_in_voxel(bone, ray, voxel, span);
      return met.has_value();
    });
  };
  walk(ray, grid.origin_mm, grid.voxel_mm * BrickLattice::kSide, Vec3i::Zero(),
       bone.voxmap.grade.brick_dims() - Vec3i::Ones(), within, visit_brick);
  return met && *met <= most_mm ? met : std::nullopt;
}

/// Distances of neighbouring rays, voxels: of those that bound the travel, and of those that find it.
constexpr double kCoarse_voxels = 2;
constexpr double kFine_voxels = 0.125;
/// Halvings of the distance of the rays around the first contact.
constexpr int kHalvings = 5;
constexpr double kMargin_voxels = 1;
/// A ray ends this far behind the travel that another one has found, because of rounding.
constexpr double kSlack_voxels = 1e-3;
/// The outermost circles of an envelope, and those beside its bore, pass along the wall of a hole that the same reamer
/// has left, whose place is known to parts of a voxel. Bone that they meet counts if the envelope also meets bone this
/// much farther from its edge, at most so much later; or if it meets no other.
constexpr double kRim_voxels = 0.75;
constexpr double kLater_voxels = 1;

/// Lowest z of a closed profile at a radius, the points of its outline included; infinite where it has none.
double lowest_z(const Profile& profile, double r) {
  double out = kNever;
  for_each_side(profile.points, [&](const Vec2& a, const Vec2& b) {
    if (r < std::min(a.x(), b.x()) || r > std::max(a.x(), b.x())) return;
    const double width = b.x() - a.x();
    const double z =
        width == 0 ? std::min(a.y(), b.y()) : a.y() + (b.y() - a.y()) * std::clamp((r - a.x()) / width, 0.0, 1.0);
    out = std::min(out, z);
  });
  return out;
}

/// A circle of points of the envelope that face the bone.
struct Ring {
  double radius_mm;
  double low_mm;  ///< z of T
};

/// Rings at the corners of the profile, and between them at most `spacing_mm` apart.
std::vector<Ring> rings_of(const Profile& profile, double spacing_mm) {
  std::vector<double> radii;
  for (const Vec2& p : profile.points) radii.push_back(p.x());
  const double last_mm = profile.max_radius_mm();
  const int count = static_cast<int>(std::ceil(last_mm / spacing_mm));
  for (int i = 0; i <= count; ++i) radii.push_back(last_mm * i / count);
  std::ranges::sort(radii);
  radii.erase(std::unique(radii.begin(), radii.end()), radii.end());
  std::vector<Ring> out;
  for (const double r : radii) {
    if (const double z = lowest_z(profile, r); z < kNever) out.push_back({r, z});
  }
  return out;
}

/// A ray along the line of the tool, and the travel at which the envelope meets bone on it.
struct RayHit {
  double travel_mm = kNever;
  Vec2 place_mm = Vec2::Zero();  ///< across the line
  double bone_mm = 0;            ///< the bone's point along the line
};

/// Ray casts of the envelope onto the bone.
class ContactRays {
 public:
  ContactRays(const BoneView& bone, const Profile& envelope, const Vec3& through_mm, const Vec3& direction,
              double rim_mm)
      : bone_(bone),
        envelope_(envelope),
        through_mm_(through_mm),
        axes_(orientation_from_axis(direction).toRotationMatrix()),
        bore_mm_(std::ranges::min_element(envelope.points, {}, [](const Vec2& p) { return p.x(); })->x()),
        rim_mm_(rim_mm) {
    const VoxelGrid& grid = bone.voxmap.grid;
    const Aabb box = grid.bounds_mm().expanded(kMargin_voxels * grid.voxel_mm);
    start_mm_ = kNever;
    end_mm_ = -kNever;
    for (int corner = 0; corner < 8; ++corner) {
      const double at_mm = (box.corner(corner) - through_mm_).dot(axes_.col(2));
      start_mm_ = std::min(start_mm_, at_mm);
      end_mm_ = std::max(end_mm_, at_mm);
    }
  }

  /// The least travel of all.
  [[nodiscard]] RayHit first() const {
    const double voxel_mm = bone_.voxmap.grid.voxel_mm, fine_mm = kFine_voxels * voxel_mm;
    const RayHit coarse = least(kCoarse_voxels * voxel_mm, kNever);
    const RayHit fine = least(fine_mm, coarse.travel_mm + kSlack_voxels * voxel_mm);
    // The fine rays are others: a spike of bone may lie between the fine or between the coarse ones.
    if (std::min(fine.travel_mm, coarse.travel_mm) == kNever) return coarse;
    return refined(fine.travel_mm <= coarse.travel_mm ? fine : coarse, fine_mm);
  }

  [[nodiscard]] Vec3 bone_mm(const RayHit& meeting) const { return point_mm(meeting.place_mm, meeting.bone_mm); }

 private:
  /// The least travel on rays `spacing_mm` apart, if it is at most `most_mm`.
  [[nodiscard]] RayHit least(double spacing_mm, double most_mm) const {
    const std::vector<Ring> rings = rings_of(envelope_, spacing_mm);
    std::vector<RayHit> found(rings.size());
    parallel_items(rings.size(), [&](std::size_t i) { found[i] = least_on(rings[i], spacing_mm, most_mm); });
    return *std::ranges::min_element(found, {}, &RayHit::travel_mm);
  }

  /// Follows the least travel to places between the rays.
  [[nodiscard]] RayHit refined(RayHit best, double spacing_mm) const {
    for (int halving = 0; halving < kHalvings; ++halving) {
      spacing_mm /= 2;
      for (bool moved = true; moved;) {
        moved = false;
        for (const Vec2& step : {Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)}) {
          const Vec2 place_mm = best.place_mm + spacing_mm * step;
          const RayHit tried = at(place_mm, lowest_z(envelope_, place_mm.norm()), best.travel_mm);
          if (tried.travel_mm >= best.travel_mm) continue;
          best = tried;
          moved = true;
        }
      }
    }
    return best;
  }

  [[nodiscard]] Vec3 point_mm(const Vec2& place_mm, double along_mm) const {
    return through_mm_ + axes_ * Vec3(place_mm.x(), place_mm.y(), along_mm);
  }

  [[nodiscard]] RayHit least_on(const Ring& ring, double spacing_mm, double most_mm) const {
    const int count = std::max(1, static_cast<int>(std::ceil(2 * std::numbers::pi * ring.radius_mm / spacing_mm)));
    RayHit best{.travel_mm = most_mm};
    bool any = false;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      const Vec2 place_mm = ring.radius_mm * Vec2(std::cos(angle), std::sin(angle));
      const RayHit here = at(place_mm, ring.low_mm, best.travel_mm);
      if (here.travel_mm > best.travel_mm || (any && here.travel_mm == best.travel_mm)) continue;
      best = here;
      any = true;
    }
    return any ? best : RayHit{};
  }

  /// The meeting on one ray, where the envelope begins at `low_mm`.
  [[nodiscard]] RayHit at(const Vec2& place_mm, double low_mm, double most_mm) const {
    if (low_mm == kNever) return {};
    const double ray_mm = std::min(end_mm_, most_mm - low_mm) - start_mm_;
    if (ray_mm < 0) return {};
    const auto met = first_bone_mm(bone_, point_mm(place_mm, start_mm_), axes_.col(2), ray_mm);
    if (!met) return {};
    const double bone_mm = start_mm_ + *met;
    const RayHit here{bone_mm + low_mm, place_mm, bone_mm};
    return is_wall(here) ? RayHit{} : here;
  }

  /// Whether only the rim of the envelope, or that of its bore, meets bone here.
  [[nodiscard]] bool is_wall(const RayHit& meeting) const {
    const double radius_mm = meeting.place_mm.norm(), first_mm = bore_mm_ + rim_mm_;
    const double last_mm = envelope_.max_radius_mm() - rim_mm_;
    if (rim_mm_ == 0 || last_mm < first_mm + rim_mm_) return false;  // a narrow ring is all rim
    double further_mm = radius_mm;
    if (radius_mm > last_mm) further_mm = radius_mm - rim_mm_;
    if (bore_mm_ > 0 && radius_mm < first_mm) further_mm = radius_mm + rim_mm_;
    if (further_mm == radius_mm) return false;
    const Vec2 place_mm = further_mm / radius_mm * meeting.place_mm;
    const double later_mm = kLater_voxels * bone_.voxmap.grid.voxel_mm;
    return at(place_mm, lowest_z(envelope_, further_mm), meeting.travel_mm + later_mm).travel_mm == kNever;
  }

  BoneView bone_;
  const Profile& envelope_;
  Vec3 through_mm_;
  Mat3 axes_;       ///< of the line; z is its direction
  double bore_mm_;  ///< radius
  double rim_mm_;   ///< 0: bone that only a rim meets counts
  double start_mm_;
  double end_mm_;
};

}  // namespace

std::optional<FirstContact> find_first_contact(const BoneView& bone, const Profile& envelope, const Vec3& through_mm,
                                               const Vec3& direction) {
  for (const double rim_mm : {kRim_voxels * bone.voxmap.grid.voxel_mm, 0.0}) {
    const ContactRays rays(bone, envelope, through_mm, direction, rim_mm);
    const RayHit first = rays.first();
    if (first.travel_mm == kNever) continue;
    return FirstContact{first.travel_mm, through_mm + first.travel_mm * direction, rays.bone_mm(first)};
  }
  return std::nullopt;
}

FirstContact find_first_contact(const Bone& bone, const Tool& tool, const Vec3& entry_mm, const Vec3& axis,
                                PoseFrame frame, const std::string& section) {
  const Rigid bone_from_poses = bone_from_frame(frame, bone.glenoid).value_or(Rigid::Identity());
  const std::optional<FirstContact> found = find_first_contact(bone, tool.profile, bone_from_poses * entry_mm,
                                                               (bone_from_poses.linear() * axis).normalized());
  if (found) return *found;
  throw InputError({}, section + ".entry_mm",
                   "the tool meets no bone on the line of the " + section.substr(section.rfind('.') + 1),
                   "give a point from which axis leads to the bone, or use from: entry");
}

std::string sentence_of(const FirstContact& contact) {
  const Vec3& p = contact.bone_mm;
  return fmt::format(
      "plunge: first contact {:.4f} mm {} entry_mm, at the point ({:.2f}, {:.2f}, {:.2f}) mm of the bone; the depth "
      "counts from there",
      std::abs(contact.travel_mm), contact.travel_mm < 0 ? "before" : "beyond", p.x(), p.y(), p.z());
}

}  // namespace reamsim

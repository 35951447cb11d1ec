#include "sim/bone/find_glenoid.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/error.h"
#include "sim/bone/bone_probe.h"
#include "sim/bone/frame_check.h"
#include "sim/bone/glenoid_rim.h"
#include "sim/bone/pear_outline.h"

namespace reamsim {

namespace {

constexpr double kFarthestStart_mm = 15;  // of the surface from the given point
constexpr double kApart_mm = 3;           // starts nearer to each other count as one
constexpr int kCoarse = 24, kFine = 90;   // directions of the walks
constexpr std::size_t kFineSearches = 2;
constexpr int kCoarseTurns = 4, kFineTurns = 12;
constexpr double kRest_mm = 0.01, kRest_rad = 1e-4;
constexpr double kMargin_mm = 2.5;  // from the rim, where it is rounded; at most a quarter of the radius
constexpr double kGrid_mm = 1;      // of the points of the face
/// A face is refused beyond these.
constexpr double kLeastHeight_mm = 15, kMostHeight_mm = 60;
constexpr double kLeastScore = 0.35, kDoubtfulScore = 0.5;
constexpr double kLeastRim = 0.5;  // of the directions
constexpr double kMostConvexity_per_mm = 1.0 / 80;
/// A residual of the sphere beyond this, with the part of the face that it fits, means more than one surface.
constexpr double kOneSurface_mm = 0.45;

/// A face in the course of the search.
struct Face {
  Rigid bone_from_face = Rigid::Identity();  ///< origin on the surface, +z out of the bone
  Rigid old_frame = Rigid::Identity();       ///< of walk and fit, one turn earlier
  RimWalk walk;
  OutlineFit fit;
  FaceSurface surface;
  FaceNormal normal = FaceNormal::sphere;

  /// Of all directions, those with a rim on the pear.
  [[nodiscard]] double rim_fraction() const {
    return fit.inlier_fraction * static_cast<double>(walk.rim_mm.size()) / walk.directions;
  }
};

Rigid frame_at(const Vec3& origin_mm, const Vec3& outward) {
  Rigid out;
  const Vec3 x = outward.unitOrthogonal();
  out.linear() << x, outward.cross(x), outward;
  out.translation() = origin_mm;
  return out;
}

/// Points of the face at a distance from the outline, in B.
std::vector<Vec3> points_inside(const BoneProbe& probe, const Face& face) {
  const PearOutline& outline = face.fit.outline;
  const double margin_mm = std::min(kMargin_mm, outline.radius_mm / 4), reach_mm = outline.height_mm / 2;
  double top_mm = 0;
  for (const Vec3& p : face.walk.rim_mm) top_mm = std::max(top_mm, p.z());
  constexpr double kAbove_mm = 2;
  const Vec3 down = -face.bone_from_face.linear().col(2);
  std::vector<Vec3> out;
  for (double y = -reach_mm; y <= reach_mm; y += kGrid_mm) {
    for (double x = -reach_mm; x <= reach_mm; x += kGrid_mm) {
      const Vec2 place = outline.center_mm + Vec2(x, y);
      if (outline.distance_mm(place) > -margin_mm) continue;
      const Vec3 from = face.bone_from_face * Vec3(place.x(), place.y(), top_mm + kAbove_mm);
      if (const auto fall = probe.distance_to_bone(from, down, top_mm + kAbove_mm + reach_mm)) {
        out.push_back(from + *fall * down);
      }
    }
  }
  return out;
}

/// Root mean square distance of the points from the surface that describes them.
double rms_of(const FaceSurface& surface, const std::vector<Vec3>& points) {
  double squares = 0;
  for (const Vec3& p : points) {
    const double off = surface.spherical ? (p - surface.sphere->center_mm).norm() - surface.sphere->radius_mm
                                         : (p - surface.plane.point_mm).dot(surface.plane.normal);
    squares += off * off;
  }
  return std::sqrt(squares / static_cast<double>(points.size()));
}

/// Whether the face bulges like a humeral head.
bool is_convex(const FaceSurface& surface) {
  return surface.spherical && !surface.concave && 1 / surface.sphere->radius_mm > kMostConvexity_per_mm;
}

/// The normal of the plane through the rim points that lie near the outline.
std::optional<Vec3> rim_normal(const Face& face) {
  std::vector<Vec3> rim;
  for (const Vec3& p : face.walk.rim_mm) {
    if (std::abs(face.fit.outline.distance_mm(p.head<2>())) <= 2 * kRimInlier_mm) rim.push_back(p);
  }
  const auto plane = fit_plane(rim, Vec3::UnitZ());
  if (!plane) return std::nullopt;
  return Vec3(face.bone_from_face.linear() * plane->normal);
}

/// The direction out of the face at a point of it, and where it comes from.
std::optional<Vec3> normal_at(const Vec3& point_mm, const std::vector<Vec3>& points, Face& face) {
  const bool one_surface = rms_of(face.surface, points) <= kOneSurface_mm;
  const Vec3 outward = face.bone_from_face.linear().col(2);
  face.normal = !one_surface ? FaceNormal::rim : face.surface.spherical ? FaceNormal::sphere : FaceNormal::plane;
  if (face.normal == FaceNormal::sphere) {
    const Vec3 way = (face.surface.sphere->center_mm - point_mm).normalized();
    return way.dot(outward) < 0 ? Vec3(-way) : way;
  }
  if (face.normal == FaceNormal::plane) return face.surface.plane.normal;
  return rim_normal(face);
}

/// Walks to the rim, fits, and moves the frame to the middle of the face; returns whether there is a face, and in
/// `moved` how far the frame moved and turned.
bool settle(const BoneProbe& probe, int directions, Face& face, Vec2& moved) {
  face.walk = walk_to_rim(probe, face.bone_from_face, directions);
  std::vector<Vec2> places;
  double top_mm = 0;
  for (const Vec3& p : face.walk.rim_mm) {
    places.push_back(p.head<2>());
    top_mm = std::max(top_mm, p.z());
  }
  const auto fit = fit_pear(places);
  if (!fit || fit->outline.height_mm > 2 * kMostHeight_mm) return false;
  face.fit = *fit;
  const std::vector<Vec3> points = points_inside(probe, face);
  const Vec3 outward = face.bone_from_face.linear().col(2);
  const auto surface =
      fit_face({.points_mm = points, .point_mm2 = kGrid_mm * kGrid_mm, .voxel_mm = probe.voxel_mm()}, outward);
  if (!surface) return false;
  face.surface = *surface;
  const Vec2 middle = fit->outline.center_mm;
  const Vec3 from = face.bone_from_face * Vec3(middle.x(), middle.y(), top_mm + 1);
  const auto fall = probe.distance_to_bone(from, -outward, top_mm + 1 + fit->outline.radius_mm);
  if (!fall) return false;
  const Vec3 center = from - *fall * outward;
  const auto normal = normal_at(center, points, face);
  if (!normal) return false;
  moved = {(center - face.bone_from_face.translation()).norm(), std::acos(std::clamp(normal->dot(outward), -1.0, 1.0))};
  face.old_frame = face.bone_from_face;
  face.bone_from_face = frame_at(center, *normal);
  return true;
}

/// A face from a start on the surface; nullopt where the search leads nowhere.
std::optional<Face> face_from(const BoneProbe& probe, const Rigid& start, int directions, int turns) {
  Face face;
  face.bone_from_face = start;
  Vec2 moved = Vec2::Zero();
  for (int turn = 0; turn < turns; ++turn) {
    if (!settle(probe, directions, face, moved)) return std::nullopt;
    if (moved.x() < kRest_mm && moved.y() < kRest_rad) break;
  }
  return face;
}

/// Points of the surface round a point, with directions out of the bone.
std::vector<Rigid> starts_round(const BoneView& bone, const BoneProbe& probe, const Vec3& near_mm) {
  constexpr double kRadius_mm = 6;
  std::vector<Rigid> out;
  for_each_voxel(Vec3i::Constant(-1), Vec3i::Constant(1), [&](const Vec3i& step) {
    if (step == Vec3i::Zero()) return;
    const Vec3 way = step.cast<double>().normalized();
    auto at = probe.distance_to_bone(near_mm, way, kFarthestStart_mm);
    if (!at) at = probe.distance_to_air(near_mm, way, kFarthestStart_mm);
    if (!at) return;
    const Vec3 point = near_mm + *at * way;
    const auto close = [&](const Rigid& other) { return (other.translation() - point).norm() < kApart_mm; };
    if (std::any_of(out.begin(), out.end(), close)) return;
    const Vec3 outward = nearby_bone(bone.voxmap, point, way, kRadius_mm).outward;
    if (outward != Vec3::Zero()) out.push_back(frame_at(point, outward));
  });
  return out;
}

/// How much a face is one: the larger, the better.
double score_of(const Face& face, const Vec3& near_mm) {
  constexpr double kRmsWeight = 0.2, kDistanceWeight = 0.02, kSlimPenalty = 0.3, kRoughPenalty = 0.1;
  constexpr double kSlimmest = 1.9;  // height over width; 1.3 to 1.5 is usual
  const double size_mm = face.fit.outline.height_mm;
  if (size_mm < kLeastHeight_mm || size_mm > kMostHeight_mm || is_convex(face.surface)) return -1;
  return face.rim_fraction() - kRmsWeight * face.fit.rms_mm -
         kDistanceWeight * (face.bone_from_face.translation() - near_mm).norm() -
         (size_mm > kSlimmest * 2 * face.fit.outline.radius_mm ? kSlimPenalty : 0) -
         (face.normal == FaceNormal::rim ? kRoughPenalty : 0);
}

[[noreturn]] void fail(const Vec3& near_mm, const std::string& found, const std::string& expected) {
  throw InputError({}, "bone.glenoid.near_mm",
                   fmt::format("({:.1f}, {:.1f}, {:.1f}): ", near_mm.x(), near_mm.y(), near_mm.z()) + found, expected);
}

/// Faces that the search finds from both ends of a doubtful one, which may have grown into the base of the coracoid.
std::vector<Face> faces_beside(const BoneProbe& probe, const Face& face) {
  constexpr double kAside = 0.2, kAbove_mm = 4;  // of the height
  std::vector<Face> out;
  const Vec2 axis = face.fit.outline.axis();
  const Vec3 along = face.old_frame.linear() * Vec3(axis.x(), axis.y(), 0);
  const Vec3 outward = face.bone_from_face.linear().col(2);
  for (const double side : {-kAside, kAside}) {
    const Vec3 from =
        face.bone_from_face.translation() + side * face.fit.outline.height_mm * along + kAbove_mm * outward;
    const auto fall = probe.distance_to_bone(from, -outward, 3 * kAbove_mm);
    if (!fall) continue;
    if (const auto found = face_from(probe, frame_at(from - *fall * outward, outward), kFine, kFineTurns)) {
      out.push_back(*found);
    }
  }
  return out;
}

Face best_face(const BoneView& bone, const BoneProbe& probe, const Vec3& near_mm) {
  const std::vector<Rigid> starts = starts_round(bone, probe, near_mm);
  if (starts.empty()) {
    fail(near_mm, fmt::format("no surface of the bone within {:g} mm", kFarthestStart_mm),
         "give a point on the face of the glenoid, in the bone frame");
  }
  std::vector<Face> coarse;
  for (const Rigid& start : starts) {
    if (const auto face = face_from(probe, start, kCoarse, kCoarseTurns)) coarse.push_back(*face);
  }
  const auto better = [&](const Face& a, const Face& b) { return score_of(a, near_mm) > score_of(b, near_mm); };
  std::stable_sort(coarse.begin(), coarse.end(), better);
  coarse.resize(std::min<std::size_t>(coarse.size(), kFineSearches));
  std::optional<Face> best;
  for (const Face& face : coarse) {
    const auto fine = face_from(probe, face.bone_from_face, kFine, kFineTurns);
    if (fine && (!best || better(*fine, *best))) best = fine;
  }
  if (best && score_of(*best, near_mm) < kDoubtfulScore) {
    for (const Face& beside : faces_beside(probe, *best)) {
      if (better(beside, *best)) best = beside;
    }
  }
  if (!best || score_of(*best, near_mm) < kLeastScore || best->rim_fraction() < kLeastRim) {
    fail(near_mm,
         best ? fmt::format("no joint face round the point: {:.0f} % of the directions meet a rim",
                            100 * best->rim_fraction())
              : "no joint face round the point",
         "give a point within 8 mm of the centre of the face; separate the humerus from the scapula; or give "
         "bone.glenoid.center_mm, normal and superior");
  }
  return *best;
}

/// Superior across the normal, and whether it was guessed from the shape of the face.
std::pair<Vec3, bool> superior_of(const Face& face, const BoneView& bone, const GlenoidSettings& settings) {
  if (settings.superior) return {*settings.superior, false};
  if (settings.landmarks) return {settings.landmarks->glenoid_center_mm - settings.landmarks->inferior_angle_mm, false};
  const Vec2 axis = face.fit.outline.axis();
  const Vec3 along = face.old_frame.linear() * Vec3(axis.x(), axis.y(), 0);
  constexpr double kLeastUp = 0.3;
  if (bone.voxmap.frame == "mesh" || std::abs(along.z()) < kLeastUp) return {along, true};
  return {along.z() < 0 ? Vec3(-along) : along, false};
}

}  // namespace

FoundGlenoid find_glenoid(const BoneView& bone, const GlenoidSettings& settings, BodySide side) {
  const BoneProbe probe(bone);
  const Face face = best_face(bone, probe, *settings.near_mm);
  FoundGlenoid out;
  const auto [superior, guessed] = superior_of(face, bone, settings);
  GlenoidSettings directions;
  directions.center_mm = face.bone_from_face.translation();
  directions.normal = Vec3(face.bone_from_face.linear().col(2));
  directions.superior = superior;
  out.frame = *glenoid_frame(directions, side);
  for (const Vec3& p : face.walk.rim_mm) {
    if (std::abs(face.fit.outline.distance_mm(p.head<2>())) <= 2 * kRimInlier_mm)
      out.rim_mm.push_back(face.old_frame * p);
  }
  out.normal = face.normal;
  out.height_mm = face.fit.outline.height_mm;
  out.width_mm = 2 * face.fit.outline.radius_mm;
  out.rim_fraction = face.rim_fraction();
  out.rim_rms_mm = face.fit.rms_mm;
  out.face_rms_mm = face.surface.rms_mm;
  out.radius_mm = face.surface.spherical ? face.surface.sphere->radius_mm : 0;
  out.superior_guessed = guessed;
  return out;
}

std::string sentence_of(const FoundGlenoid& found) {
  const Vec3 c = found.frame.bone_from_glenoid.translation();
  const Mat3 axes = found.frame.bone_from_glenoid.linear();
  const auto text = [](const Vec3& v, int digits) {
    return fmt::format("[{:.{}f}, {:.{}f}, {:.{}f}]", v.x(), digits, v.y(), digits, v.z(), digits);
  };
  const char* from = found.normal == FaceNormal::sphere ? "towards the centre of the sphere that fits the face"
                     : found.normal == FaceNormal::plane
                         ? "of the plane that fits the face"
                         : "of the plane through the rim, because the face is no single surface";
  return fmt::format(
      "glenoid found: center_mm {}, normal {} ({}), superior {}{}; {:.1f} x {:.1f} mm, rim in {:.0f} % of the "
      "directions "
      "within {:.2f} mm (rms) of a pear, face within {:.2f} mm (rms){}",
      text(c, 1), text(axes.col(2), 3), from, text(axes.col(1), 3),
      found.superior_guessed ? " (towards the narrow end of the face; check it)" : "", found.height_mm, found.width_mm,
      100 * found.rim_fraction, found.rim_rms_mm, found.face_rms_mm,
      found.radius_mm > 0 ? fmt::format(" of a sphere of radius {:.1f} mm", found.radius_mm) : " of a plane");
}

std::vector<std::string> doubts_of(const FoundGlenoid& found) {
  constexpr double kClearRim = 0.75, kRoughFace_mm = 0.6;
  constexpr double kLeastUsual_mm = 25, kMostUsual_mm = 48;
  const std::string look =
      "; look at the pictures, and give bone.glenoid.center_mm, normal and superior if they are wrong";
  std::vector<std::string> out;
  if (found.rim_fraction < kClearRim) {
    out.push_back(
        fmt::format("the glenoid was found with little confidence: only {:.0f} % of the directions meet its rim",
                    100 * found.rim_fraction) +
        look);
  }
  if (found.face_rms_mm > kRoughFace_mm) {
    out.push_back(fmt::format("the glenoid was found with little confidence: its face is rough, {:.1f} mm (rms)",
                              found.face_rms_mm) +
                  look);
  }
  if (found.height_mm < kLeastUsual_mm || found.height_mm > kMostUsual_mm) {
    out.push_back(
        fmt::format("the face that was found is {:.0f} mm high, a glenoid usually 30 to 45 mm", found.height_mm) +
        look);
  }
  if (found.superior_guessed) {
    out.push_back(
        "superior was taken from the shape of the face, towards its narrow end: give bone.glenoid.superior or "
        "landmarks to be sure");
  }
  return out;
}

}  // namespace reamsim

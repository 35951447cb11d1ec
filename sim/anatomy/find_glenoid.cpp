// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/find_glenoid.h"

#include <fmt/core.h>
#include <algorithm>
#include <functional>
#include <limits>
#include <map>

#include "sim/base/parallel.h"

namespace reamsim {

namespace {

constexpr double kFarthestStart_mm = 15;  // of the surface from the given point
constexpr double kFarthestFace_mm = 15;
constexpr double kApart_mm = 3;  // starts nearer to each other count as one
constexpr std::size_t kFineSearches = 4;
constexpr double kLeastScore = 0.35, kDoubtfulScore = 0.5;  // a face is refused below these
constexpr double kLeastRim = 0.5;                           // of the directions

constexpr double kStartsApart_mm = 5;
constexpr double kPlacesApart_mm = 8;  // faces nearer to each other are one
constexpr double kLeastVault_mm = 10;  // an acromion is 8 to 9 mm thick
constexpr double kDeepVault_mm = 20;
constexpr double kLeastFree_mm = 12;       // in front of the face
constexpr double kLeastCoarseScore = 0.3;  // score of a face that is fitted finely
constexpr FitEffort kSearchEffort{20, 3};
constexpr std::size_t kFinePlaces = 6;
/// Sizes beyond these are no glenoid.
constexpr double kShortest_mm = 20, kTallest_mm = 52, kNarrowest_mm = 14, kWidest_mm = 42;

struct Ball {
  Vec3 center_mm = Vec3::Zero();
  double radius_mm = std::numeric_limits<double>::infinity();
};

/// A voxel of the surface in each cell of kStartsApart_mm, that nearest to the middle of the cell.
std::vector<Vec3> spread_over(const BoneView& bone, const Ball& within) {
  struct Nearest {
    double away_mm;
    Vec3 point_mm;
  };
  const auto by_coordinates = [](const Vec3i& a, const Vec3i& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::map<Vec3i, Nearest, decltype(by_coordinates)> cells(by_coordinates);
  for_each_bone_voxel(bone, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t) {
    const Vec3 point = bone.voxmap.grid.center_mm(voxel);
    if ((point - within.center_mm).norm() > within.radius_mm || !has_air_beside(bone.voxmap, voxel)) return;
    const Vec3i cell = (point / kStartsApart_mm).array().floor().cast<int>();
    const double away_mm = (point - kStartsApart_mm * (cell.cast<double>() + Vec3::Constant(0.5))).norm();
    const auto [at, first] = cells.try_emplace(cell, Nearest{away_mm, point});
    if (!first && away_mm < at->second.away_mm) at->second = {away_mm, point};
  });
  std::vector<Vec3> out;
  for (const auto& [cell, nearest] : cells) out.push_back(nearest.point_mm);
  return out;
}

/// Thickness of the bone behind a point of the surface, at most kDeepVault_mm; 0 where something stands in front of it.
double vault_behind(const BoneProbe& probe, const Vec3& point_mm, const Vec3& outward) {
  constexpr double kInside_mm = 1.5;
  if (probe.distance_to_bone(point_mm + kInside_mm * outward, outward, kLeastFree_mm)) return 0;
  const Vec3 inside = point_mm - kInside_mm * outward;
  if (probe.fraction(inside) < 0.5) return 0;
  return std::min(kInside_mm + probe.distance_to_air(inside, -outward, kDeepVault_mm).value_or(kDeepVault_mm),
                  kDeepVault_mm);
}

/// Frames every 5 mm on the surface in a region where the bone is thick and nothing stands in front of it.
std::vector<Rigid> starts_on_surface(const BoneView& bone, const BoneProbe& probe, const Ball& within) {
  constexpr double kRadius_mm = 6;
  std::vector<Rigid> out;
  for (const Vec3& point : spread_over(bone, within)) {
    const Vec3 outward = nearby_bone(bone.voxmap, point, Vec3::UnitZ(), kRadius_mm).outward;
    if (outward == Vec3::Zero()) continue;
    const Vec3 above = point + 2 * probe.voxel_mm() * outward;
    const auto fall = probe.distance_to_bone(above, -outward, 4 * probe.voxel_mm());
    if (!fall) continue;
    const Vec3 surface = above - *fall * outward;
    // The normal of a start deviates from that of its face, so its vault may be less.
    if (vault_behind(probe, surface, outward) >= 0.7 * kLeastVault_mm) out.push_back(frame_at(surface, outward));
  }
  return out;
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

/// face_score(), the nearer the better; -1 for a face beyond the point.
double score_of(const FittedFace& face, const Vec3& near_mm) {
  constexpr double kDistanceWeight = 0.02;
  const double score = face_score(face);
  const double away_mm = (face.bone_from_face.translation() - near_mm).norm();
  return score < 0 || away_mm > kFarthestFace_mm ? -1 : score - kDistanceWeight * away_mm;
}

[[noreturn]] void fail(const Vec3& near_mm, const std::string& found, const std::string& expected) {
  throw InputError({}, "bone.glenoid.near_mm", point_text(near_mm) + ": " + found, expected);
}

/// The faces to which `fit(i)` leads for each of `count` items, in their order; computed in parallel.
std::vector<FittedFace> fit_all(std::size_t count, const std::function<std::optional<FittedFace>(std::size_t)>& fit) {
  std::vector<std::optional<FittedFace>> found(count);
  parallel_items(count, [&](std::size_t i) { found[i] = fit(i); });
  std::vector<FittedFace> out;
  for (auto& face : found) {
    if (face) out.push_back(std::move(*face));
  }
  return out;
}

/// The first `most` faces that are no repetition of one before, settled finely.
std::vector<FittedFace> fitted_finely(const BoneProbe& probe, const std::vector<FittedFace>& coarse, std::size_t most) {
  constexpr double kSame_mm = 1.5, kSameNormal = 0.98;  // a cosine
  std::vector<FittedFace> distinct;
  for (const FittedFace& face : coarse) {
    const Rigid& one = face.bone_from_face;
    const auto same = [&](const FittedFace& face_before) {
      const Rigid& other = face_before.bone_from_face;
      return (one.translation() - other.translation()).norm() < kSame_mm &&
             one.linear().col(2).dot(other.linear().col(2)) > kSameNormal;
    };
    if (distinct.size() < most && std::ranges::none_of(distinct, same)) distinct.push_back(face);
  }
  return fit_all(distinct.size(),
                 [&](std::size_t i) { return fit_face(probe, distinct[i].bone_from_face, kFineEffort); });
}

/// Faces from starts towards both ends of one, which may have grown into the base of the coracoid.
std::vector<FittedFace> faces_beside(const BoneProbe& probe, const FittedFace& face) {
  constexpr double kAside[] = {-0.3, -0.15, 0.15, 0.3}, kAbove_mm = 4;  // of the height
  const Vec3 along = face.fit.outline.height_mm * face.along(), outward = face.bone_from_face.linear().col(2);
  return fit_all(std::size(kAside), [&](std::size_t i) -> std::optional<FittedFace> {
    const Vec3 from = face.bone_from_face.translation() + kAside[i] * along + kAbove_mm * outward;
    const auto fall = probe.distance_to_bone(from, -outward, 3 * kAbove_mm);
    if (!fall) return std::nullopt;
    return fit_face(probe, frame_at(from - *fall * outward, outward), kFineEffort);
  });
}

/// The best face from several starts; nullopt where they lead nowhere.
std::optional<FittedFace> best_from(const BoneProbe& probe, const std::vector<Rigid>& starts, const Vec3& near_mm) {
  std::vector<FittedFace> coarse =
      fit_all(starts.size(), [&](std::size_t i) { return fit_face(probe, starts[i], kCoarseEffort); });
  const auto worth = [&](const FittedFace& face) { return -score_of(face, near_mm); };
  std::ranges::stable_sort(coarse, {}, worth);
  const std::vector<FittedFace> fine = fitted_finely(probe, coarse, kFineSearches);
  const auto best = std::ranges::min_element(fine, {}, worth);
  return best == fine.end() ? std::nullopt : std::optional(*best);
}

/// Replaces a face by a better one. A doubtful one by starts all over the surface, because rays from a point beside a
/// deep face may meet its walls only. Then any by starts towards both of its ends, because the search rests in more
/// than one outline, above all where the rim passes into the base of the coracoid, and which one depended on the point.
void improve(const BoneView& bone, const BoneProbe& probe, const Vec3& near_mm, std::optional<FittedFace>& best) {
  if (!best || score_of(*best, near_mm) < kDoubtfulScore) {
    const auto face = best_from(probe, starts_on_surface(bone, probe, {near_mm, kFarthestStart_mm}), near_mm);
    const bool clear = face && place_of(probe, *face).confidence >= kDoubtfulScore;
    if (clear && (!best || score_of(*face, near_mm) > score_of(*best, near_mm))) best = face;
  }
  if (!best) return;
  for (const FittedFace& beside : faces_beside(probe, *best)) {
    // These are outlines of the same joint: the distance from the point does not count.
    if (score_of(beside, near_mm) > 0 && face_score(beside) > face_score(*best)) best = beside;
  }
}

FittedFace best_face(const BoneView& bone, const BoneProbe& probe, const Vec3& near_mm) {
  const std::vector<Rigid> starts = starts_round(bone, probe, near_mm);
  if (starts.empty()) {
    fail(near_mm, fmt::format("no surface of the bone within {:g} mm", kFarthestStart_mm),
         "give a point on the face of the glenoid, in the bone frame");
  }
  std::optional<FittedFace> best = best_from(probe, starts, near_mm);
  improve(bone, probe, near_mm, best);
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
std::pair<Vec3, bool> superior_of(const FittedFace& face, const BoneView& bone, const GlenoidSettings& settings) {
  if (settings.superior) return {*settings.superior, false};
  if (settings.landmarks) return {settings.landmarks->glenoid_center_mm - settings.landmarks->inferior_angle_mm, false};
  const Vec3 along = face.along();
  constexpr double kLeastUp = 0.3;
  if (bone.voxmap.frame == "mesh" || std::abs(along.z()) < kLeastUp) return {along, true};
  return {along.z() < 0 ? Vec3(-along) : along, false};
}

std::string sentence_of(const FittedFace& face, const GlenoidFrame& frame, double confidence, bool superior_guessed) {
  const Vec3 c = frame.bone_from_glenoid.translation();
  const Mat3 axes = frame.bone_from_glenoid.linear();
  const auto text = [](const Vec3& v, int digits) {
    return fmt::format("[{:.{}f}, {:.{}f}, {:.{}f}]", v.x(), digits, v.y(), digits, v.z(), digits);
  };
  const char* from = face.normal == FaceNormal::sphere ? "towards the centre of the sphere that fits the face"
                     : face.normal == FaceNormal::plane
                         ? "of the plane that fits the face"
                         : "of the plane through the rim, because the face is no single surface";
  const FaceSurface& surface = face.surface;
  return fmt::format(
      "glenoid found: center_mm {}, normal {} ({}), superior {}{}; {:.1f} x {:.1f} mm, rim in {:.0f} % of the "
      "directions "
      "within {:.2f} mm (rms) of a pear, face within {:.2f} mm (rms){}; confidence {:.2f}",
      text(c, 1), text(axes.col(2), 3), from, text(axes.col(1), 3),
      superior_guessed ? " (towards the narrow end of the face; check it)" : "", face.fit.outline.height_mm,
      2 * face.fit.outline.radius_mm, 100 * face.rim_fraction(), face.fit.rms_mm, surface.rms_mm,
      surface.spherical ? fmt::format(" of a sphere of radius {:.1f} mm", surface.sphere->radius_mm) : " of a plane",
      confidence);
}

/// What makes the frame uncertain; nothing where it can be trusted.
std::vector<std::string> doubts_of(const FittedFace& face, bool superior_guessed) {
  constexpr double kClearRim = 0.75, kRoughFace_mm = 0.6;
  constexpr double kLeastUsual_mm = 25, kMostUsual_mm = 48;
  std::vector<std::string> out;
  const auto doubt = [&](bool doubtful, const std::string& why) {
    const char* look = "; look at the pictures, and give bone.glenoid.center_mm, normal and superior if they are wrong";
    if (doubtful) out.push_back(why + look);
  };
  const double rim = face.rim_fraction(), height_mm = face.fit.outline.height_mm;
  doubt(rim < kClearRim,
        fmt::format("the glenoid was found with little confidence: only {:.0f} % of the directions meet its rim",
                    100 * rim));
  doubt(face.surface.rms_mm > kRoughFace_mm,
        fmt::format("the glenoid was found with little confidence: its face is rough, {:.1f} mm (rms)",
                    face.surface.rms_mm));
  doubt(height_mm < kLeastUsual_mm || height_mm > kMostUsual_mm,
        fmt::format("the face that was found is {:.0f} mm high, a glenoid usually 30 to 45 mm", height_mm));
  if (superior_guessed) {
    out.push_back(
        "superior was taken from the shape of the face, towards its narrow end: give bone.glenoid.superior or "
        "landmarks to be sure");
  }
  return out;
}

/// 1 for a size within limits, falling to 0 towards `least` and `most`.
double size_score(double mm, double least, double usual_least, double usual_most, double most) {
  return std::clamp(std::min((mm - least) / (usual_least - least), (most - mm) / (most - usual_most)), 0.0, 1.0);
}

/// The best of the faces as places, none near another.
std::vector<std::pair<FacePlace, const FittedFace*>> best_places(const BoneProbe& probe,
                                                                 const std::vector<FittedFace>& faces) {
  std::vector<std::pair<FacePlace, const FittedFace*>> all, out;
  for (const FittedFace& face : faces) all.emplace_back(place_of(probe, face), &face);
  std::ranges::stable_sort(all, {}, [](const auto& entry) { return -entry.first.confidence; });
  for (const auto& entry : all) {
    const auto same = [&](const auto& other) {
      return (other.first.center_mm - entry.first.center_mm).norm() < kPlacesApart_mm;
    };
    if (entry.first.confidence > 0 && std::ranges::none_of(out, same)) out.push_back(entry);
  }
  return out;
}

}  // namespace

FoundGlenoid find_glenoid(const BoneView& bone, const GlenoidSettings& settings, BodySide side) {
  const BoneProbe probe(bone);
  const FittedFace face = best_face(bone, probe, *settings.near_mm);
  FoundGlenoid out;
  const auto [superior, guessed] = superior_of(face, bone, settings);
  GlenoidSettings directions;
  directions.center_mm = face.bone_from_face.translation();
  directions.normal = Vec3(face.bone_from_face.linear().col(2));
  directions.superior = superior;
  out.frame = *glenoid_frame(directions, side);
  for (const Vec3& p : face.rim_at_outline_mm()) out.rim_mm.push_back(face.old_frame * p);
  out.sentence = sentence_of(face, out.frame, place_of(probe, face).confidence, guessed);
  out.doubts = doubts_of(face, guessed);
  return out;
}

FacePlace place_of(const BoneProbe& probe, const FittedFace& face) {
  FacePlace out{.center_mm = face.bone_from_face.translation(),
                .normal = face.bone_from_face.linear().col(2),
                .height_mm = face.fit.outline.height_mm,
                .width_mm = 2 * face.fit.outline.radius_mm};
  const double vault_mm = vault_behind(probe, out.center_mm, out.normal);
  const double size = size_score(out.height_mm, kShortest_mm, 26, 46, kTallest_mm) *
                      size_score(out.width_mm, kNarrowest_mm, 19, 36, kWidest_mm);
  const double vault = std::clamp((vault_mm - kLeastVault_mm) / (15 - kLeastVault_mm), 0.0, 1.0);
  out.confidence = std::clamp(face_score(face), 0.0, 1.0) * std::sqrt(size * vault);
  return out;
}

std::optional<FacePlace> place_at(const BoneView& bone, const Rigid& bone_from_face) {
  const BoneProbe probe(bone);
  const auto face = fit_face(probe, bone_from_face, kFineEffort);
  return face ? std::optional(place_of(probe, *face)) : std::nullopt;
}

std::vector<FacePlace> search_faces(const BoneView& bone) {
  const BoneProbe probe(bone);
  const std::vector<Rigid> starts = starts_on_surface(bone, probe, {});
  const std::vector<FittedFace> coarse = fit_all(starts.size(), [&](std::size_t i) -> std::optional<FittedFace> {
    auto face = fit_face(probe, starts[i], kSearchEffort);
    return face && face_score(*face) >= kLeastCoarseScore ? face : std::nullopt;
  });
  const auto chosen = best_places(probe, coarse);
  const std::vector<FittedFace> fine = fit_all(std::min(chosen.size(), kFinePlaces), [&](std::size_t i) {
    return fit_face(probe, chosen[i].second->bone_from_face, kFineEffort);
  });
  std::vector<FacePlace> out;
  for (const auto& [place, face] : best_places(probe, fine)) out.push_back(place);
  return out;
}

}  // namespace reamsim

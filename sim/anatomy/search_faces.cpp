// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/search_faces.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "sim/anatomy/fit_face.h"
#include "sim/anatomy/frame_check.h"

namespace reamsim {

namespace {

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

bool is_at_surface(const Voxmap& voxmap, const Vec3i& voxel) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const int step : {-1, 1}) {
      const Vec3i beside = voxel + step * Vec3i::Unit(axis);
      if (!voxmap.grid.contains(beside) || voxmap.grade.get(beside) == 0) return true;
    }
  }
  return false;
}

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
    if ((point - within.center_mm).norm() > within.radius_mm || !is_at_surface(bone.voxmap, voxel)) return;
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

/// The start at a voxel of the surface; nullopt where the bone is thin or something stands in front of it.
std::optional<Rigid> start_at(const BoneView& bone, const BoneProbe& probe, const Vec3& point_mm) {
  constexpr double kRadius_mm = 6;
  const Vec3 outward = nearby_bone(bone.voxmap, point_mm, Vec3::UnitZ(), kRadius_mm).outward;
  if (outward == Vec3::Zero()) return std::nullopt;
  const Vec3 above = point_mm + 2 * probe.voxel_mm() * outward;
  const auto fall = probe.distance_to_bone(above, -outward, 4 * probe.voxel_mm());
  if (!fall) return std::nullopt;
  const Vec3 surface = above - *fall * outward;
  // The normal of a start deviates from that of its face, so its vault may be less.
  if (vault_behind(probe, surface, outward) < 0.7 * kLeastVault_mm) return std::nullopt;
  return frame_at(surface, outward);
}

/// 1 for a size within limits, falling to 0 towards `least` and `most`.
double size_score(double mm, double least, double usual_least, double usual_most, double most) {
  return std::clamp(std::min((mm - least) / (usual_least - least), (most - mm) / (most - usual_most)), 0.0, 1.0);
}

/// The best of the faces, none near another.
std::vector<FacePlace> best_places(const BoneProbe& probe, const std::vector<FittedFace>& faces,
                                   std::vector<FittedFace>* of = nullptr) {
  std::vector<std::pair<FacePlace, const FittedFace*>> all;
  for (const FittedFace& face : faces) all.emplace_back(place_of(probe, face), &face);
  std::ranges::stable_sort(all, {}, [](const auto& entry) { return -entry.first.confidence; });
  std::vector<FacePlace> out;
  for (const auto& entry : all) {
    const FacePlace& place = entry.first;
    const auto same = [&](const FacePlace& other) {
      return (other.center_mm - place.center_mm).norm() < kPlacesApart_mm;
    };
    if (place.confidence <= 0 || std::ranges::any_of(out, same)) continue;
    out.push_back(place);
    if (of != nullptr) of->push_back(*entry.second);
  }
  return out;
}

}  // namespace

FacePlace place_of(const BoneProbe& probe, const FittedFace& face) {
  FacePlace out{.center_mm = face.bone_from_face.translation(),
                .normal = face.bone_from_face.linear().col(2),
                .height_mm = face.fit.outline.height_mm,
                .width_mm = 2 * face.fit.outline.radius_mm};
  out.vault_mm = vault_behind(probe, out.center_mm, out.normal);
  const double size = size_score(out.height_mm, kShortest_mm, 26, 46, kTallest_mm) *
                      size_score(out.width_mm, kNarrowest_mm, 19, 36, kWidest_mm);
  const double vault = std::clamp((out.vault_mm - kLeastVault_mm) / (15 - kLeastVault_mm), 0.0, 1.0);
  out.confidence = std::clamp(face_score(face), 0.0, 1.0) * std::sqrt(size * vault);
  return out;
}

std::optional<FacePlace> place_at(const BoneView& bone, const Rigid& bone_from_face) {
  const BoneProbe probe(bone);
  const auto face = fit_face(probe, bone_from_face, kFineEffort);
  return face ? std::optional(place_of(probe, *face)) : std::nullopt;
}

std::vector<Rigid> starts_on_surface(const BoneView& bone, const BoneProbe& probe, const Ball& within) {
  std::vector<Rigid> out;
  for (const Vec3& point : spread_over(bone, within)) {
    if (const auto start = start_at(bone, probe, point)) out.push_back(*start);
  }
  return out;
}

std::vector<FacePlace> search_faces(const BoneView& bone) {
  const BoneProbe probe(bone);
  const std::vector<Rigid> starts = starts_on_surface(bone, probe, {});
  const std::vector<FittedFace> coarse = fit_all(starts.size(), [&](std::size_t i) -> std::optional<FittedFace> {
    auto face = fit_face(probe, starts[i], kSearchEffort);
    return face && face_score(*face) >= kLeastCoarseScore ? face : std::nullopt;
  });
  std::vector<FittedFace> chosen;
  best_places(probe, coarse, &chosen);
  chosen.resize(std::min(chosen.size(), kFinePlaces));
  return best_places(probe, fit_all(chosen.size(), [&](std::size_t i) {
                       return fit_face(probe, chosen[i].bone_from_face, kFineEffort);
                     }));
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/segment.h"

#include <fmt/core.h>
#include <algorithm>

namespace reamsim::ct {

namespace {

/// Width of the Gaussian on a label map: it smooths the voxel steps and keeps a plate of one voxel.
constexpr double kLabelSmoothing_voxels = 0.6;

Mask above_threshold(const AlignedImage& hu, const CtSettings& settings, Diagnostics& report) {
  Mask mask(hu.value.size());
  std::ranges::transform(hu.value, mask.begin(), [&](float value) { return double{value} >= settings.threshold_hu; });
  const std::int64_t voxels = std::ranges::count(mask, 1);
  if (voxels == 0) {
    const float highest = *std::max_element(hu.value.begin(), hu.value.end());
    throw InputError(
        {settings.path}, "bone.ct.threshold_hu",
        fmt::format("no bone in the crop: the maximum of {} voxels has {:.0f} HU, the threshold is {:.0f} HU",
                    mask.size(), highest, settings.threshold_hu),
        "lower the threshold or move the crop; it spans " + box_text(hu.lattice.bounds_mm()));
  }
  report.note(
      fmt::format("threshold {:.0f} HU: {} of {} voxels at or above", settings.threshold_hu, voxels, mask.size()));
  return mask;
}

/// Removes the cuts from the mask; returns the number of removed voxels.
std::int64_t apply_cuts(Mask& mask, const Lattice& lattice, const CtSettings& settings) {
  if (settings.cut_spheres.empty() && settings.cut_planes.empty()) return 0;
  std::int64_t removed = 0;
  lattice.for_each([&](const Vec3i& c, std::size_t at) {
    if (!mask[at] || !is_cut_away(settings, lattice.center_mm(c))) return;
    mask[at] = 0;
    ++removed;
  });
  return removed;
}

/// A closed and filled piece, on a box around it with a margin for the closing.
struct SolidPiece {
  IndexBox box;
  Lattice lattice;
  Mask mask;
  Piece piece;
  std::int64_t closed = 0;
  std::int64_t filled = 0;

  [[nodiscard]] bool contains(const Vec3i& voxel) const {
    const Vec3i c = voxel - box.start;
    return lattice.contains(c) && mask[lattice.index(c)];
  }
};

SolidPiece solidify(const Pieces& pieces, const Piece& piece, const Lattice& lattice, const CtSettings& settings) {
  SolidPiece out;
  out.piece = piece;
  const Vec3i room = (settings.closing_mm * lattice.spacing_mm.cwiseInverse()).array().ceil().cast<int>() + 2;
  out.box = box_around(piece.min, piece.max, room, lattice);
  out.lattice = lattice.part(out.box);
  for (const std::uint32_t label : part_of(pieces.label, lattice, out.box)) out.mask.push_back(label == piece.label);
  close_mask(out.mask, out.lattice, settings.closing_mm);
  apply_cuts(out.mask, out.lattice, settings);
  out.closed = std::ranges::count(out.mask, 1) - piece.voxels;
  if (settings.fill_holes) {
    out.filled = fill_holes(out.mask, out.lattice);
    out.filled -= apply_cuts(out.mask, out.lattice, settings);  // a cut that bone encloses is no hole
  }
  return out;
}

SolidPiece choose_piece(const Pieces& pieces, const AlignedImage& hu, const CtSettings& settings) {
  const Lattice& lattice = hu.lattice;
  if (!settings.seed_mm) return solidify(pieces, pieces.list.front(), lattice, settings);
  const Vec3i seed = lattice.voxel_of(*settings.seed_mm);
  if (!lattice.contains(seed)) {
    throw InputError({settings.path}, "bone.ct.seed_mm",
                     point_text(*settings.seed_mm) + " lies outside the image or crop",
                     "expected a point in " + box_text(lattice.bounds_mm()));
  }
  for (const Piece& piece : pieces.list) {  // the largest is first
    if ((seed.array() < piece.min.array()).any() || (seed.array() > piece.max.array()).any()) continue;
    SolidPiece solid = solidify(pieces, piece, lattice, settings);
    if (solid.contains(seed)) return solid;
  }
  const float there = hu.value[lattice.index(seed)];
  throw InputError({settings.path}, "bone.ct.seed_mm",
                   fmt::format("{} lies outside bone: {:.0f} HU there, and no piece above {:.0f} HU encloses it",
                               point_text(*settings.seed_mm), there, settings.threshold_hu),
                   "give a point inside the bone to be kept, LPS, mm");
}

/// Adds the cut bone that touches the kept bone. The cut is applied again after resampling and makes the exact face;
/// without this margin the face would consist of steps of image voxels.
Mask with_cut_margin(const Mask& kept, const Mask& before_cuts, const Mask& after_cuts, const Lattice& lattice) {
  Mask out = dilated(kept, lattice, Vec3i::Ones());
  for (std::size_t at = 0; at < out.size(); ++at) {
    out[at] = kept[at] || (out[at] && before_cuts[at] && !after_cuts[at]) ? 1 : 0;
  }
  return out;
}

Segmentation facts_of(const Pieces& pieces, const SolidPiece& solid, std::int64_t cut, const CtSettings& settings,
                      const Lattice& lattice) {
  const auto mm3 = [&](std::int64_t voxels) { return static_cast<double>(voxels) * lattice.voxel_mm3(); };
  std::int64_t all = 0;
  for (const Piece& piece : pieces.list) all += piece.voxels;
  Segmentation out;
  out.method = "threshold";
  out.pieces = std::ssize(pieces.list);
  out.by_seed = settings.seed_mm.has_value();
  out.kept_rank = solid.piece.label;  // pieces are numbered by size
  out.kept_piece_mm3 = mm3(solid.piece.voxels);
  out.largest_mm3 = mm3(pieces.list[0].voxels);
  out.second_mm3 = pieces.list.size() > 1 ? mm3(pieces.list[1].voxels) : 0;
  out.dropped_mm3 = mm3(all - solid.piece.voxels);
  out.cut_mm3 = mm3(cut);
  out.closed_mm3 = mm3(solid.closed);
  out.filled_mm3 = mm3(solid.filled);
  return out;
}

/// Without a seed the choice of the largest piece may be wrong.
void warn_of_second_piece(const Segmentation& facts, Diagnostics& report) {
  constexpr double kAnotherBone = 0.05;  // smaller pieces are noise, calcifications or parts of ribs
  if (facts.by_seed || facts.second_mm3 < kAnotherBone * facts.largest_mm3) return;
  report.warn(fmt::format(
      "bone.ct.seed_mm is missing: the largest piece is kept, {:.0f} mm3. The second largest has {:.0f} mm3 and may "
      "be the intended bone: set bone.ct.seed_mm to a point inside it",
      facts.largest_mm3, facts.second_mm3));
}

/// Sets the number of bone voxels, their bounds, the trabecular ones among them, and the facts that follow.
void measure(BoneField& bone, const Mask& mask, const AlignedImage& hu, double threshold_hu) {
  Piece whole;
  hu.lattice.for_each([&](const Vec3i& c, std::size_t at) {
    if (!mask[at]) return;
    whole.add(c);
    if (static_cast<double>(hu.value[at]) < threshold_hu) ++bone.inside_below;
  });
  bone.voxels = whole.voxels;
  bone.min = whole.min;
  bone.max = whole.max;
  bone.facts.threshold_hu = threshold_hu;
  bone.facts.bone_mm3 = static_cast<double>(bone.voxels) * hu.lattice.voxel_mm3();
  bone.facts.below_threshold_fraction =
      bone.voxels > 0 ? static_cast<double>(bone.inside_below) / static_cast<double>(bone.voxels) : 0;
}

}  // namespace

bool is_cut_away(const CtSettings& settings, const Vec3& point_mm) {
  for (const CutSphereSettings& sphere : settings.cut_spheres) {
    if ((point_mm - sphere.center_mm).squaredNorm() < sphere.radius_mm * sphere.radius_mm) return true;
  }
  for (const CutPlaneSettings& plane : settings.cut_planes) {
    if (plane.normal.dot(point_mm - plane.point_mm) > 0) return true;
  }
  return false;
}

BoneField segment_by_threshold(const AlignedImage& hu, const CtSettings& settings, Diagnostics& report) {
  const Lattice& lattice = hu.lattice;
  const Mask dense = above_threshold(hu, settings, report);
  Mask after_cuts = dense;
  const std::int64_t removed = apply_cuts(after_cuts, lattice, settings);
  if (removed > 0) {
    report.note(fmt::format("cuts removed {} voxels above the threshold, {:.0f} mm3", removed,
                            static_cast<double>(removed) * lattice.voxel_mm3()));
  }
  const Pieces pieces = connected_pieces(after_cuts, lattice);
  if (pieces.list.empty()) {
    throw InputError({settings.path}, "bone.ct.cut_spheres, bone.ct.cut_planes", "the cuts remove all bone in the crop",
                     "a plane removes the side to which its normal points");
  }
  const SolidPiece solid = choose_piece(pieces, hu, settings);
  const double kept_mm3 = static_cast<double>(std::ranges::count(solid.mask, 1)) * lattice.voxel_mm3();
  report.note(fmt::format(
      "{} connected pieces; kept the {}, {:.0f} mm3 when closed ({} voxels added by {:.1f} mm) and filled ({} voxels)",
      pieces.list.size(), settings.seed_mm ? "one with the seed" : "largest", kept_mm3, solid.closed,
      settings.closing_mm, solid.filled));

  Mask kept(hu.value.size(), 0);
  solid.lattice.for_each(
      [&](const Vec3i& c, std::size_t at) { kept[lattice.index(c + solid.box.start)] = solid.mask[at]; });
  BoneField bone;
  bone.facts = facts_of(pieces, solid, removed, settings, lattice);
  warn_of_second_piece(bone.facts, report);
  measure(bone, kept, hu, settings.threshold_hu);
  bone.field.lattice = lattice;
  bone.field.value = signed_field(hu, settings.threshold_hu, with_cut_margin(kept, dense, after_cuts, lattice));
  return bone;
}

BoneField segment_by_label(LabelImages labels, const AlignedImage& hu, const CtSettings& settings,
                           Diagnostics& report) {
  const LabelMapSettings& map = *settings.label_map;
  check_label(labels, hu, settings, report);
  AlignedImage& selected = labels.selected;
  gaussian_filter(selected, kLabelSmoothing_voxels);
  for (float& value : selected.value) value -= 0.5F;
  if (map.refine_mm > 0) refine_to_isosurface(selected, labels.other, hu, map.refine_hu, map.refine_mm, report);
  BoneField bone;
  measure(bone, positive_voxels(selected), hu, settings.threshold_hu);
  if (bone.voxels == 0) {
    throw InputError({map.path}, "bone.ct.label_map.label",
                     "label " + words_of_labels(map.label) + " is thinner than a voxel everywhere in the crop",
                     "choose another label, or move the crop");
  }
  bone.facts.method = "label_map";
  report.note(
      fmt::format("label {}: {} voxels, {:.0f} mm3", words_of_labels(map.label), bone.voxels, bone.facts.bone_mm3));
  bone.field = std::move(selected);
  return bone;
}

}  // namespace reamsim::ct

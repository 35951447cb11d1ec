#include "sim/bone/ct/segment.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/bone/ct/refine_mask.h"
#include "sim/bone/ct/words.h"

namespace reamsim::ct {

namespace {

/// Magnitude of the field for a voxel that is exactly at the threshold, so that its sign still counts.
constexpr float kLeastField_hu = 1;
/// Width of the Gaussian on a label map: takes the stairs off, and leaves a plate one voxel thick in place.
constexpr double kLabelSmoothing_voxels = 0.6;

std::int64_t count(const Mask& mask) {
  return std::count(mask.begin(), mask.end(), std::uint8_t{1});
}

template <typename Visit>
void for_each_voxel(const Lattice& lattice, Visit visit) {
  for (int k = 0; k < lattice.dims.z(); ++k) {
    for (int j = 0; j < lattice.dims.y(); ++j) {
      for (int i = 0; i < lattice.dims.x(); ++i) visit(Vec3i(i, j, k), lattice.index(i, j, k));
    }
  }
}

Mask above_threshold(const AlignedImage& hu, const CtSettings& settings, Report& report) {
  Mask mask(hu.value.size());
  std::transform(hu.value.begin(), hu.value.end(), mask.begin(),
                 [&](float value) { return static_cast<double>(value) >= settings.threshold_hu ? 1 : 0; });
  const std::int64_t voxels = count(mask);
  if (voxels == 0) {
    const float highest = *std::max_element(hu.value.begin(), hu.value.end());
    throw InputError({settings.path}, "bone.ct.threshold_hu",
                     "no bone in the crop: the maximum of " + std::to_string(mask.size()) + " voxels has " +
                         fmt::format("{:.0f}", highest) + " HU, the threshold is " +
                         fmt::format("{:.0f}", settings.threshold_hu) + " HU",
                     "lower the threshold or move the crop; it spans " + box_words(hu.lattice.bounds_mm()));
  }
  report.note("threshold " + fmt::format("{:.0f}", settings.threshold_hu) + " HU: " + std::to_string(voxels) + " of " +
              std::to_string(mask.size()) + " voxels at or above");
  return mask;
}

/// Takes the cuts out of the mask; returns how many voxels went.
std::int64_t apply_cuts(Mask& mask, const Lattice& lattice, const CtSettings& settings) {
  if (settings.cut_spheres.empty() && settings.cut_planes.empty()) return 0;
  std::int64_t removed = 0;
  for_each_voxel(lattice, [&](const Vec3i& c, std::size_t at) {
    if (!mask[at] || !is_cut_away(settings, lattice.center_mm(c.x(), c.y(), c.z()))) return;
    mask[at] = 0;
    ++removed;
  });
  return removed;
}

/// A piece by itself: closed and filled on a box round it, which leaves room for the closing.
struct SolidPiece {
  Vec3i start = Vec3i::Zero();
  Lattice lattice;
  Mask mask;
  Piece piece;
  std::int64_t closed = 0;
  std::int64_t filled = 0;

  [[nodiscard]] bool contains(const Vec3i& voxel) const {
    const Vec3i c = voxel - start;
    return lattice.contains(c) && mask[lattice.index(c.x(), c.y(), c.z())];
  }
};

SolidPiece solidify(const Pieces& pieces, const Piece& piece, const Lattice& lattice, const CtSettings& settings) {
  SolidPiece out;
  out.piece = piece;
  const Vec3i room = (settings.closing_mm * lattice.spacing_mm.cwiseInverse()).array().ceil().cast<int>() + 2;
  out.start = (piece.min - room).cwiseMax(0);
  const Vec3i end = (piece.max + room + Vec3i::Ones()).cwiseMin(lattice.dims);
  out.lattice = {end - out.start, lattice.spacing_mm, lattice.center_mm(out.start.x(), out.start.y(), out.start.z())};
  out.mask.resize(static_cast<std::size_t>(out.lattice.size()));
  for_each_voxel(out.lattice, [&](const Vec3i& c, std::size_t at) {
    const Vec3i from = c + out.start;
    out.mask[at] = pieces.label[lattice.index(from.x(), from.y(), from.z())] == piece.label;
  });
  close_mask(out.mask, out.lattice, settings.closing_mm);
  apply_cuts(out.mask, out.lattice, settings);
  out.closed = count(out.mask) - piece.voxels;
  if (settings.fill_holes) out.filled = fill_holes(out.mask, out.lattice);
  return out;
}

/// Whether a piece, closed and filled, may reach as far as a voxel.
bool may_contain(const Piece& piece, const Vec3i& voxel) {
  return (voxel.array() >= piece.min.array()).all() && (voxel.array() <= piece.max.array()).all();
}

SolidPiece choose_piece(const Pieces& pieces, const AlignedImage& hu, const CtSettings& settings) {
  const Lattice& lattice = hu.lattice;
  if (!settings.seed_mm) return solidify(pieces, pieces.list.front(), lattice, settings);
  const Vec3i seed = lattice.voxel_of(*settings.seed_mm);
  if (!lattice.contains(seed)) {
    throw InputError({settings.path}, "bone.ct.seed_mm",
                     point_words(*settings.seed_mm) + " lies outside the image or crop",
                     "expected a point in " + box_words(lattice.bounds_mm()));
  }
  for (const Piece& piece : pieces.list) {  // the largest first
    if (!may_contain(piece, seed)) continue;
    SolidPiece solid = solidify(pieces, piece, lattice, settings);
    if (solid.contains(seed)) return solid;
  }
  const float there = hu.value[lattice.index(seed.x(), seed.y(), seed.z())];
  throw InputError({settings.path}, "bone.ct.seed_mm",
                   point_words(*settings.seed_mm) + " lies outside bone: " + fmt::format("{:.0f}", there) +
                       " HU there, and no piece above " + fmt::format("{:.0f}", settings.threshold_hu) +
                       " HU encloses it",
                   "give a point inside the bone to be kept, LPS, mm");
}

/// Bone that a cut took and that touches what is kept. It stays in the field, since the cut itself, applied again after
/// resampling, makes the exact face; without it the face would be a stair of image voxels.
Mask cut_rim(const Mask& kept, const Mask& before_cuts, const Mask& after_cuts, const Lattice& lattice) {
  Mask rim(kept.size(), 0);
  for_each_voxel(lattice, [&](const Vec3i& c, std::size_t at) {
    if (!before_cuts[at] || after_cuts[at]) return;
    const Vec3i low = (c - Vec3i::Ones()).cwiseMax(0);
    const Vec3i high = (c + Vec3i::Ones()).cwiseMin(lattice.dims - Vec3i::Ones());
    for (int k = low.z(); k <= high.z(); ++k) {
      for (int j = low.y(); j <= high.y(); ++j) {
        for (int i = low.x(); i <= high.x(); ++i) rim[at] |= kept[lattice.index(i, j, k)];
      }
    }
  });
  return rim;
}

void note_pieces(const Pieces& pieces, const SolidPiece& solid, const CtSettings& settings, const Lattice& lattice,
                 Report& report) {
  const double kept_mm3 = static_cast<double>(count(solid.mask)) * lattice.voxel_mm3();
  report.note(std::to_string(pieces.list.size()) + " connected pieces; kept the " +
              (settings.seed_mm ? "one with the seed" : "largest") + ", " + fmt::format("{:.0f}", kept_mm3) +
              " mm3 when closed (" + std::to_string(solid.closed) + " voxels added by " +
              fmt::format("{:.1f}", settings.closing_mm) + " mm) and filled (" + std::to_string(solid.filled) +
              " voxels)");
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

/// Without a seed nobody said which bone is meant.
void warn_of_second(const Segmentation& facts, Report& report) {
  constexpr double kAnotherBone = 0.05;  // smaller pieces are noise, calcifications, ribs' ends
  if (facts.by_seed || facts.second_mm3 < kAnotherBone * facts.largest_mm3) return;
  report.warn(fmt::format(
      "bone.ct.seed_mm is missing: the largest piece is kept, {:.0f} mm3. The second largest has {:.0f} mm3 and may "
      "be the intended bone: set bone.ct.seed_mm to a point inside it",
      facts.largest_mm3, facts.second_mm3));
}

/// The sums of `facts` that every way of segmentation has.
void finish_facts(BoneField& bone, const Lattice& lattice, double threshold_hu) {
  bone.facts.threshold_hu = threshold_hu;
  bone.facts.bone_mm3 = static_cast<double>(bone.voxels) * lattice.voxel_mm3();
  bone.facts.below_threshold_fraction =
      bone.voxels > 0 ? static_cast<double>(bone.inside_below) / static_cast<double>(bone.voxels) : 0;
}

/// Counts and bounds of the bone, and the trabecular part of it.
void measure(BoneField& bone, const Mask& mask, const AlignedImage& hu, double threshold_hu) {
  bone.min = hu.lattice.dims;
  bone.max = Vec3i::Constant(-1);
  for_each_voxel(hu.lattice, [&](const Vec3i& c, std::size_t at) {
    if (!mask[at]) return;
    ++bone.voxels;
    if (static_cast<double>(hu.value[at]) < threshold_hu) ++bone.inside_below;
    bone.min = bone.min.cwiseMin(c);
    bone.max = bone.max.cwiseMax(c);
  });
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

BoneField segment_by_threshold(const AlignedImage& hu, const CtSettings& settings, Report& report) {
  const Lattice& lattice = hu.lattice;
  const Mask dense = above_threshold(hu, settings, report);
  Mask parted = dense;
  const std::int64_t removed = apply_cuts(parted, lattice, settings);
  if (removed > 0) {
    report.note("cuts removed " + std::to_string(removed) + " voxels above the threshold, " +
                fmt::format("{:.0f}", static_cast<double>(removed) * lattice.voxel_mm3()) + " mm3");
  }
  const Pieces pieces = connected_pieces(parted, lattice);
  if (pieces.list.empty()) {
    throw InputError({settings.path}, "bone.ct.cut_spheres, bone.ct.cut_planes", "the cuts remove all bone in the crop",
                     "a plane removes the side to which its normal points");
  }
  const SolidPiece solid = choose_piece(pieces, hu, settings);
  note_pieces(pieces, solid, settings, lattice, report);

  Mask kept(hu.value.size(), 0);
  for_each_voxel(solid.lattice, [&](const Vec3i& c, std::size_t at) {
    const Vec3i to = c + solid.start;
    kept[lattice.index(to.x(), to.y(), to.z())] = solid.mask[at];
  });
  BoneField bone;
  bone.facts = facts_of(pieces, solid, removed, settings, lattice);
  warn_of_second(bone.facts, report);
  measure(bone, kept, hu, settings.threshold_hu);
  finish_facts(bone, lattice, settings.threshold_hu);
  const Mask rim = cut_rim(kept, dense, parted, lattice);
  bone.field.lattice = lattice;
  bone.field.value.resize(hu.value.size());
  for (std::size_t at = 0; at < kept.size(); ++at) {
    const float size = std::max(std::abs(hu.value[at] - static_cast<float>(settings.threshold_hu)), kLeastField_hu);
    bone.field.value[at] = kept[at] || rim[at] ? size : -size;
  }
  return bone;
}

BoneField segment_by_label(LabelImages labels, const AlignedImage& hu, const CtSettings& settings, Report& report) {
  const LabelMapSettings& map = *settings.label_map;
  AlignedImage& share = labels.share;
  gaussian_filter(share, kLabelSmoothing_voxels);
  for (float& value : share.value) value -= 0.5F;
  if (map.refine_mm > 0) refine_to_isosurface(share, labels.other, hu, map.refine_hu, map.refine_mm, report);
  Mask mask(share.value.size());
  std::transform(share.value.begin(), share.value.end(), mask.begin(), [](float value) { return value > 0 ? 1 : 0; });
  BoneField bone;
  measure(bone, mask, hu, settings.threshold_hu);
  if (bone.voxels == 0) {
    throw InputError({map.path}, "bone.ct.label_map.label",
                     "label " + words_of_labels(map.label) + " is thinner than a voxel everywhere in the crop",
                     "choose another label, or move the crop");
  }
  bone.facts.method = "label_map";
  finish_facts(bone, hu.lattice, settings.threshold_hu);
  report.note("label " + words_of_labels(map.label) + ": " + std::to_string(bone.voxels) + " voxels, " +
              fmt::format("{:.0f}", static_cast<double>(bone.voxels) * hu.lattice.voxel_mm3()) + " mm3");
  bone.field = std::move(share);
  return bone;
}

}  // namespace reamsim::ct

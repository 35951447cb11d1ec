// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/basis/touched_basis.h"

#include <algorithm>

#include "sim/base/parallel.h"

namespace reamsim {

/// As rs_voxel_force().
BasisValues TouchedBasis::response(const UnitArgs& args, const Vec3i& voxel) const {
  const OutlineView outline = view_of(outline_);
  const SubstepArgs& a = args.without_normal;
  BrickMiddle brick;
  rs_brick_in_tool(&a, voxel.x(), voxel.y(), voxel.z(), &brick);
  Clip clip{};
  rs_voxel_in_tool(&a, &brick, static_cast<float>(voxel.x() & 7), static_cast<float>(voxel.y() & 7),
                   static_cast<float>(voxel.z() & 7), clip.p);
  const float r = RS_SQRT(clip.p[0] * clip.p[0] + clip.p[1] * clip.p[1]);
  rs_outline_normal(&outline, rs_pieces_near(&outline, r, clip.p[2]), clip.p, clip.n);
  return unit_response(args, clip, static_cast<float>(voxmap_->grid.voxel_mm3()));
}

std::vector<SubstepBasis> TouchedBasis::of(std::span<const SubstepArgs> args, const RemovedFrames& removed) const {
  RemovedFrames ordered = removed;
  std::ranges::sort(ordered, {}, [](const auto& voxel) { return std::pair(voxel.second, voxel.first); });
  std::vector<SubstepBasis> out(args.size());
  parallel_items(args.size(), [&](std::size_t slot) {
    const auto slot_of = [](const auto& voxel) { return voxel.second; };
    const auto begin = std::ranges::lower_bound(ordered, static_cast<std::int32_t>(slot), {}, slot_of);
    const auto end = std::ranges::upper_bound(begin, ordered.end(), static_cast<std::int32_t>(slot), {}, slot_of);
    if (begin == end) return;
    const UnitArgs units(args[slot], 0);
    BrickBasis sums(1);
    for (auto at = begin; at != end; ++at) {
      const Vec3i voxel = voxmap_->grid.coord(at->first);
      sums.add(0, voxmap_->grade.get(voxel), RS_WHOLE_FILL, response(units, voxel));
    }
    VisitBasis whole(1);
    whole.add(sums);
    out[slot] = std::move(whole.substeps().front());
  });
  return out;
}

}  // namespace reamsim

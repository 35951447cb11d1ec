// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include "sim/scan/segmentation.h"

namespace reamsim {

namespace {

std::string bone_of(const Segmentation& s) {
  if (s.method == "label_map") {
    return fmt::format("segmentation: label map, {:.0f} mm3 of bone, {:.1f} % below {:.0f} HU", s.bone_mm3,
                       100 * s.below_threshold_fraction, s.threshold_hu);
  }
  return fmt::format(
      "segmentation: threshold {:.0f} HU, {} pieces, kept {} (rank {} by size); {:.0f} mm3 of bone, {:.1f} % "
      "below the threshold",
      s.threshold_hu, s.pieces, s.by_seed ? "the one with the seed" : "the largest", s.kept_rank, s.bone_mm3,
      100 * s.below_threshold_fraction);
}

std::string steps_of(const Segmentation& s) {
  if (s.method == "label_map") return "";
  return fmt::format("; discarded {:.0f} mm3, cut {:.0f} mm3, added by closing {:.0f} mm3, by filling {:.0f} mm3",
                     s.dropped_mm3, s.cut_mm3, s.closed_mm3, s.filled_mm3);
}

}  // namespace

std::string sentence_of(const Segmentation& s) {
  return bone_of(s) + steps_of(s) +
         fmt::format("; on {:.1f} % of its surface the density is a lower bound", 100 * s.lower_bound_fraction);
}

}  // namespace reamsim

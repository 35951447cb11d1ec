#include "sim/bone/ct/segmentation.h"

#include <cstdio>

namespace reamsim {

namespace {

std::string bone_of(const Segmentation& s) {
  char text[200];
  if (s.method == "label_map") {
    std::snprintf(text, sizeof text, "segmentation: label map, %.0f mm3 of bone, %.1f %% below %.0f HU", s.bone_mm3,
                  100 * s.below_threshold_fraction, s.threshold_hu);
    return text;
  }
  std::snprintf(text, sizeof text,
                "segmentation: threshold %.0f HU, %lld pieces, kept %s (rank %lld by size); %.0f mm3 of bone, %.1f %% "
                "below the threshold",
                s.threshold_hu, static_cast<long long>(s.pieces), s.by_seed ? "the one with the seed" : "the largest",
                static_cast<long long>(s.kept_rank), s.bone_mm3, 100 * s.below_threshold_fraction);
  return text;
}

std::string steps_of(const Segmentation& s) {
  if (s.method == "label_map") return "";
  char text[160];
  std::snprintf(text, sizeof text, "; discarded %.0f mm3, cut %.0f mm3, added by closing %.0f mm3, by filling %.0f mm3",
                s.dropped_mm3, s.cut_mm3, s.closed_mm3, s.filled_mm3);
  return text;
}

}  // namespace

std::string sentence_of(const Segmentation& s) {
  char text[120];
  std::snprintf(text, sizeof text, "; on %.1f %% of its surface the density is a lower bound",
                100 * s.lower_bound_fraction);
  return bone_of(s) + steps_of(s) + text;
}

}  // namespace reamsim

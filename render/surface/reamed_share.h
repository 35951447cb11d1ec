#pragma once

#include <algorithm>

namespace reamsim {

/// How surely material is gone at a point of today's surface, 0…1: there the unreamed bone's field is zero where
/// nothing happened, and falls to −½ inside.
inline float reamed_share(double unreamed_field) {
  constexpr double kNone = 0.03;
  constexpr double kSure = 0.13;
  return static_cast<float>(std::clamp((-unreamed_field - kNone) / (kSure - kNone), 0.0, 1.0));
}

}  // namespace reamsim

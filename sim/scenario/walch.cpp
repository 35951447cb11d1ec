#include "sim/scenario/walch.h"

namespace reamsim {

void take_walch_defaults(PhantomSettings& phantom) {
  if (phantom.walch == Walch::none) return;
  if (phantom.walch == Walch::c) {
    phantom.version_deg = 37;
    phantom.inclination_deg = 3;
    phantom.face_radius_mm = 37;
    phantom.height_mm = 46;
    phantom.width_mm = 30;
    return;
  }
  phantom.version_deg = 8;
  phantom.inclination_deg = 8;
  if (phantom.walch == Walch::a1) phantom.medialization_mm = 1.5;
  if (phantom.walch == Walch::a2) phantom.medialization_mm = 6;
}

}  // namespace reamsim

#include "sim/scenario/walch.h"

namespace reamsim {

void take_walch_defaults(PhantomSettings& phantom) {
  if (phantom.walch == "none") return;
  if (phantom.walch == "C") {
    phantom.version_deg = 37;
    phantom.inclination_deg = 3;
    phantom.face_radius_mm = 37;
    phantom.height_mm = 46;
    phantom.width_mm = 30;
    return;
  }
  phantom.version_deg = 8;
  phantom.inclination_deg = 8;
  if (phantom.walch == "A1") phantom.medialization_mm = 1.5;
  if (phantom.walch == "A2") phantom.medialization_mm = 6;
}

}  // namespace reamsim

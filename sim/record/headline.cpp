#include "sim/record/headline.h"

#include "sim/base/text.h"

namespace reamsim {

std::string Headline::force_text() const {
  return fixed_text(peak_axial_force_n, 1);
}

std::string Headline::torque_text() const {
  return fixed_text(peak_spin_torque_nmm, 0);
}

std::string Headline::depth_text() const {
  return fixed_text(tool_depth_mm, 2);
}

std::string Headline::force_definition() const {
  return std::string("maximum component of the force along the tool axis, and maximum torque about it, ") +
         (means ? "of the means over one voxel of travel" : "of a single frame");
}

std::string Headline::depth_definition() {
  return "maximum travel of the tool along its axis since first contact";
}

}  // namespace reamsim

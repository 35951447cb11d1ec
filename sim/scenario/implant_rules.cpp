// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <string>

#include "sim/scenario/parse_steps.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

const std::string kImplant = "metrics.implant";

// Below this angle (about half a degree) a direction across another one is noise.
constexpr double kLeastCrossing = 0.01;
// A shorter peg is a point.
constexpr double kLeastPeg_mm = 0.1;

/// Throws InputErrors of one implant.
class ImplantRules {
 public:
  ImplantRules(const ImplantSettings& implant, const KeyLocations& locations) : implant_(implant), at_(locations) {}

  void check_footprint() const {
    const bool sized = implant_.width_mm > 0 || implant_.height_mm > 0;
    if (sized && implant_.diameter_mm > 0) {
      fail("diameter_mm", "found diameter_mm beside width_mm or height_mm", "either the one or the others");
    }
    if (sized && implant_.width_mm == 0) fail("width_mm", "missing", "width_mm and height_mm together");
    if (sized && implant_.height_mm == 0) fail("height_mm", "missing", "width_mm and height_mm together");
    if (implant_.footprint == FootprintShape::pear && implant_.height_mm < implant_.width_mm) {
      fail("height_mm", "found " + number_text(implant_.height_mm), "at least width_mm, because footprint is pear");
    }
    if (implant_.backside_radius_mm == 0) return;
    check_covered("diameter_mm", implant_.diameter_mm);
    check_covered("width_mm", implant_.width_mm);
    check_covered("height_mm", implant_.height_mm);
  }

  void check_pose() const {
    const bool outward = implant_.frame == ImplantFrame::bone || implant_.axis.z() > 0;
    if (!outward) fail("axis", "found an axis with z ≤ 0", "a direction out of the bone, z > 0");
    if (!implant_.superior) return;
    const double sine = implant_.axis.normalized().cross(implant_.superior->normalized()).norm();
    if (sine < kLeastCrossing) fail("superior", "found a direction along axis", "a direction across it");
  }

  void check_augment() const {
    if (implant_.augment && implant_.augment->direction.head<2>().norm() == 0) {
      fail("augment.direction", "found x = y = 0", "a direction across the axis of the implant");
    }
  }

  void check_pegs() const {
    for (std::size_t i = 0; i < implant_.pegs.size(); ++i) {
      const PegSettings& peg = implant_.pegs[i];
      if ((peg.to_mm - peg.from_mm).norm() >= kLeastPeg_mm) continue;
      fail("pegs." + std::to_string(i) + ".to_mm", "found a point closer than 0.1 mm to from_mm", "the other end");
    }
  }

 private:
  [[noreturn]] void fail(const std::string& name, const std::string& found, const std::string& expected) const {
    const std::string key = kImplant + "." + name;
    throw InputError(at_.of(key), key, found, "expected " + expected);
  }

  void check_covered(const std::string& name, double size_mm) const {
    if (size_mm <= 2 * implant_.backside_radius_mm) return;
    fail(name, "found " + number_text(size_mm), "no more than twice backside_radius_mm");
  }

  const ImplantSettings& implant_;
  const KeyLocations& at_;
};

}  // namespace

void check_implant(const ImplantSettings& implant, const KeyLocations& locations) {
  const ImplantRules rules(implant, locations);
  rules.check_footprint();
  rules.check_pose();
  rules.check_augment();
  rules.check_pegs();
}

}  // namespace reamsim

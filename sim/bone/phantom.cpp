#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/bone/phantom_blocks.h"
#include "sim/bone/phantom_glenoid.h"

namespace reamsim {

Bone bone_from_phantom(const BoneSettings& settings, Report& report) {
  const std::string& shape = settings.phantom.shape;
  report.note("phantom: " + shape);
  if (shape == "half_space") return half_space_phantom(settings);
  if (shape == "cup") return cup_phantom(settings);
  if (shape == "sphere") return sphere_phantom(settings);
  if (shape == "layered") return layered_phantom(settings);
  if (shape == "glenoid") return glenoid_phantom(settings, report);
  throw InputError({}, "bone.phantom.shape", "\"" + shape + "\"",
                   "expected half_space, cup, sphere, layered or glenoid");
}

}  // namespace reamsim

#include "sim/bone/bone.h"
#include "sim/bone/phantom_blocks.h"
#include "sim/bone/phantom_glenoid.h"

namespace reamsim {

Bone bone_from_phantom(const BoneSettings& settings, Report& report) {
  const PhantomShape shape = settings.phantom.shape;
  report.note("phantom: " + name_of(shape));
  if (shape == PhantomShape::half_space) return half_space_phantom(settings);
  if (shape == PhantomShape::cup) return cup_phantom(settings);
  if (shape == PhantomShape::sphere) return sphere_phantom(settings);
  if (shape == PhantomShape::layered) return layered_phantom(settings);
  return glenoid_phantom(settings, report);
}

}  // namespace reamsim

#include "sim/tool/envelope.h"

#include "sim/base/error.h"
#include "sim/tool/generatrix.h"
#include "sim/tool/sweep_outline.h"

namespace reamsim {

Envelope envelope_of_revolution(const TriangleMesh& mesh) {
  if (auto profile = recover_generatrix(mesh)) return {std::move(*profile), true};
  Profile profile = sweep_outline(mesh, kOutlineStepMm);
  if (profile.points.size() < 3 || !(profile.volume_mm3() > 0))
    throw InputError("its envelope of revolution about z has no volume");
  return {std::move(profile), false};
}

}  // namespace reamsim

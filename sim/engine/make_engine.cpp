#include "sim/engine/make_engine.h"

#include "sim/engine/bricked/bricked_engine.h"
#include "sim/engine/dense/dense_engine.h"
#include "sim/engine/exact/exact_engine.h"
#include "sim/engine/serial/serial_engine.h"

namespace reamsim {

std::unique_ptr<Engine> make_engine_on(EngineDevices& devices, const Scenario& scenario, const BoneView& bone,
                                       const Tool& tool) {
  if (scenario.engine.device == "serial") return make_serial_engine(scenario, bone, tool);
  const cl::Device device = devices.of(scenario.engine);
  switch (engine_of(scenario)) {
    case EngineKind::exact:
      return make_exact_engine(device, scenario, bone, tool);
    case EngineKind::bricked:
      return make_bricked_engine(device, scenario, bone, tool);
    default:
      return make_dense_engine(device, scenario, bone, tool);
  }
}

std::unique_ptr<Engine> make_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool) {
  EngineDevices devices;
  return make_engine_on(devices, scenario, bone, tool);
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/make_engine.h"

#include <utility>

#include "sim/engine/basis/basis_engine.h"
#include "sim/engine/bricked/bricked_engine.h"
#include "sim/engine/dense/dense_engine.h"
#include "sim/engine/exact/exact_engine.h"
#include "sim/engine/serial/serial_engine.h"

namespace reamsim {

namespace {

std::unique_ptr<Engine> make_plain_engine(EngineDevices& devices, const Scenario& scenario, const BoneView& bone,
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

}  // namespace

std::unique_ptr<Engine> make_engine_on(EngineDevices& devices, const Scenario& scenario, const BoneView& bone,
                                       const Tool& tool) {
  std::unique_ptr<Engine> engine = make_plain_engine(devices, scenario, bone, tool);
  return scenario.output.force_basis ? make_basis_engine(std::move(engine), scenario, bone, tool) : std::move(engine);
}

std::unique_ptr<Engine> make_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool) {
  EngineDevices devices;
  return make_engine_on(devices, scenario, bone, tool);
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/engine.h"

#include "sim/base/error.h"

namespace reamsim {

namespace {

cl::DeviceInfo chosen(const EngineSettings& engine) {
  cl::DeviceInfo info = cl::choose_device(engine.device);
  if (engine.tuning.compute_units > 0) info = cl::part_of(info, static_cast<unsigned>(engine.tuning.compute_units));
  return info;
}

std::unique_ptr<Engine> make_plain_engine(EngineDevices& devices, const Scenario& scenario, const BoneView& bone,
                                          const Tool& tool) {
  if (scenario.engine.device == "serial") return make_serial_engine(scenario, bone, tool);
  const cl::Device device = devices.of(scenario.engine);
  const EngineKind kind = engine_of(scenario);
  if (kind == EngineKind::exact) return make_exact_engine(device, scenario, bone, tool);
  if (kind == EngineKind::bricked) return make_bricked_engine(device, scenario, bone, tool);
  return make_dense_engine(device, scenario, bone, tool);
}

}  // namespace

cl::Device EngineDevices::of(const EngineSettings& engine) {
  const std::pair key{engine.device, engine.tuning.compute_units};
  auto opened = opened_.find(key);
  if (opened == opened_.end()) opened = opened_.emplace(key, cl::Device(chosen(engine))).first;
  const cl::DeviceInfo& info = opened->second.info();
  const int wanted = engine.tuning.work_group_size;
  if (wanted > 0 && static_cast<std::size_t>(wanted) > info.max_work_group) {
    throw InputError({}, "REAMSIM_ENGINE_TUNING", "found work_group_size=" + std::to_string(wanted),
                     "expected at most " + std::to_string(info.max_work_group) + " on " + info.name);
  }
  return opened->second;
}

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

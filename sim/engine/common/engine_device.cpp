// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/engine_device.h"

#include "sim/base/error.h"

namespace reamsim {

namespace {

cl::DeviceInfo chosen(const EngineSettings& engine) {
  cl::DeviceInfo info = cl::choose_device(engine.device);
  if (engine.tuning.compute_units > 0) info = cl::part_of(info, static_cast<unsigned>(engine.tuning.compute_units));
  return info;
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

}  // namespace reamsim

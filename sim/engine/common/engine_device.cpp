#include "sim/engine/common/engine_device.h"

#include "sim/base/error.h"

namespace reamsim {

cl::DeviceInfo device_for(const EngineSettings& engine) {
  cl::DeviceInfo info = cl::choose_device(engine.device);
  if (engine.work_group_size > 0 && static_cast<std::size_t>(engine.work_group_size) > info.max_work_group) {
    throw InputError({}, "engine.work_group_size", "found " + std::to_string(engine.work_group_size),
                     "expected at most " + std::to_string(info.max_work_group) + " on " + info.name);
  }
  return info;
}

}  // namespace reamsim

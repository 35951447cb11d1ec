#include "sim/engine/bricked/bricked_options.h"

#include <algorithm>

namespace reamsim {

BrickedOptions choose_options(const cl::DeviceInfo& info, const EngineSettings& engine) {
  BrickedOptions options;
  const bool gpu =
      engine.kernel_shape == KernelShape::gpu || (engine.kernel_shape == KernelShape::automatic && info.gpu);
  options.shape = gpu ? KernelShape::gpu : KernelShape::cpu;
  // On a CPU every work-item is long, and PoCL hands whole groups to threads; on a GPU a cell has some hundred points.
  const std::size_t wanted = engine.work_group_size > 0 ? static_cast<std::size_t>(engine.work_group_size)
                             : gpu                      ? 128
                                                        : 1;
  options.work_group = std::min(wanted, info.max_work_group);
  options.culling = engine.culling;
  return options;
}

std::size_t cut_items(const cl::DeviceInfo& info, const BrickedOptions& options) {
  constexpr std::size_t kItemsPerCore = 8, kGroupsPerUnit = 32;
  return info.compute_units * (options.shape == KernelShape::cpu ? kItemsPerCore : kGroupsPerUnit * options.work_group);
}

std::string cut_defines(const BrickPools& layout, KernelShape shape) {
  return layout.defines(shape) + (shape == KernelShape::cpu ? " -DRS_LANES=16" : "");
}

}  // namespace reamsim

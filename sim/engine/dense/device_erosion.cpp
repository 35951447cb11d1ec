#include "sim/engine/dense/device_erosion.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_cut_voxels;
}

namespace {

/// Enough work-items to fill the device: a CPU wants few that do much, a GPU many.
std::size_t work_items(const cl::DeviceInfo& info) {
  return info.compute_units * (info.gpu ? 1024 : 64);
}

std::string build_options(VoxelLayout layout) {
  if (layout == VoxelLayout::flagged_hu) return "-DREAMSIM_FLAGGED_HU";
  if (layout == VoxelLayout::bare_grade) return "-DREAMSIM_BARE_GRADE";
  return "";
}

}  // namespace

DeviceErosion::DeviceErosion(const cl::Device& device, VoxelLayout layout, const DenseState& state,
                             const DeviceBatch& batch, const EnergyTable& table, std::size_t work_group)
    : items_(work_items(device.info())),
      energy_(device, table.energy_mj.size(), "the energy table"),
      density_(device, table.density_g_cm3.size(), "the density table"),
      kernel_(device, device.build("cut_voxels.cl", embedded::kernel_cut_voxels, build_options(layout)), "cut_voxels",
              1, work_group) {
  energy_.write(device, table.energy_mj.data(), table.energy_mj.size());
  density_.write(device, table.density_g_cm3.data(), table.density_g_cm3.size());
  kernel_.set(0, batch.args());
  if (layout == VoxelLayout::flagged_hu) {
    kernel_.set(2, state.hu);
  } else {
    kernel_.set(2, state.grades);
  }
  kernel_.set(3, state.fill);
  kernel_.set(4, static_cast<cl_int>(state.has_fill ? 1 : 0));
  kernel_.set(5, state.claims);
  kernel_.set(6, state.contacts);
  kernel_.set(7, batch.contact_count());
  kernel_.set(8, batch.sums());
  kernel_.set(9, batch.removed());
  kernel_.set(10, batch.removed_count());
  kernel_.set(11, energy_);
  kernel_.set(12, density_);
  state.profile.set(kernel_, 13);
  kernel_.set(17, state.scale.of_air);
  kernel_.set(18, state.scale.per_grade);
}

void DeviceErosion::cut(int slot) {
  kernel_.run(slot, items_);
}

}  // namespace reamsim

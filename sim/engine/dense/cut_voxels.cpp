#include "sim/engine/dense/cut_voxels.h"

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

CutVoxels::CutVoxels(const cl::Device& device, VoxelLayout layout, const DenseState& state, const DeviceBatch& batch,
                     const EnergyTable& table, std::size_t work_group)
    : items_(work_items(device.info())),
      energy_(device, table.energy_mj.size(), "the energy table"),
      density_(device, table.density_g_cm3.size(), "the density table"),
      kernel_(device, device.build("cut_voxels.cl", embedded::kernel_cut_voxels, build_options(layout)), "cut_voxels",
              Argument::substep, work_group) {
  energy_.write(device, table.energy_mj.data(), table.energy_mj.size());
  density_.write(device, table.density_g_cm3.data(), table.density_g_cm3.size());
  kernel_.set(Argument::args, batch.args());
  if (layout == VoxelLayout::flagged_hu) {
    kernel_.set(Argument::bone, state.hu);
  } else {
    kernel_.set(Argument::bone, state.grades);
  }
  kernel_.set(Argument::fill, state.fill);
  kernel_.set(Argument::has_fill, static_cast<cl_int>(state.has_fill ? 1 : 0));
  kernel_.set(Argument::claims, state.claims);
  kernel_.set(Argument::contacts, state.contacts);
  kernel_.set(Argument::contact_count, batch.contact_count());
  kernel_.set(Argument::sums, batch.sums());
  kernel_.set(Argument::removed, batch.removed());
  kernel_.set(Argument::removed_count, batch.removed_count());
  kernel_.set(Argument::energy_of_grade, energy_);
  kernel_.set(Argument::density_of_grade, density_);
  state.profile.set(kernel_, Argument::edges);
  kernel_.set(Argument::hu_of_air, state.scale.of_air);
  kernel_.set(Argument::hu_per_grade, state.scale.per_grade);
}

void CutVoxels::enqueue(int slot) {
  kernel_.run(slot, items_);
}

}  // namespace reamsim

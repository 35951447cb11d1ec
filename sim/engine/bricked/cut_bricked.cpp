#include "sim/engine/bricked/cut_bricked.h"

#include <algorithm>
#include <array>

#include "kernels/cut_law.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_cut_bricked;
}

namespace {

/// Per byte the numbers of its bits, a byte each, lowest first; then zeros.
std::array<cl_ulong, 256> bits_of_byte() {
  std::array<cl_ulong, 256> out{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    int at = 0;
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((byte >> bit & 1U) != 0) out[byte] |= cl_ulong{bit} << (8 * at++);
    }
  }
  return out;
}

}  // namespace

CutBricked::CutBricked(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch,
                       const EnergyTable& table, const KernelOptions& options)
    : items_(cut_items(device.info(), options)),
      energy_(device, table.energy_mj.size(), "the energy table"),
      units_(device, table.energy_mj.size(), "the energy table"),
      density_(device, table.density_g_cm3.size(), "the density table"),
      bits_of_byte_(device, 256, "the table of bits"),
      kernel_(
          device,
          device.build("cut_bricked.cl", embedded::kernel_cut_bricked, cut_defines(state.bone.layout, options.shape)),
          "cut_bricked", Argument::substep, options.work_group) {
  energy_.write(device, table.energy_mj.data(), table.energy_mj.size());
  std::array<cl_long, 256> units{};
  std::transform(table.energy_mj.begin(), table.energy_mj.end(), units.begin(), rs_energy_units);
  units_.write(device, units.data(), units.size());
  density_.write(device, table.density_g_cm3.data(), table.density_g_cm3.size());
  const auto bits = bits_of_byte();
  bits_of_byte_.write(device, bits.data(), bits.size());
  kernel_.set(Argument::args, batch.args());
  kernel_.set(Argument::lattice_of_slot, state.bone.lattice_of_slot);
  kernel_.set(Argument::listed, state.listed);
  kernel_.set(Argument::occupancy, state.bone.occupancy);
  kernel_.set(Argument::touched_list, state.touched_list);
  kernel_.set(Argument::touched_count, batch.contact_count());
  kernel_.set(Argument::sums, batch.sums());
  kernel_.set(Argument::removed, batch.removed());
  kernel_.set(Argument::removed_count, batch.removed_count());
  kernel_.set(Argument::room, batch.removed_room());
  kernel_.set(Argument::removed_before, batch.removed_before());
  kernel_.set(Argument::energy_of_grade, energy_);
  kernel_.set(Argument::units_of_grade, units_);
  kernel_.set(Argument::density_of_grade, density_);
  kernel_.set(Argument::bits_of_byte, bits_of_byte_);
  kernel_.set(Argument::bricks, state.bone.dims);
  state.profile.set(kernel_, Argument::edges);
  state.bone.set_pools(kernel_, Argument::pool_0);
}

void CutBricked::enqueue(int slot) {
  kernel_.run(slot, items_);
}

}  // namespace reamsim

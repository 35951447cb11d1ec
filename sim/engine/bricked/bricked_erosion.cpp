#include "sim/engine/bricked/bricked_erosion.h"

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

BrickedErosion::BrickedErosion(const cl::Device& device, BrickedState& state, const DeviceBatch& batch,
                               const EnergyTable& table, const BrickedOptions& options)
    : items_(cut_items(device.info(), options)),
      energy_(device, table.energy_mj.size(), "the energy table"),
      units_(device, table.energy_mj.size(), "the energy table"),
      density_(device, table.density_g_cm3.size(), "the density table"),
      bits_of_byte_(device, 256, "the table of bits"),
      kernel_(device,
              device.build("cut_bricked.cl", embedded::kernel_cut_bricked, cut_defines(state.layout, options.shape)),
              "cut_bricked", 1, options.work_group) {
  energy_.write(device, table.energy_mj.data(), table.energy_mj.size());
  std::array<cl_long, 256> units{};
  std::transform(table.energy_mj.begin(), table.energy_mj.end(), units.begin(), rs_energy_units);
  units_.write(device, units.data(), units.size());
  density_.write(device, table.density_g_cm3.data(), table.density_g_cm3.size());
  const auto bits = bits_of_byte();
  bits_of_byte_.write(device, bits.data(), bits.size());
  kernel_.set(0, batch.args());
  kernel_.set(2, state.lattice_of_slot);
  kernel_.set(3, state.listed);
  kernel_.set(4, state.occupancy);
  kernel_.set(5, state.touched_list);
  kernel_.set(6, batch.contact_count());
  kernel_.set(7, batch.sums());
  kernel_.set(8, batch.removed());
  kernel_.set(9, batch.removed_count());
  kernel_.set(10, batch.removed_room());
  kernel_.set(11, batch.removed_before());
  kernel_.set(12, energy_);
  kernel_.set(13, units_);
  kernel_.set(14, density_);
  kernel_.set(15, bits_of_byte_);
  kernel_.set(16, state.bricks);
  state.profile.set(kernel_, 17);
  state.set_pools(kernel_, 21);
}

void BrickedErosion::cut(int slot) {
  kernel_.run(slot, items_);
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/engine.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "kernels/cut_law.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/common/tables.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_detect_bricked;
extern const char* const kernel_cut_bricked;
}  // namespace embedded

namespace {

/// The data of `bricked` on the device: the bone's bricks, the lists of those that a substep touches, the shell's
/// points in cells, and tables.
struct BrickedState {
  DeviceBricks bone;
  cl::Buffer<cl_uint> listed;  ///< per slot
  cl::Buffer<cl_uint> touched_list;
  cl::Buffer<ShellCell> cells;
  cl::Buffer<ShellCell> runs;
  cl::Buffer<cl_ushort> offsets;
  DeviceOutline outline;
  cl::Buffer<rs_i64> units_of_grade;    ///< energy of a whole voxel
  cl::Buffer<rs_i32> density_of_grade;  ///< RS_DENSITY_SCALE
  cl::Buffer<cl_ulong> bits_of_byte;    ///< per byte the numbers of its bits, a byte each, lowest first; then zeros

  [[nodiscard]] std::size_t shell_bytes() const { return cells.bytes() + runs.bytes() + offsets.bytes(); }
};

/// The lists of touched bricks, and the shell.
std::size_t bytes_beside_bone(const BoneView& bone, const Tool& tool) {
  return 2 * sizeof(cl_uint) * bone.voxmap.grade.stored_bricks() + 3 * tool.shell.codes.size();
}

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

/// Uploads bone, tool and tables. Throws as make_device_bricks() does.
BrickedState make_bricked_state(const cl::Device& device, const BoneView& bone, const Tool& tool,
                                const EnergyTable& energy, FillStore fill, std::size_t largest_pool) {
  BrickedState state;
  state.bone = make_device_bricks(device, bone, fill, bytes_beside_bone(bone, tool), largest_pool);
  const std::size_t slots = std::max<std::size_t>(1, state.bone.layout.bricks);
  state.listed = {device, slots, "the marks of touched bricks"};
  state.listed.clear(device, slots);
  state.touched_list = {device, slots, "the list of touched bricks"};
  const ShellCells shell =
      make_shell_cells(tool.shell, shell_cell_side(tool.shell.cell_mm / bone.voxmap.grid.voxel_mm));
  state.cells = cl::upload(device, shell.cells, "the shell's cells", "tool.shell_resolution");
  state.runs = cl::upload(device, shell.runs, "the shell's cells", "tool.shell_resolution");
  state.offsets = cl::upload(device, shell.offsets, "the point shell", "tool.shell_resolution");
  state.outline = upload_outline(device, make_outline_table(tool.profile, bone.voxmap.grid.voxel_mm));
  state.units_of_grade = cl::upload(device, energy.units, "the energy table");
  state.density_of_grade = cl::upload(device, energy.density, "the density table");
  state.bits_of_byte = cl::upload(device, bits_of_byte(), "the table of bits");
  return state;
}

/// Cells of shell points against bricks of voxels; see kernels/detect_bricked.cl.
cl::SlotKernel make_detect_bricked(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch,
                                   const KernelOptions& options) {
  const std::string defines = kernel_defines(state.bone.layout, options.shape);
  cl::SlotKernel out(device, device.build("detect_bricked.cl", embedded::kernel_detect_bricked, defines),
                     "detect_bricked", options.work_group,
                     options.shape == KernelShape::cpu ? state.runs.count() : state.cells.count() * options.work_group);
  out.set_from(cl::SlotKernel::kAfterSlot, batch.args(), state.cells, static_cast<cl_uint>(state.cells.count()),
               state.runs, cl_uint{kRunCells}, state.offsets, state.bone.slot_of_brick, state.bone.occupancy,
               state.listed, state.touched_list, batch.contact_count(), batch.sums(), state.bone.dims,
               cl_int{options.culling ? 1 : 0}, batch.removed_room(), batch.removed_count(), batch.removed_before(),
               state.outline, state.bone.pool_arguments());
  return out;
}

/// `remove` and `wear` over the list of touched bricks; see kernels/cut_bricked.cl.
cl::SlotKernel make_cut_bricked(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch,
                                const KernelOptions& options) {
  const std::string defines = cut_defines(state.bone.layout, options.shape);
  cl::SlotKernel out(device, device.build("cut_bricked.cl", embedded::kernel_cut_bricked, defines), "cut_bricked",
                     options.work_group, cut_items(device.info(), options));
  out.set_from(cl::SlotKernel::kAfterSlot, batch.args(), state.bone.lattice_of_slot, state.listed, state.bone.occupancy,
               state.touched_list, batch.contact_count(), batch.sums(), batch.removed(), batch.removed_count(),
               batch.removed_room(), batch.removed_before(), state.units_of_grade, state.density_of_grade,
               state.bits_of_byte, state.bone.dims, state.outline, state.bone.pool_arguments());
  return out;
}

FillStore fill_store(const Scenario& scenario) {
  return scenario.cutting.erosion == ErosionMode::wear ? FillStore::bricks : FillStore::none;
}

/// A record stands for a block of 4×4×4 voxels: at most one per touched voxel and per shell point.
DeviceBatch::RemovedList removed_list(const BoneView& bone, const Tool& tool, const BrickedLimits& limits) {
  const auto voxels = static_cast<std::size_t>(bone.count_bone());
  const std::size_t per_substep = std::min(voxels, tool.shell.codes.size());
  return {.words = sizeof(RemovedBlock) / sizeof(cl_ulong),
          .room = std::min(voxels, std::max(limits.removed_room, per_substep)),
          .per_substep = per_substep,
          .in_total = voxels,
          .resumes = true};
}

class BrickedEngine final : public Engine {
 public:
  BrickedEngine(const cl::Device& device, const Scenario& scenario, const BoneView& bone, const Tool& tool,
                const BrickedLimits& limits)
      : device_(device),
        bytes_(bricked_engine_bytes(scenario, bone, tool)),
        grid_(bone.voxmap.grid),
        state_(make_bricked_state(device_, bone, tool, make_energy_table(scenario.cutting, bone.voxmap.grid.voxel_mm),
                                  fill_store(scenario), limits.largest_pool)),
        batch_(device_, removed_list(bone, tool, limits)),
        detect_(make_detect_bricked(device_, state_, batch_, choose_options(device.info(), scenario.engine.tuning))),
        cut_(make_cut_bricked(device_, state_, batch_, choose_options(device.info(), scenario.engine.tuning))) {}

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> /*window*/) override {
    const int slot = batch_.begin(args);
    detect_.run(slot);
    cut_.run(slot);
  }
  [[nodiscard]] bool full() const override { return batch_.full(); }

  Batch collect() override {
    removed_.clear();
    for (int slot = batch_.first_waiting(); slot >= 0; slot = batch_.first_waiting()) resume(slot);
    return {.sums = batch_.collect(), .times = stage_times(detect_, cut_)};
  }

  RemovedFrames take_removed() override {
    append(batch_.take_removed());
    return std::exchange(removed_, {});
  }

  void read_fill(const Voxmap& voxmap, FillBricks& fill) override {
    read_brick_fill(device_, state_.bone, voxmap, fill);
  }
  void restore(const BoneView& bone) override { upload_bone(device_, bone, state_.bone); }
  void restore_voxels(const BoneView& bone, const RemovedFrames& removed) override {
    upload_bricks_of(device_, bone, removed, state_.bone);
  }
  [[nodiscard]] std::string device() const override { return device_.info().name; }
  [[nodiscard]] std::size_t device_bytes() const override { return bytes_; }
  [[nodiscard]] StructureBytes structure_bytes() const override { return {state_.bone.bytes(), state_.shell_bytes()}; }

 private:
  /// Cuts the substep that waited for room in the list of removed voxels, and runs those after it.
  void resume(int slot) {
    append(batch_.make_room(slot));
    cut_.run(slot);
    for (int later = slot + 1; later < batch_.used(); ++later) {
      detect_.run(later);
      cut_.run(later);
    }
  }

  void append(const std::vector<cl_ulong>& words) {
    for (std::size_t i = 0; i < words.size(); i += 2) {
      RemovedBlock block;
      std::memcpy(&block, &words[i], sizeof block);
      batch_.append_removed(block, grid_, removed_);
    }
  }

  cl::Device device_;
  std::size_t bytes_;
  VoxelGrid grid_;
  BrickedState state_;
  DeviceBatch batch_;
  cl::SlotKernel detect_, cut_;
  RemovedFrames removed_;  // of the batch, as far as they have been read
};

}  // namespace

std::unique_ptr<Engine> make_bricked_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                            const Tool& tool, const BrickedLimits& limits) {
  return std::make_unique<BrickedEngine>(device, scenario, bone, tool, limits);
}

std::size_t bricked_engine_bytes(const Scenario& scenario, const BoneView& bone, const Tool& tool) {
  return device_bricks_bytes(bone, fill_store(scenario)) + bytes_beside_bone(bone, tool) +
         DeviceBatch::bytes(removed_list(bone, tool, {}));
}

}  // namespace reamsim

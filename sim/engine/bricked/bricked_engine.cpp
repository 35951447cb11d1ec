#include "sim/engine/bricked/bricked_engine.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "sim/engine/bricked/bricked_erosion.h"
#include "sim/engine/common/engine_device.h"
#include "sim/engine/common/removed_blocks.h"

namespace reamsim {

namespace {

FillStore fill_store(const Scenario& scenario) {
  return scenario.cutting.erosion == ErosionMode::wear ? FillStore::bricks : FillStore::none;
}

/// A record is of a block, which cannot be touched without a point nor go without a voxel.
DeviceBatch::RemovedList removed_list(const Voxmap& voxmap, const Tool& tool, const BrickedLimits& limits) {
  const auto bone = static_cast<std::size_t>(voxmap.count_bone());
  const std::size_t per_substep = std::min(bone, tool.shell.codes.size());
  return {.words = sizeof(RemovedBlock) / sizeof(cl_ulong),
          .room = std::min(bone, std::max(limits.removed_room, per_substep)),
          .per_substep = per_substep,
          .in_all = bone,
          .resumes = true};
}

class BrickedEngine final : public Engine {
 public:
  BrickedEngine(const cl::DeviceInfo& info, const Scenario& scenario, const Voxmap& voxmap, const Tool& tool,
                const BrickedLimits& limits)
      : device_(info),
        bytes_(bricked_engine_bytes(scenario, voxmap, tool)),
        grid_(voxmap.grid),
        state_(make_bricked_state(device_, voxmap, tool, fill_store(scenario), limits.largest_pool)),
        batch_(device_, removed_list(voxmap, tool, limits)),
        detector_(device_, state_, batch_, choose_options(info, scenario.engine)),
        erosion_(device_, state_, batch_, make_energy_table(scenario.cutting, voxmap.grid.voxel_mm),
                 choose_options(info, scenario.engine)) {}

  int begin(const SubstepArgs& args) override { return batch_.begin(args); }
  Detector& detector() override { return detector_; }
  Erosion& erosion() override { return erosion_; }
  [[nodiscard]] bool full() const override { return batch_.full(); }

  Batch collect() override {
    removed_.clear();
    for (int slot = batch_.stalled(); slot >= 0; slot = batch_.stalled()) resume(slot);
    return {batch_.collect(), detector_.take_seconds(), erosion_.take_seconds()};
  }

  RemovedFrames take_removed() override {
    append(batch_.take_removed());
    return std::exchange(removed_, {});
  }

  void read_fill(Voxmap& voxmap) override { read_bricked_fill(device_, state_, voxmap); }
  void restore(const Voxmap& voxmap) override { upload_bone(device_, state_, voxmap); }
  void restore_voxels(const Voxmap& voxmap, const RemovedFrames& gone) override {
    upload_bricks_of(device_, state_, voxmap, gone);
  }
  [[nodiscard]] std::string device() const override { return device_.info().name; }
  [[nodiscard]] std::size_t device_bytes() const override { return bytes_; }
  [[nodiscard]] StructureBytes structure_bytes() const override {
    StructureBytes out{state_.slot_of_brick.bytes() + state_.lattice_of_slot.bytes() + state_.occupancy.bytes(),
                       state_.cells.bytes() + state_.runs.bytes() + state_.offsets.bytes()};
    for (const auto& pool : state_.pools) out.voxmap += pool.bytes();
    return out;
  }

 private:
  /// Cuts what waited for room in the list of removed voxels, and runs the substeps after it.
  void resume(int slot) {
    append(batch_.make_room(slot));
    erosion_.cut(slot);
    for (int later = slot + 1; later < batch_.used(); ++later) {
      detector_.detect(later);
      erosion_.cut(later);
    }
  }

  void append(const std::vector<cl_ulong>& words) {
    for (std::size_t i = 0; i < words.size(); i += 2) {
      RemovedBlock block;
      std::memcpy(&block, &words[i], sizeof block);
      append_removed(block, grid_, batch_.args_of(static_cast<int>(block.detail >> 3)).frame, removed_);
    }
  }

  cl::Device device_;
  std::size_t bytes_;
  VoxelGrid grid_;
  BrickedState state_;
  DeviceBatch batch_;
  BrickedDetector detector_;
  BrickedErosion erosion_;
  RemovedFrames removed_;  // of the batch, as far as its list has been read
};

}  // namespace

std::unique_ptr<Engine> make_bricked_engine(const cl::DeviceInfo& info, const Scenario& scenario, const Voxmap& voxmap,
                                            const Tool& tool, const BrickedLimits& limits) {
  return std::make_unique<BrickedEngine>(info, scenario, voxmap, tool, limits);
}

std::unique_ptr<Engine> make_bricked_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  return make_bricked_engine(device_for(scenario.engine), scenario, voxmap, tool);
}

std::size_t bricked_engine_bytes(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  return bricked_bytes(voxmap, tool, fill_store(scenario)) + DeviceBatch::bytes(removed_list(voxmap, tool, {}));
}

}  // namespace reamsim

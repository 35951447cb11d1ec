#include "sim/run/bricked_engine.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "sim/cut/bricked_erosion.h"

namespace reamsim {

namespace {

bool wears(const Scenario& scenario) {
  return scenario.cutting.erosion == "wear";
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

BrickedOptions options_for(const cl::DeviceInfo& info, const EngineSettings& engine) {
  BrickedOptions options;
  const bool gpu = engine.kernel_shape == "gpu" || (engine.kernel_shape == "auto" && info.gpu);
  options.shape = gpu ? KernelShape::gpu : KernelShape::cpu;
  // On a CPU every work-item is long, and PoCL hands whole groups to threads; on a GPU a cell has some hundred points.
  const std::size_t wanted = engine.work_group_size > 0 ? static_cast<std::size_t>(engine.work_group_size)
                             : gpu                      ? 128
                                                        : 1;
  options.work_group = std::min(wanted, info.max_work_group);
  options.culling = engine.culling;
  return options;
}

class BrickedEngine final : public Engine {
 public:
  BrickedEngine(const cl::DeviceInfo& info, const Scenario& scenario, const Voxmap& voxmap, const Tool& tool,
                const BrickedLimits& limits)
      : device_(info),
        bytes_(bricked_engine_bytes(scenario, voxmap, tool)),
        grid_(voxmap.grid),
        bricks_(voxmap.fill.brick_dims()),
        state_(make_bricked_state(device_, voxmap, tool, wears(scenario), limits.largest_pool)),
        batch_(device_, removed_list(voxmap, tool, limits)),
        detector_(device_, state_, batch_, options_for(info, scenario.engine)),
        erosion_(device_, state_, batch_, make_energy_table(scenario.cutting, voxmap.grid.voxel_mm),
                 options_for(info, scenario.engine)) {}

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
      append(block);
    }
  }

  /// The voxels of a block's record, with the frame of its substep.
  void append(const RemovedBlock& block) {
    const auto nx = static_cast<rs_u32>(bricks_.x()), ny = static_cast<rs_u32>(bricks_.y());
    const rs_u32 row = block.brick / nx;
    const Vec3i brick(static_cast<int>(block.brick % nx), static_cast<int>(row % ny), static_cast<int>(row / ny));
    const auto first = static_cast<rs_i32>((block.detail & 7U) << 6);
    const Vec3i corner = RS_BRICK_SIDE * brick + Vec3i(rs_offset_x(first), rs_offset_y(first), rs_offset_z(first));
    const std::int32_t frame = batch_.args_of(static_cast<int>(block.detail >> 3)).frame;
    const std::int64_t base = grid_.index(corner.x(), corner.y(), corner.z());
    const std::int64_t row_step = grid_.dims.x(), layer_step = row_step * grid_.dims.y();
    for (rs_u64 rest = block.gone; rest != 0; rest &= rest - 1) {
      const int bit = std::countr_zero(rest);
      removed_.emplace_back(base + (bit & 3) + row_step * (bit >> 2 & 3) + layer_step * (bit >> 4), frame);
    }
  }

  cl::Device device_;
  std::size_t bytes_;
  VoxelGrid grid_;
  Vec3i bricks_;
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
  return make_bricked_engine(cl::choose_device(scenario.engine.device), scenario, voxmap, tool);
}

std::size_t bricked_engine_bytes(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  return bricked_bytes(voxmap, tool, wears(scenario)) + DeviceBatch::bytes(removed_list(voxmap, tool, {}));
}

}  // namespace reamsim

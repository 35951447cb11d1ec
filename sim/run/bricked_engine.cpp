#include "sim/run/bricked_engine.h"

#include <algorithm>

#include "sim/cut/bricked_erosion.h"

namespace reamsim {

namespace {

/// Room for removed voxels that a batch may fill; larger scenes read results back more often instead.
constexpr std::size_t kRemovedRoom = 4'000'000;

bool wears(const Scenario& scenario) {
  return scenario.cutting.erosion == "wear";
}

/// The list of removed voxels: never longer than the bone, never too short for one substep.
struct RemovedPlan {
  std::size_t bone;
  std::size_t per_substep;
  std::size_t room;

  RemovedPlan(const Voxmap& voxmap, const Tool& tool)
      : bone(static_cast<std::size_t>(voxmap.count_bone())),
        per_substep(std::min(bone, tool.shell.codes.size())),
        room(std::min(bone, std::max(kRemovedRoom, per_substep))) {}
};

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
                const RemovedPlan& removed)
      : device_(info),
        bytes_(bricked_engine_bytes(scenario, voxmap, tool)),
        grid_(voxmap.grid),
        bricks_(voxmap.fill.brick_dims()),
        state_(make_bricked_state(device_, voxmap, tool, wears(scenario))),
        batch_(device_, removed.room, removed.per_substep, removed.bone),
        detector_(device_, state_, batch_, options_for(info, scenario.engine)),
        erosion_(device_, state_, batch_, make_energy_table(scenario.cutting, voxmap.grid.voxel_mm),
                 options_for(info, scenario.engine)) {}

  int begin(const SubstepArgs& args) override { return batch_.begin(args); }
  Detector& detector() override { return detector_; }
  Erosion& erosion() override { return erosion_; }
  [[nodiscard]] bool full() const override { return batch_.full(); }

  Batch collect() override {
    DeviceBatch::Results results = batch_.collect();
    Batch batch;
    batch.sums = std::move(results.sums);
    batch.detect_s = detector_.take_seconds();
    batch.cut_s = erosion_.take_seconds();
    batch.removed.reserve(results.removed.size());
    for (const auto& gone : results.removed) {
      batch.removed.emplace_back(voxel_of(gone), batch_.args_of(static_cast<int>(gone.frame >> 9)).frame);
    }
    return batch;
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
  /// The kernels name a voxel by its brick and its place there (RemovedInBrick of kernels/shared.h).
  [[nodiscard]] std::int64_t voxel_of(const RemovedVoxel& gone) const {
    const auto nx = static_cast<cl_uint>(bricks_.x()), ny = static_cast<cl_uint>(bricks_.y());
    const cl_uint row = gone.voxel / nx;
    const auto place = static_cast<rs_i32>(gone.frame & (RS_BRICK_VOXELS - 1));
    return grid_.index(RS_BRICK_SIDE * static_cast<int>(gone.voxel % nx) + rs_offset_x(place),
                       RS_BRICK_SIDE * static_cast<int>(row % ny) + rs_offset_y(place),
                       RS_BRICK_SIDE * static_cast<int>(row / ny) + rs_offset_z(place));
  }

  cl::Device device_;
  std::size_t bytes_;
  VoxelGrid grid_;
  Vec3i bricks_;
  BrickedState state_;
  DeviceBatch batch_;
  BrickedDetector detector_;
  BrickedErosion erosion_;
};

}  // namespace

std::unique_ptr<Engine> make_bricked_engine(const cl::DeviceInfo& info, const Scenario& scenario, const Voxmap& voxmap,
                                            const Tool& tool) {
  return std::make_unique<BrickedEngine>(info, scenario, voxmap, tool, RemovedPlan(voxmap, tool));
}

std::unique_ptr<Engine> make_bricked_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  return make_bricked_engine(cl::choose_device(scenario.engine.device), scenario, voxmap, tool);
}

std::size_t bricked_engine_bytes(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  return bricked_bytes(voxmap, tool, wears(scenario)) + DeviceBatch::bytes(RemovedPlan(voxmap, tool).room);
}

}  // namespace reamsim

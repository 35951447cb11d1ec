#include "sim/run/device_engine.h"

#include <algorithm>

#include "sim/collide/direct_detector.h"
#include "sim/cut/device_erosion.h"

namespace reamsim {

namespace {

/// Group sizes where the scenario leaves the choice: detect is one short item per point; cut strides, and on a CPU
/// wants several groups, because PoCL hands whole groups to threads.
std::size_t group_size(const cl::DeviceInfo& info, int wanted, std::size_t otherwise) {
  return std::min(wanted > 0 ? static_cast<std::size_t>(wanted) : otherwise, info.max_work_group);
}

class DeviceEngine final : public Engine {
 public:
  DeviceEngine(const cl::DeviceInfo& info, const Scenario& scenario, const Voxmap& voxmap, const Tool& tool)
      : device_(info),
        bytes_(reamsim::device_bytes(voxmap, tool.shell, scenario.cutting.erosion == "wear")),
        state_(make_device_state(device_, voxmap, tool, scenario.cutting.erosion == "wear")),
        detector_(device_, state_, group_size(info, scenario.engine.work_group_size, 256)),
        erosion_(device_, state_, make_energy_table(scenario.cutting, voxmap.grid.voxel_mm),
                 group_size(info, scenario.engine.work_group_size, info.gpu ? 256 : 16)),
        args_(kMaxSlots) {
    const std::size_t per_substep = std::min(state_.contacts.count(), state_.removed.count());
    const auto bone_voxels = static_cast<std::size_t>(voxmap.count_bone());
    // The list of removed voxels can overflow only where it is shorter than the bone.
    slots_ = state_.removed.count() >= bone_voxels
                 ? kMaxSlots
                 : std::clamp(static_cast<int>(state_.removed.count() / per_substep), 1, kMaxSlots);
    clear_slots(kMaxSlots);
  }

  int begin(const SubstepArgs& args) override {
    const int slot = used_++;
    args_[static_cast<std::size_t>(slot)] = args;
    state_.args.write(device_, &args_[static_cast<std::size_t>(slot)], 1, static_cast<std::size_t>(slot), false);
    return slot;
  }

  Detector& detector() override { return detector_; }
  Erosion& erosion() override { return erosion_; }
  [[nodiscard]] bool full() const override { return used_ >= slots_; }

  Batch collect() override {
    device_.finish();
    Batch batch;
    const auto used = static_cast<std::size_t>(used_);
    batch.detect_s = detector_.take_seconds();
    batch.cut_s = erosion_.take_seconds();
    if (used == 0) return batch;
    batch.sums.resize(used);
    state_.sums.read(device_, batch.sums.data(), used);
    cl_uint removed_count = 0;
    state_.removed_count.read(device_, &removed_count, 1);
    std::vector<RemovedVoxel> removed(removed_count);
    if (removed_count > 0) state_.removed.read(device_, removed.data(), removed.size());
    batch.removed.reserve(removed.size());
    for (const auto& gone : removed) batch.removed.emplace_back(gone.voxel, static_cast<std::int32_t>(gone.frame));
    clear_slots(used);
    used_ = 0;
    return batch;
  }

  void read_fill(Voxmap& voxmap) override {
    if (!state_.has_fill) return;
    std::vector<cl_ushort> fill(state_.fill.count());
    state_.fill.read(device_, fill.data(), fill.size());
    copy_fill(fill, voxmap);
  }

  [[nodiscard]] std::string device() const override { return device_.info().name; }
  [[nodiscard]] std::size_t device_bytes() const override { return bytes_; }

 private:
  void clear_slots(std::size_t count) {
    state_.sums.clear(device_, count);
    state_.contact_count.clear(device_, count);
    state_.removed_count.clear(device_, 1);
  }

  cl::Device device_;
  std::size_t bytes_;
  DeviceState state_;
  DirectDetector detector_;
  DeviceErosion erosion_;
  std::vector<SubstepArgs> args_;  // lives until the non-blocking write is done
  int slots_ = kMaxSlots;
  int used_ = 0;
};

}  // namespace

void copy_fill(const std::vector<std::uint16_t>& dense, Voxmap& voxmap) {
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      if (grades[static_cast<std::size_t>(offset)] == 0) continue;
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      const auto left = dense[static_cast<std::size_t>(voxmap.grid.index(voxel.x(), voxel.y(), voxel.z()))];
      if (left != FillBricks::kWhole) voxmap.fill.set(voxel, left);
    }
  });
}

std::unique_ptr<Engine> make_device_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  return std::make_unique<DeviceEngine>(cl::choose_device(scenario.engine.device), scenario, voxmap, tool);
}

}  // namespace reamsim

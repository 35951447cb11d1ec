#include "sim/run/engine.h"

#include <utility>

#include "sim/base/error.h"
#include "sim/collide/dense_bone.h"
#include "sim/collide/serial_detector.h"
#include "sim/cut/serial_erosion.h"
#include "sim/run/bricked_engine.h"
#include "sim/run/dense_engine.h"
#include "sim/run/exact_engine.h"

namespace reamsim {

namespace {

FindContacts serial_detection(const Scenario& scenario, const SerialState& state) {
  if (scenario.cutting.erosion == "exact") return find_in_tool_box;
  if (scenario.engine.detector == "implicit") return find_by_profile;
  return find_by_points(state);
}

CutVoxel serial_cut(const Scenario& scenario, double voxel_mm) {
  const EnergyTable table = make_energy_table(scenario.cutting, voxel_mm);
  return scenario.cutting.erosion == "exact" ? cut_by_clipping(table) : cut_touched(table);
}

/// The reference of every detector in plain C++: that of `implicit`, of those which look shell points up, and of
/// `exact`.
class SerialEngine final : public Engine {
 public:
  SerialEngine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool)
      : state_(make_serial_state(voxmap, tool)),
        detector_(state_, serial_detection(scenario, state_)),
        erosion_(state_, serial_cut(scenario, voxmap.grid.voxel_mm)) {}

  int begin(const SubstepArgs& args) override {
    state_.args.push_back(args);
    state_.sums.emplace_back();
    return static_cast<int>(state_.args.size()) - 1;
  }

  Detector& detector() override { return detector_; }
  Erosion& erosion() override { return erosion_; }
  [[nodiscard]] bool full() const override { return state_.args.size() >= 4096; }

  Batch collect() override {
    state_.args.clear();
    return {std::exchange(state_.sums, {}), detector_.take_seconds(), erosion_.take_seconds()};
  }

  RemovedFrames take_removed() override { return std::exchange(state_.removed, {}); }

  void read_fill(Voxmap& voxmap) override { copy_fill(state_.fill, voxmap); }
  void restore(const Voxmap& voxmap) override { take_bone(voxmap, state_); }
  [[nodiscard]] std::string device() const override { return "serial"; }
  [[nodiscard]] std::size_t device_bytes() const override { return 0; }
  [[nodiscard]] StructureBytes structure_bytes() const override { return {}; }

 private:
  SerialState state_;
  SerialDetector detector_;
  SerialErosion erosion_;
};

}  // namespace

cl::DeviceInfo device_for(const EngineSettings& engine) {
  cl::DeviceInfo info = cl::choose_device(engine.device);
  if (engine.work_group_size > 0 && static_cast<std::size_t>(engine.work_group_size) > info.max_work_group) {
    throw InputError({}, "engine.work_group_size", "found " + std::to_string(engine.work_group_size),
                     "expected at most " + std::to_string(info.max_work_group) + " on " + info.name);
  }
  return info;
}

std::unique_ptr<Engine> make_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  if (scenario.engine.device == "serial") return std::make_unique<SerialEngine>(scenario, voxmap, tool);
  if (scenario.cutting.erosion == "exact") return make_exact_engine(scenario, voxmap, tool);
  if (scenario.engine.detector == "bricked") return make_bricked_engine(scenario, voxmap, tool);
  return make_dense_engine(scenario, voxmap, tool);
}

}  // namespace reamsim

#include "sim/engine/serial/serial_engine.h"

#include <utility>

#include "sim/engine/common/dense_bone.h"
#include "sim/engine/serial/serial_detector.h"
#include "sim/engine/serial/serial_erosion.h"

namespace reamsim {

namespace {

FindContacts serial_detection(const Scenario& scenario, const SerialState& state) {
  if (scenario.cutting.erosion == ErosionMode::exact) return find_in_tool_box;
  if (scenario.engine.detector == EngineKind::implicit) return find_by_profile;
  return find_by_points(state);
}

CutVoxel serial_cut(const Scenario& scenario, double voxel_mm) {
  const EnergyTable table = make_energy_table(scenario.cutting, voxel_mm);
  return scenario.cutting.erosion == ErosionMode::exact ? cut_by_clipping(table) : cut_touched(table);
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

std::unique_ptr<Engine> make_serial_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  return std::make_unique<SerialEngine>(scenario, voxmap, tool);
}

}  // namespace reamsim

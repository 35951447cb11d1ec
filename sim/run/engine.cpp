#include "sim/run/engine.h"

#include <utility>

#include "sim/collide/dense_bone.h"
#include "sim/collide/serial_detector.h"
#include "sim/collide/serial_implicit_detector.h"
#include "sim/collide/serial_reach.h"
#include "sim/cut/serial_clip.h"
#include "sim/cut/serial_erosion.h"
#include "sim/run/bricked_engine.h"
#include "sim/run/dense_engine.h"
#include "sim/run/exact_engine.h"

namespace reamsim {

namespace {

std::unique_ptr<Detector> make_serial_detector(const Scenario& scenario, SerialState& state) {
  if (scenario.cutting.erosion == "exact") return std::make_unique<SerialReach>(state);
  if (scenario.engine.detector == "implicit") return std::make_unique<SerialImplicitDetector>(state);
  return std::make_unique<SerialDetector>(state);
}

std::unique_ptr<Erosion> make_serial_erosion(const Scenario& scenario, SerialState& state, double voxel_mm) {
  const EnergyTable table = make_energy_table(scenario.cutting, voxel_mm);
  if (scenario.cutting.erosion == "exact") return std::make_unique<SerialClip>(state, table);
  return std::make_unique<SerialErosion>(state, table);
}

/// The reference of every detector in plain C++: that of `implicit`, of those which look shell points up, and of
/// `exact`.
class SerialEngine final : public Engine {
 public:
  SerialEngine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool)
      : state_(make_serial_state(voxmap, tool)),
        detector_(make_serial_detector(scenario, state_)),
        erosion_(make_serial_erosion(scenario, state_, voxmap.grid.voxel_mm)) {}

  int begin(const SubstepArgs& args) override {
    state_.args.push_back(args);
    state_.sums.emplace_back();
    return static_cast<int>(state_.args.size()) - 1;
  }

  Detector& detector() override { return *detector_; }
  Erosion& erosion() override { return *erosion_; }
  [[nodiscard]] bool full() const override { return state_.args.size() >= 4096; }

  Batch collect() override {
    state_.args.clear();
    return {std::exchange(state_.sums, {}), detector_->take_seconds(), erosion_->take_seconds()};
  }

  RemovedFrames take_removed() override { return std::exchange(state_.removed, {}); }

  void read_fill(Voxmap& voxmap) override { copy_fill(state_.fill, voxmap); }
  void restore(const Voxmap& voxmap) override { take_bone(voxmap, state_); }
  [[nodiscard]] std::string device() const override { return "serial"; }
  [[nodiscard]] std::size_t device_bytes() const override { return 0; }
  [[nodiscard]] StructureBytes structure_bytes() const override { return {}; }

 private:
  SerialState state_;
  std::unique_ptr<Detector> detector_;
  std::unique_ptr<Erosion> erosion_;
};

}  // namespace

std::unique_ptr<Engine> make_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  if (scenario.engine.device == "serial") return std::make_unique<SerialEngine>(scenario, voxmap, tool);
  if (scenario.cutting.erosion == "exact") return make_exact_engine(scenario, voxmap, tool);
  if (scenario.engine.detector == "bricked") return make_bricked_engine(scenario, voxmap, tool);
  return make_dense_engine(scenario, voxmap, tool);
}

}  // namespace reamsim

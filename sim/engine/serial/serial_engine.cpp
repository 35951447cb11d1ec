#include "sim/engine/serial/serial_engine.h"

#include <utility>

#include "sim/base/stopwatch.h"
#include "sim/engine/common/dense_bone.h"
#include "sim/engine/serial/cut_contacts.h"
#include "sim/engine/serial/find_contacts.h"

namespace reamsim {

namespace {

FindContacts serial_detection(const Scenario& scenario, const SerialState& state) {
  if (scenario.cutting.erosion == ErosionMode::exact) return find_in_tool_box;
  if (scenario.engine.type == EngineKind::implicit) return find_by_profile;
  return find_by_points(state);
}

CutVoxel serial_cut(const Scenario& scenario, double voxel_mm) {
  const EnergyTable table = make_energy_table(scenario.cutting, voxel_mm);
  return scenario.cutting.erosion == ErosionMode::exact ? cut_by_clipping(table) : cut_touched(table);
}

/// The reference of every engine in plain C++: that of `implicit`, of those which look shell points up, and of `exact`.
class SerialEngine final : public Engine {
 public:
  SerialEngine(const Scenario& scenario, const BoneView& bone, const Tool& tool)
      : state_(make_serial_state(bone, tool)),
        find_(serial_detection(scenario, state_)),
        cut_(serial_cut(scenario, bone.voxmap.grid.voxel_mm)) {}

  void enqueue(const SubstepArgs& args) override {
    SubstepSums& sums = batch_.sums.emplace_back();
    StageTimes& times = batch_.times.emplace_back();
    const Stopwatch watch;
    find_(state_, args, sums);
    times.detect_s = watch.seconds();
    cut_contacts(state_, args, cut_, sums);
    times.cut_s = watch.seconds() - times.detect_s;
  }

  [[nodiscard]] bool full() const override { return batch_.sums.size() >= 4096; }
  Batch collect() override { return std::exchange(batch_, {}); }
  RemovedFrames take_removed() override { return std::exchange(state_.removed, {}); }
  void read_fill(const Voxmap& voxmap, FillBricks& fill) override { copy_fill(state_.fill, voxmap, fill); }
  void restore(const BoneView& bone) override { take_bone(bone, state_); }
  [[nodiscard]] std::string device() const override { return "serial"; }
  [[nodiscard]] std::size_t device_bytes() const override { return 0; }
  [[nodiscard]] StructureBytes structure_bytes() const override { return {}; }

 private:
  SerialState state_;
  FindContacts find_;
  CutVoxel cut_;
  Batch batch_;
};

}  // namespace

std::unique_ptr<Engine> make_serial_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool) {
  return std::make_unique<SerialEngine>(scenario, bone, tool);
}

}  // namespace reamsim

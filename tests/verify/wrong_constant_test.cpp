// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The suite must fail where the program is wrong: engines with one wrong constant each, and the cases that find them.
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/engine/common/engine.h"
#include "sim/verify/suite.h"
#include "tests/verify/findings.h"

namespace reamsim::verify {
namespace {

/// What is wrong with an engine: with what it is told of a substep, or with what it gives.
struct Fault {
  std::function<void(SubstepArgs&)> args = [](SubstepArgs&) {};
  std::function<void(SubstepSums&)> sums = [](SubstepSums&) {};
};

/// An engine with a fault.
class FaultyEngine final : public Engine {
 public:
  FaultyEngine(std::unique_ptr<Engine> engine, Fault fault) : engine_(std::move(engine)), fault_(std::move(fault)) {}

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> /*window*/) override {
    SubstepArgs faulty = args;
    fault_.args(faulty);
    engine_->enqueue(faulty);
  }
  Batch collect() override {
    Batch batch = engine_->collect();
    for (SubstepSums& sums : batch.sums) fault_.sums(sums);
    return batch;
  }
  [[nodiscard]] bool full() const override { return engine_->full(); }
  RemovedFrames take_removed() override { return engine_->take_removed(); }
  void read_fill(const Voxmap& voxmap, FillBricks& fill) override { engine_->read_fill(voxmap, fill); }
  void restore(const BoneView& bone) override { engine_->restore(bone); }
  [[nodiscard]] std::string device() const override { return engine_->device(); }
  [[nodiscard]] std::size_t device_bytes() const override { return engine_->device_bytes(); }
  [[nodiscard]] StructureBytes structure_bytes() const override { return engine_->structure_bytes(); }

 private:
  std::unique_ptr<Engine> engine_;
  Fault fault_;
};

Setting faulty(const Fault& fault) {
  Setting setting;
  setting.engine = [=](const Scenario& scenario, const BoneView& bone, const Tool& tool) {
    return std::make_unique<FaultyEngine>(make_engine(scenario, bone, tool), fault);
  };
  return setting;
}

void scale(rs_i64& sum, double factor) {
  sum = static_cast<rs_i64>(static_cast<double>(sum) * factor);
}

void scale_loads(SubstepSums& sums, double factor) {
  for (int i = 0; i < 3; ++i) {
    scale(sums.force[i], factor);
    scale(sums.torque[i], factor);
  }
}

/// The figures of a case that fail.
std::vector<std::string> failures(const std::string& id, const Fault& fault) {
  std::vector<std::string> out;
  for (const Check& check : run_case(id, faulty(fault)).checks) {
    if (!check.passed()) out.push_back(check.quantity);
  }
  return out;
}

TEST(WrongConstant, NoFaultFailsNothing) {
  EXPECT_TRUE(failures("energy", {}).empty());
}

TEST(WrongConstant, SpecificEnergyOnePerCentTooLarge) {
  // The identity holds, because both its sides are wrong; what the bone that is gone should take does not.
  Fault fault;
  fault.sums = [](SubstepSums& sums) {
    scale_loads(sums, 1.01);
    scale(sums.energy, 1.01);
    scale(sums.floor_energy, 1.01);
  };
  EXPECT_EQ(failures("energy", fault), std::vector<std::string>{"E_cut against the removed bone"});
  EXPECT_FALSE(failures("steady", fault).empty());
  EXPECT_FALSE(failures("layered", fault).empty());
}

TEST(WrongConstant, ForcesATenthOfAPerCentTooLarge) {
  Fault fault;
  fault.sums = [](SubstepSums& sums) { scale_loads(sums, 1.001); };
  EXPECT_FALSE(failures("energy", fault).empty());
}

TEST(WrongConstant, NormalRatioTwoPerCentTooLarge) {
  // It does no work, so that only the axial force shows it.
  Fault fault;
  fault.args = [](SubstepArgs& args) { args.normal_ratio *= 1.02F; };
  EXPECT_TRUE(failures("energy", fault).empty());
  const auto failed = failures("steady", fault);
  EXPECT_FALSE(failed.empty());
  EXPECT_TRUE(
      std::all_of(failed.begin(), failed.end(), [](const auto& what) { return what.starts_with("axial force"); }));
  EXPECT_FALSE(failures("ratio", fault).empty());
}

TEST(WrongConstant, TorqueOverThrustSaysNothingOfTheSpecificEnergy) {
  Fault fault;
  fault.sums = [](SubstepSums& sums) { scale_loads(sums, 2); };
  EXPECT_TRUE(failures("ratio", fault).empty());
}

TEST(WrongConstant, ALateralForceOnePerCentTooLarge) {
  // In full contact it cancels, so that the steady plunge does not see it.
  Fault fault;
  fault.sums = [](SubstepSums& sums) {
    scale(sums.force[0], 1.01);
    scale(sums.force[1], 1.01);
  };
  EXPECT_TRUE(failures("steady", fault).empty());
  EXPECT_FALSE(failures("half_face", fault).empty());
}

TEST(WrongConstant, SpeedFloorAtTwentyInsteadOfTen) {
  Fault fault;
  fault.args = [](SubstepArgs& args) { args.floor_rate *= 0.5F; };
  EXPECT_FALSE(failures("energy", fault).empty());
}

TEST(WrongConstant, AToolOneMicrometreTooLow) {
  Fault fault;
  fault.args = [](SubstepArgs& args) { args.brick_origin[2] += static_cast<rs_i64>(1e-3 * RS_LENGTH_SCALE); };
  EXPECT_FALSE(failures("half_space", fault).empty());
}

TEST(WrongConstant, AForceWithoutACut) {
  Fault fault;
  fault.sums = [](SubstepSums& sums) { sums.torque[2] += static_cast<rs_i64>(1e-3 * RS_TORQUE_SCALE); };
  for (const char* id : {"zero_feed", "retraction", "second_pass"}) {
    EXPECT_EQ(failures(id, fault), std::vector<std::string>{"largest torque"}) << id;
  }
}

TEST(WrongConstant, AForceThatLeansToOneSide) {
  Fault fault;
  fault.sums = [](SubstepSums& sums) { sums.force[0] += sums.force[2] / 100; };
  EXPECT_FALSE(failures("mirrored", fault).empty());
}

}  // namespace
}  // namespace reamsim::verify

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Engine::restore: a run on restored bone is the first run again.
#include <tuple>

#include "sim/base/error.h"
#include "sim/engine/common/engine.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::restore_tests {
namespace {

/// Device and engine.
class Restore : public testing::TestWithParam<std::tuple<std::string, std::string>> {
 protected:
  static SimulationInput scene() { return oblique_scene(std::get<0>(GetParam()), std::get<1>(GetParam())); }
};

TEST_P(Restore, ARestoredEngineRunsAgainAlike) {
  for (const ErosionMode erosion : {ErosionMode::remove, ErosionMode::wear}) {
    SCOPED_TRACE(name_of(erosion));
    SimulationInput scene = Restore::scene();
    scene.scenario.cutting.erosion = erosion;
    const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
    const Outcome first = run_on(*engine, scene);
    EXPECT_GT(first.removed.size(), 100U);
    EXPECT_LT(run_on(*engine, scene).totals.energy_mj, first.totals.energy_mj) << "the bone was gone already";
    engine->restore(scene.bone);
    expect_same(run_on(*engine, scene), first);
  }
}

TEST_P(Restore, TakesTheBoneAsItIsThen) {
  SimulationInput scene = Restore::scene();
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  run_on(*engine, scene);
  for (std::int64_t e = 0; e < scene.bone.voxmap->grid.size(); e += 2) {
    scene.bone.fill.set(scene.bone.voxmap->grid.coord(e), 0);
  }
  engine->restore(scene.bone);
  expect_same(run_on(*engine, scene), run(scene));
}

INSTANTIATE_TEST_SUITE_P(Engines, Restore,
                         testing::Combine(testing::Values("serial", "auto"), testing::ValuesIn(kEngines)),
                         [](const auto& tested) {
                           return std::get<0>(tested.param) + "_" + std::get<1>(tested.param);
                         });

class RestoreOnDevice : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Engines, RestoreOnDevice, testing::Values("direct", "bricked"),
                         [](const auto& tested) { return tested.param; });

TEST_P(RestoreOnDevice, RefusesBoneThatItsMemoryWasNotPlannedFor) {
  SimulationInput scene = oblique_scene("auto", GetParam());
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  EXPECT_THROW(engine->restore(random_bone({41, 37, 28}, 0.2, 7)), RunError);
  scene.bone.fill.set({20, 20, 20}, 1000);
  EXPECT_THROW(engine->restore(scene.bone), RunError);  // made without room for fill
}

}  // namespace
}  // namespace reamsim::test::restore_tests

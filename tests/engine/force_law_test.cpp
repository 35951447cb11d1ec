// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Options of the force law: what each adds, in closed form; the energy account; and the serial reference's bytes.
#include <iostream>
#include <sstream>

#include "kernels/cut_law.h"
#include "sim/engine/common/tables.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::force_law_tests {
namespace {

constexpr double kRadius = 29, kRim = 15, kBore = 1.25, kRpm = 250, kOmega = kRpm * 2 * M_PI / 60;

CuttingSettings size_effect(CuttingSettings cutting, double exponent = 0.4) {
  cutting.size_effect = SizeEffectSettings{
      .exponent = exponent, .reference_mm = 0.05, .least_mm = 0.001, .most_mm = 0.5, .cutting_edges = 6};
  return cutting;
}

CuttingSettings edge_force(CuttingSettings cutting) {
  cutting.edge_force = EdgeForceSettings{.tangential_n_mm = 1.5, .normal_n_mm = 2.5, .cutting_edges = 6};
  return cutting;
}

CuttingSettings table(CuttingSettings cutting) {
  cutting.specific_energy_table = {{0.2, 0.001}, {0.9, 0.03}, {1.7, 0.16}};
  return cutting;
}

/// A face of revolution about a bore, and how its normal leans.
struct Face {
  std::string name;
  Profile profile;
  double radius = 0;  ///< 0: flat
};

Face convex() {
  return {"convex", cap_profile(kRadius, 2 * kRim, 8, kBore), kRadius};
}
Face flat() {
  Profile profile;
  profile.points = {{kBore, 0}, {kRim, 0}, {kRim, 8}, {kBore, 8}};
  return {"flat", profile};
}

/// Integral from the bore to the rim, by the midpoint rule. `integrand(r, c)` with c the cosine between normal and
/// axis.
template <class Integrand>
double over_face(const Face& face, const Integrand& integrand) {
  constexpr int kSteps = 20000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double r = kBore + (kRim - kBore) * (i + 0.5) / kSteps;
    const double cosine = face.radius > 0 ? std::sqrt(1 - r * r / (face.radius * face.radius)) : 1;
    sum += integrand(r, cosine) * (kRim - kBore) / kSteps;
  }
  return sum;
}

struct Mean {
  double torque = 0;  ///< about the axis, N·mm
  double thrust = 0;  ///< N
  double energy = 0;  ///< a frame, mJ
  double contacts = 0;
};

/// Means over the rows of forces.csv from `begin` to before `end`.
Mean mean_of(const std::string& csv, int begin, int end) {
  std::stringstream lines(csv);
  std::string line;
  Mean out;
  for (int row = -1; std::getline(lines, line); ++row) {
    if (row < begin || row >= end) continue;
    std::stringstream fields(line);
    std::vector<double> v;
    for (std::string field; std::getline(fields, field, ',');) v.push_back(std::stod(field));
    out.thrust += v[18] / (end - begin);
    out.torque += v[19] / (end - begin);
    out.contacts += v[20] / (end - begin);
    out.energy += v[22] / (end - begin);
  }
  return out;
}

// A plunge in three parts: fast until the whole face cuts, then a slow feed, then a rest, then a slow way out.
constexpr double kRateHz = 100, kFeed = 1, kFull = 4.4, kVoxel = 0.5;
constexpr int kFast = 25, kSlow = 50, kRest = 10, kOut = 10;
constexpr int kSlowBegin = kFast + 1, kRestBegin = kSlowBegin + kSlow, kOutBegin = kRestBegin + kRest;

SimulationInput plunge(const Face& face, const CuttingSettings& cutting, double voxel_mm) {
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  scene.scenario.cutting = cutting;
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.bone.set_voxels(block({33, 33, 6}, voxel_mm, 1.8));
  scene.tool = make_tool(face.profile, 64);
  std::vector<double> depths;
  for (int k = 0; k <= kFast; ++k) depths.push_back(-0.1 + (kFull + 0.1) * k / kFast);
  for (int k = 0; k < kSlow; ++k) depths.push_back(depths.back() + kFeed / kRateHz);
  for (int k = 0; k < kRest; ++k) depths.push_back(depths.back());
  for (int k = 0; k < kOut; ++k) depths.push_back(depths.back() - kFeed / kRateHz);
  scene.motion = straight(Vec3::Zero(), Vec3::Zero(), static_cast<int>(depths.size()) - 1, kRateHz, kRpm);
  std::vector<ToolPose> poses = scene.motion.poses.all();
  for (std::size_t k = 0; k < depths.size(); ++k) poses[k].position_mm = {0.03, 0.05, -depths[k]};
  scene.motion.poses = poses;
  return scene;
}

TEST(Power, EqualsTheLibrarys) {
  constexpr unsigned kSeed = 5;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> decades(-6, 6), exponent(-1, 1);
  double worst = 0;
  for (int i = 0; i < 100'000; ++i) {
    const auto x = static_cast<float>(std::pow(10, decades(random)));
    const auto y = static_cast<float>(exponent(random));
    worst = std::max(worst, std::abs(rs_power(x, y) / std::pow(static_cast<double>(x), static_cast<double>(y)) - 1));
  }
  std::cout << "worst relative error " << worst << '\n';
  EXPECT_LT(worst, 3e-6);
  EXPECT_EQ(rs_power(1, -0.7F), 1);
  EXPECT_EQ(rs_power(8, 1), 8);
}

TEST(EnergyTable, FineTableIsThePowerLaw) {
  CuttingSettings cutting;
  constexpr double kStep = 0.005;
  const EnergyTable power = make_energy_table(cutting, 0.3);
  for (int i = 0; i <= 400; ++i) {
    const double density = i * kStep;
    cutting.specific_energy_table.push_back({density, 0.15 * std::pow(density / 1.8, 2)});
  }
  const EnergyTable sampled = make_energy_table(cutting, 0.3);
  // A chord lies above a parabola by at most its second derivative times step²/8.
  const double most = 1000 * 0.027 * (2 * 0.15 / (1.8 * 1.8)) * kStep * kStep / 8;
  for (std::size_t grade = 1; grade <= 250; ++grade) {
    EXPECT_GE(sampled.energy_mj[grade], power.energy_mj[grade] * (1 - 1e-12)) << grade;
    EXPECT_LE(sampled.energy_mj[grade], power.energy_mj[grade] + most * (1 + 1e-9)) << grade;
  }
}

TEST(EnergyTable, IsConstantBeyondItsEnds) {
  const EnergyTable out = make_energy_table(table({}), 1);
  EXPECT_DOUBLE_EQ(out.energy_mj[1], 1);
  EXPECT_DOUBLE_EQ(out.energy_mj[25], 1);                     // 0.2 g/cm³
  EXPECT_NEAR(out.energy_mj[100], 1 + 29 * 0.6 / 0.7, 1e-9);  // 0.8 g/cm³
  EXPECT_DOUBLE_EQ(out.energy_mj[250], 160);
}

TEST(SizeEffect, TheAdvanceIsTheVelocityOfTheSurfaceAlongItsNormal) {
  constexpr unsigned kSeed = 31;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const Vec3 velocity(u(random), u(random), u(random)), turn(u(random), u(random), 20 * u(random));
    const Vec3 point(10 * u(random), 10 * u(random), 10 * u(random));
    const Vec3 radial = Vec3(point.x(), point.y(), 0).normalized();
    const Vec3 n = (u(random) * radial + u(random) * Vec3::UnitZ()).normalized();  // of a surface of revolution
    SubstepArgs args{};
    rs_real at[3], along[3];
    for (int axis = 0; axis < 3; ++axis) {
      args.origin_velocity[axis] = static_cast<float>(velocity[axis]);
      args.angular_velocity[axis] = static_cast<float>(turn[axis]);
      at[axis] = static_cast<float>(point[axis]);
      along[axis] = static_cast<float>(n[axis]);
    }
    EXPECT_NEAR(rs_advance(&args, along, at), n.dot(velocity + turn.cross(point)), 2e-5);
  }
}

TEST(SizeEffect, ScalesTheTorqueOfAPlunge) {
  constexpr double kExponent = 0.4;
  for (const Face& face : {flat(), convex()}) {
    SCOPED_TRACE(face.name);
    const Outcome plain = run(plunge(face, {}, kVoxel)), sized = run(plunge(face, size_effect({}, kExponent), kVoxel));
    EXPECT_EQ(plain.fill, sized.fill);
    const double chip = kFeed / (kRpm / 60 * 6);
    const double expected =
        over_face(face, [&](double r, double c) { return r * std::pow(0.05 / (chip * c), kExponent); }) /
        over_face(face, [](double r, double) { return r; });
    const Mean without = mean_of(plain.forces, kSlowBegin, kRestBegin);
    const Mean with = mean_of(sized.forces, kSlowBegin, kRestBegin);
    std::cout << face.name << ": torque " << without.torque << " and " << with.torque << ", ratio "
              << with.torque / without.torque << " of " << expected << "; balance " << sized.totals.balance << '\n';
    EXPECT_NEAR(without.torque / (M_PI * 150 * (kRim * kRim - kBore * kBore) * kFeed / kOmega), 1, 0.01);
    // Voxels at the rim lean with the edge between face and side, so that their chips are thinner.
    EXPECT_NEAR(with.torque / without.torque / expected, 1, kVoxel / kRim / 3);
    EXPECT_NEAR(with.energy / without.energy / expected, 1, kVoxel / kRim / 3);
    EXPECT_LT(std::abs(sized.totals.balance), 3e-7);
  }
}

TEST(SizeEffect, ThinnestChipIsTheLimit) {
  // A feed so slow, and cutting edges so many, that every chip is thinner than the least.
  CuttingSettings cutting = size_effect({});
  cutting.size_effect->cutting_edges = 1000;
  cutting.size_effect->least_mm = 0.01;
  const Outcome plain = run(plunge(convex(), {}, kVoxel)), sized = run(plunge(convex(), cutting, kVoxel));
  const double ratio = sized.totals.energy_mj / plain.totals.energy_mj;
  EXPECT_NEAR(ratio, std::pow(5, 0.4), 1e-5);
}

TEST(EdgeForce, AtRestIsFrictionOfTheLips) {
  for (const Face& face : {flat(), convex()}) {
    for (const double voxel_mm : {0.5, 0.25}) {
      SCOPED_TRACE(face.name + ", " + std::to_string(voxel_mm) + " mm");
      const Outcome outcome = run(plunge(face, edge_force({}), voxel_mm));
      const Mean rest = mean_of(outcome.forces, kRestBegin, kOutBegin);
      const double torque = 1.5 * 6 * over_face(face, [](double r, double c) { return r / c; });
      const double thrust = 2.5 * 6 * (kRim - kBore);
      std::cout << face.name << ", " << voxel_mm << " mm: torque " << rest.torque << " of " << torque << ", thrust "
                << rest.thrust << " of " << thrust << "; balance " << outcome.totals.balance << '\n';
      // The rim is met to half a voxel, and the torque goes with its square.
      EXPECT_NEAR(rest.torque / torque, 1, voxel_mm / kRim);
      EXPECT_NEAR(rest.thrust / thrust, 1, voxel_mm / kRim);
      EXPECT_NEAR(rest.energy / (rest.torque * kOmega / kRateHz), 1, 1e-6) << "all of it is work of the torque";
      EXPECT_LT(std::abs(outcome.totals.balance), 3e-7);
      // Contacts are voxels that lose something, and what the cutting edges only rub on loses nothing.
      EXPECT_EQ(rest.contacts, 0);
      EXPECT_GT(mean_of(outcome.forces, kSlowBegin, kRestBegin).contacts, 0);
    }
  }
}

TEST(EdgeForce, AddsToTheCutAndEndsWithContact) {
  const Outcome plain = run(plunge(convex(), {}, kVoxel)), edged = run(plunge(convex(), edge_force({}), kVoxel));
  EXPECT_EQ(plain.fill, edged.fill);
  EXPECT_EQ(plain.removed, edged.removed);
  const double with = mean_of(edged.forces, kSlowBegin, kRestBegin).torque;
  const double without = mean_of(plain.forces, kSlowBegin, kRestBegin).torque;
  const double torque = 1.5 * 6 * over_face(convex(), [](double r, double c) { return r / c; });
  std::cout << "torque of the edges while cutting " << with - without << " of " << torque << '\n';
  EXPECT_NEAR((with - without) / torque, 1, 0.01) << "over a voxel's feed the rim's place averages out";
  EXPECT_EQ(mean_of(plain.forces, kRestBegin, kOutBegin).torque, 0);
  // On the way out only the rim's corner brushes the wall of its own bore.
  EXPECT_LT(mean_of(edged.forces, kOutBegin + 1, kOutBegin + kOut).torque / torque, 1e-3);
}

TEST(FrictionShare, ChangesNoForce) {
  SimulationInput scene = oblique_scene("auto");
  const Outcome without = run(scene);
  scene.scenario.cutting.friction_fraction = 0.3;
  expect_same(run(scene), without);
}

/// The fraction that a voxel loses to a tool at rest on it, by wear of 1.2 g/cm³ per second; bone of 0.8 g/cm³.
double worn_fraction(int frames, const std::string& engine) {
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  choose_engine(scene.scenario.engine, engine);
  scene.scenario.cutting.erosion = ErosionMode::wear;
  scene.scenario.cutting.wear_g_cm3_per_s = 1.2;
  scene.bone.set_voxels(block({10, 10, 4}, 0.5, 0.8));
  scene.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 61);
  scene.motion = straight({0, 0, -0.3}, {0, 0, -0.3}, frames, 100, 250);
  const Outcome outcome = run(scene);
  return 1 - double(*std::ranges::min_element(outcome.fill)) / FillBricks::kWhole;
}

TEST(Wear, LowersTheDensityAtItsRate) {
  for (const std::string engine : {"bricked", "bricked_gpu", "direct", "octree"}) {
    const double lost = worn_fraction(50, engine) - worn_fraction(10, engine);
    EXPECT_NEAR(lost, 1.2 * 0.4 / 0.8, 1e-3) << engine;
  }
}

/// Every option, under every erosion that has it.
struct Options {
  std::string name;
  ErosionMode erosion;
  CuttingSettings cutting;
};

std::vector<Options> options() {
  std::vector<Options> out;
  for (const ErosionMode erosion : {ErosionMode::remove, ErosionMode::wear, ErosionMode::exact}) {
    out.push_back({std::string("table_size_effect_") + name_of(erosion), erosion, size_effect(table({}))});
  }
  out.push_back({"table_edge_force_exact", ErosionMode::exact, edge_force(table({}))});
  return out;
}

class ForceOptions : public testing::TestWithParam<Options> {
 protected:
  static SimulationInput scene(const std::string& device, const std::string& engine) {
    SimulationInput out = oblique_scene(device, engine);
    out.scenario.cutting = GetParam().cutting;
    out.scenario.cutting.erosion = GetParam().erosion;
    out.scenario.cutting.wear_g_cm3_per_s = 30;
    return out;
  }
};

INSTANTIATE_TEST_SUITE_P(Erosions, ForceOptions, testing::ValuesIn(options()),
                         [](const testing::TestParamInfo<Options>& tested) { return tested.param.name; });

TEST_P(ForceOptions, EqualTheSerialReference) {
  const Outcome serial = run(scene("serial", "bricked"));
  EXPECT_GT(serial.totals.peak_force_n, 0);
  EXPECT_LT(std::abs(serial.totals.balance), 3e-7);
  const bool exact = GetParam().erosion == ErosionMode::exact;
  // Engines with a shell share one serial reference; every other one of the kernels' shapes is in Agreement.
  for (const std::string engine : {"bricked", "bricked_gpu", "direct", "octree"}) {
    if (exact && engine.find("bricked") == std::string::npos) continue;
    SCOPED_TRACE(engine);
    expect_same(run(scene("auto", engine)), serial);
  }
  if (!exact) expect_same(run(scene("auto", "implicit")), run(scene("serial", "implicit")));
}

TEST_P(ForceOptions, TheBatchDoesNotMatter) {
  SimulationInput one_by_one = scene("auto", "bricked"), all = one_by_one;
  one_by_one.scenario.engine.batch_frames = 1;
  all.scenario.engine.batch_frames = 1000;
  expect_same(run(one_by_one), run(all));
}

}  // namespace
}  // namespace reamsim::test::force_law_tests

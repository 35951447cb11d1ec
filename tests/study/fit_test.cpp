// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Constants of the force law from simulated measurements of a block of two layers.
#include <gmock/gmock.h>

#include <iostream>
#include <numbers>

#include "sim/scenario/presets.h"
#include "sim/study/fit_forces.h"
#include "tests/study/basis_scene.h"

namespace reamsim::test::fit_tests {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kUpper_g_cm3 = 1.2, kLower_g_cm3 = 0.6;

/// A block of two layers of 1 mm and more.
SimulationInput two_layers(double upper_g_cm3 = kUpper_g_cm3, double lower_g_cm3 = kLower_g_cm3) {
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  scene.scenario.cutting.erosion = ErosionMode::exact;
  FilledVoxmap voxels = block({14, 14, 5}, 0.5, upper_g_cm3);
  const std::uint8_t lower = DensityMapping::grade_from_density(lower_g_cm3);
  for (std::int64_t e = 0; e < voxels.grid.size(); ++e) {
    const Vec3i at = voxels.grid.coord(e);
    if (voxels.grid.center_mm(at).z() < -1) voxels.grade.set(at, lower);
  }
  scene.bone.set_voxels(std::move(voxels));
  scene.tool = make_tool(cap_profile(12, 8, 4, 1), 64);
  scene.motion = straight({0.03, 0.05, 0.1}, {0.03, 0.05, -2.9}, 400, 100, 250);
  return scene;
}

struct Simulated {
  ForceBasis basis{{}};
  std::vector<FrameTime> frames;
  CuttingSettings cutting;
};

Simulated simulated(const SimulationInput& scene) {
  const RowSink run = rows_of(scene, true);
  Simulated out{ForceBasis(run.basis_rows), {}, scene.scenario.cutting};
  for (const FrameResult& r : run.results)
    out.frames.push_back({r.time_s, r.frame, r.pose.orientation * Vec3::UnitZ()});
  return out;
}

/// The forces of a bone with these constants, as a test bench measures them. `noise`: standard deviation, relative to
/// the column's largest value.
MeasuredForces measure(const Simulated& run, const ForceConstants& truth, std::vector<ForceChannel> channels,
                       double noise, std::mt19937& random) {
  MeasuredForces out{std::move(channels), {}, {}};
  out.values.resize(out.channels.size());
  for (const FrameTime& frame : run.frames) {
    const FrameForces f = run.basis.forces(frame.frame, truth);
    out.time_s.push_back(frame.time_s);
    for (std::size_t c = 0; c < out.channels.size(); ++c)
      out.values[c].push_back(channel_value(out.channels[c], f.force_n, f.torque_nmm, frame.tool_z));
  }
  for (std::vector<double>& values : out.values) {
    const double largest = std::abs(*std::ranges::max_element(values, {}, [](double v) { return std::abs(v); }));
    // Box and Muller: the library's normal distribution may differ from one standard library to another.
    for (double& value : values) {
      const double a = (static_cast<double>(random()) + 1) / 4294967297.0,
                   b = static_cast<double>(random()) / 4294967296.0;
      value += noise * largest * std::sqrt(-2 * std::log(a)) * std::cos(2 * std::numbers::pi * b);
    }
  }
  return out;
}

/// The specific energies of the layers, J/mm3, and k_n: none of them those of the run.
constexpr double kU1 = 0.031, kU2 = 0.087, kNormal = 0.34;

ForceConstants true_constants() {
  ForceConstants truth;
  truth.normal_ratio = kNormal;
  for (int grade = 1; grade <= 250; ++grade)  // u1 is that of the lower density
    truth.specific_energy_n_mm2[static_cast<std::size_t>(grade)] = 1000 * (grade * 0.008 < 0.9 ? kU1 : kU2);
  return truth;
}

const std::vector<ForceChannel> kAxial{ForceChannel::axial_force, ForceChannel::spin_torque};
const FitOptions kClasses{.model = FitModel::classes, .class_edges_g_cm3 = {}};

TEST(Fit, FindsTheLayersWithoutNoise) {
  const Simulated run = simulated(two_layers());
  std::mt19937 random(1);
  const ForceFit fit =
      fit_forces(run.basis, run.frames, run.cutting, measure(run, true_constants(), kAxial, 0, random), kClasses);
  ASSERT_EQ(fit.classes.size(), 2U);
  EXPECT_NEAR(fit.classes[0].mean_g_cm3, kLower_g_cm3, 0.005);
  std::cout << "u1 " << fit.of("u1").value << ", u2 " << fit.of("u2").value << ", k_n " << fit.of("k_n").value << '\n';
  EXPECT_NEAR(fit.of("u1").value / kU1, 1, 0.005);
  EXPECT_NEAR(fit.of("u2").value / kU2, 1, 0.005);
  EXPECT_NEAR(fit.of("k_n").value / kNormal, 1, 0.005);
  EXPECT_THAT(fit.statements, Contains(HasSubstr("all constants are determined")));
  for (const ChannelResidual& r : fit.residuals) EXPECT_LT(r.rms, 1e-5 * r.rms_measured);
}

TEST(Fit, FindsTheLayersOfARerun) {
  // Not from the basis, but from a run of its own with a table.
  const Simulated run = simulated(two_layers());
  SimulationInput again = two_layers();
  again.scenario.cutting.specific_energy_table = {{0.6, kU1}, {1.2, kU2}};
  again.scenario.cutting.normal_ratio = kNormal;
  MeasuredForces measured{kAxial, {}, {{}, {}}};
  for (const FrameResult& r : rows_of(again, false).results) {
    measured.time_s.push_back(r.time_s);
    measured.values[0].push_back(r.axial_force_n);
    measured.values[1].push_back(r.spin_torque_nmm);
  }
  const ForceFit fit = fit_forces(run.basis, run.frames, run.cutting, measured, kClasses);
  std::cout << "u1 " << fit.of("u1").value / kU1 - 1 << ", u2 " << fit.of("u2").value / kU2 - 1 << ", k_n "
            << fit.of("k_n").value / kNormal - 1 << " (relative errors)\n";
  EXPECT_NEAR(fit.of("u1").value / kU1, 1, 0.005);
  EXPECT_NEAR(fit.of("u2").value / kU2, 1, 0.005);
  EXPECT_NEAR(fit.of("k_n").value / kNormal, 1, 0.005);
}

TEST(Fit, CoversTheTruthWithNoise) {
  constexpr int kRepetitions = 200;
  constexpr double kNoise = 0.02, kTwoSided95 = 1.96;
  constexpr unsigned kSeed = 20;
  std::cout << "seed " << kSeed << '\n';
  const Simulated run = simulated(two_layers());
  std::mt19937 random(kSeed);
  const std::map<std::string, double> truth{{"u1", kU1}, {"u2", kU2}, {"k_n", kNormal}};
  std::map<std::string, int> covered, within_three;
  for (int i = 0; i < kRepetitions; ++i) {
    const ForceFit fit = fit_forces(run.basis, run.frames, run.cutting,
                                    measure(run, true_constants(), kAxial, kNoise, random), kClasses);
    for (const auto& [name, value] : truth) {
      const FittedConstant& found = fit.of(name);
      const double errors = std::abs(found.value - value) / found.standard_error;
      covered[name] += errors <= kTwoSided95 ? 1 : 0;
      within_three[name] += errors <= 3 ? 1 : 0;
      if (i == 0) {
        std::cout << name << " " << found.value << " +- " << found.standard_error << " of " << value << '\n';
        EXPECT_LE(errors, 3) << name;
      }
    }
  }
  for (const auto& [name, value] : truth) {
    std::cout << name << ": " << covered[name] << " of " << kRepetitions << " intervals of 95 % cover the truth, "
              << within_three[name] << " within 3 standard errors\n";
    // Binomial, n = 200, p = 0.95: 180 to 199 with a probability above 0.99.
    EXPECT_GE(covered[name], 180) << name;
    EXPECT_LE(covered[name], 199) << name;
    EXPECT_GE(within_three[name], 196) << name;
  }
}

TEST(Fit, FindsTheLawOfTwoDensities) {
  const Simulated run = simulated(two_layers());
  CuttingSettings law = run.cutting;
  law.specific_energy_j_mm3 = 0.21;
  law.density_exponent = 1.4;
  law.normal_ratio = 0.7;
  std::mt19937 random(3);
  const ForceFit fit =
      fit_forces(run.basis, run.frames, run.cutting, measure(run, force_constants(law), kAxial, 0, random), {});
  EXPECT_NEAR(fit.of("u0").value, 0.21, 0.21 * 0.005);
  EXPECT_NEAR(fit.of("p").value, 1.4, 0.01);
  EXPECT_NEAR(fit.of("k_n").value, 0.7, 0.005);
}

TEST(Fit, SaysThatOneDensityCannotTellTheExponent) {
  const Simulated run = simulated(two_layers(1.2, 1.2));
  CuttingSettings law = run.cutting;
  law.specific_energy_j_mm3 = 0.21;
  law.density_exponent = 1.4;
  std::mt19937 random(4);
  const ForceFit fit =
      fit_forces(run.basis, run.frames, run.cutting, measure(run, force_constants(law), kAxial, 0.02, random), {});
  EXPECT_FALSE(fit.of("p").fitted);
  EXPECT_EQ(fit.of("p").value, run.cutting.density_exponent);
  EXPECT_THAT(fit.statements, Contains(HasSubstr("cannot tell the exponent from u0")));
  const double u = 0.21 * std::pow(1.2 / 1.8, 1.4), found = fit.of("u0").value * std::pow(1.2 / 1.8, 2);
  EXPECT_NEAR(found / u, 1, 0.02) << "the specific energy of that density is determined";
}

TEST(Fit, SaysThatTorqueAloneCannotTellTheNormalRatio) {
  const Simulated run = simulated(two_layers());
  std::mt19937 random(5);
  const ForceFit fit = fit_forces(run.basis, run.frames, run.cutting,
                                  measure(run, true_constants(), {ForceChannel::spin_torque}, 0.01, random), kClasses);
  EXPECT_FALSE(fit.of("k_n").fitted);
  EXPECT_THAT(fit.statements, Contains(HasSubstr("do not tell k_n")));
  EXPECT_NEAR(fit.of("u1").value / kU1, 1, 0.02);
  EXPECT_NEAR(fit.of("u2").value / kU2, 1, 0.02);
}

TEST(Fit, SaysThatAxialForceAloneDeterminesAProduct) {
  const Simulated run = simulated(two_layers());
  std::mt19937 random(6);
  const ForceFit fit = fit_forces(run.basis, run.frames, run.cutting,
                                  measure(run, true_constants(), {ForceChannel::axial_force}, 0.01, random), kClasses);
  EXPECT_THAT(fit.statements, Contains(HasSubstr("hard to tell apart")));
}

/// The message of the InputError that a fit ends with; "" where it does not.
std::string refusal_of(const Simulated& run, const MeasuredForces& measured, const FitOptions& options) {
  try {
    fit_forces(run.basis, run.frames, run.cutting, measured, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void expect_refusals(const Simulated& run) {
  std::mt19937 random(8);
  const FitOptions fixed{.class_edges_g_cm3 = {}, .fit_normal_ratio = false};
  for (const std::vector<ForceChannel>& channels : {kAxial, {ForceChannel::axial_force}}) {
    MeasuredForces reversed = measure(run, true_constants(), channels, 0.02, random);
    reversed.file = "measured.csv";
    for (std::vector<double>& values : reversed.values)
      for (double& value : values) value = -value;
    for (const FitOptions& options : {FitOptions(), fixed, kClasses}) {
      const std::string name = options.model == FitModel::law ? "u0" : "u1";
      EXPECT_THAT(refusal_of(run, reversed, options), HasSubstr("measured.csv: " + name + " is 0: a negative value"));
    }
    for (std::vector<double>& values : reversed.values) std::ranges::fill(values, 0);
    EXPECT_THAT(refusal_of(run, reversed, {}), HasSubstr("every measured value in the time of contact is 0"));
  }
}

TEST(Fit, RefusesForcesThatNoPositiveEnergyExplains) {
  expect_refusals(simulated(two_layers()));
  expect_refusals(simulated(two_layers(1.2, 1.2)));
}

TEST(Fit, WarnsOfOtherSignsAndUnits) {
  const Simulated run = simulated(two_layers());
  CuttingSettings law = run.cutting;
  law.specific_energy_j_mm3 = 0.21;
  std::mt19937 random(9);
  const MeasuredForces right = measure(run, force_constants(law), kAxial, 0.01, random);
  const auto warnings = [&](double axial_factor, double torque_factor, const FitOptions& options) {
    MeasuredForces wrong = right;
    for (double& value : wrong.values[0]) value *= axial_factor;
    for (double& value : wrong.values[1]) value *= torque_factor;
    return fit_forces(run.basis, run.frames, run.cutting, wrong, options).warnings;
  };
  EXPECT_THAT(warnings(1, 1, {}), ::testing::IsEmpty());
  EXPECT_THAT(warnings(1, 1, kClasses), ::testing::IsEmpty());
  EXPECT_THAT(warnings(1, 0.001, {}), Contains(HasSubstr("axial_force_n: R2 is -"))) << "N m";
  EXPECT_THAT(warnings(-1, 1, {}),
              Contains(HasSubstr("check sign and unit of every measured column (axial_force_n in N, "
                                 "spin_torque_nmm in N mm)")));
  EXPECT_THAT(warnings(1, -1, {}), Contains(HasSubstr("spin_torque_nmm: R2 is -")));
  EXPECT_THAT(warnings(1, 0.001, {}), Contains(HasSubstr("spin_torque_nmm in N mm"))) << "the column that is wrong";
  for (const FitOptions& options : {FitOptions(), kClasses}) {
    const std::vector<std::string> of_kilo = warnings(0.001, 0.001, options);
    ASSERT_THAT(of_kilo, ::testing::Not(::testing::IsEmpty())) << "kN and N m";
    EXPECT_THAT(of_kilo[0], ::testing::AllOf(HasSubstr("far below what is usual for bone"),
                                             HasSubstr("(axial_force_n in N, spin_torque_nmm in N mm)")));
  }
  EXPECT_THAT(warnings(1e6, 1e6, {}), Contains(HasSubstr("cutting.specific_energy_j_mm3 accepts 0.000001 to 10")));
  EXPECT_THAT(warnings(1e6, 1e6, kClasses), Contains(HasSubstr("u1 is ")));
}

TEST(Fit, DoesNotWarnOfSoftBone) {
  // u0 at 1.8 g/cm3 says nothing of bone of 0.3 g/cm3: literature-low is 0.0006 J/mm3 there.
  const Simulated run = simulated(two_layers(0.3, 0.2));
  CuttingSettings low = run.cutting;
  low.preset = EnergyPreset::literature_low;
  apply_preset({}, low);
  std::mt19937 random(10);
  const MeasuredForces measured = measure(run, force_constants(low), kAxial, 0.01, random);
  for (const FitOptions& options : {FitOptions(), kClasses})
    EXPECT_THAT(fit_forces(run.basis, run.frames, run.cutting, measured, options).warnings, ::testing::IsEmpty());
}

TEST(Fit, TakesTimesBetweenFramesAndEmptyCells) {
  const Simulated run = simulated(two_layers());
  std::mt19937 random(7);
  const MeasuredForces every = measure(run, true_constants(), kAxial, 0, random);
  MeasuredForces half{kAxial, {}, {{}, {}}};
  for (std::size_t i = 0; i + 1 < every.time_s.size(); i += 3) {
    half.time_s.push_back(0.5 * (every.time_s[i] + every.time_s[i + 1]));
    for (std::size_t c = 0; c < 2; ++c) half.values[c].push_back(0.5 * (every.values[c][i] + every.values[c][i + 1]));
    if (i % 4 == 0) half.values[0].back() = std::nan("");
  }
  const ForceFit fit = fit_forces(run.basis, run.frames, run.cutting, half, kClasses);
  EXPECT_NEAR(fit.of("u1").value / kU1, 1, 1e-4);
  EXPECT_NEAR(fit.of("u2").value / kU2, 1, 1e-4);
}

TEST(MeasuredForcesFile, IsReadWithTheColumnsThatItHas) {
  const TempDir dir;
  const std::string path = dir.path() + "/measured.csv";
  std::ofstream(path) << "spin_torque_nmm,time_s,note,axial_force_n\n1,0.5,a,2\n,0.75,b,3\n";
  const MeasuredForces found = read_measured_forces(path);
  ASSERT_EQ(found.channels, kAxial);
  EXPECT_EQ(found.time_s, (std::vector{0.5, 0.75}));
  EXPECT_EQ(found.values[0], (std::vector{2.0, 3.0}));
  EXPECT_TRUE(std::isnan(found.values[1][1]));
  for (const char* bad :
       {"", "time_s\n1\n", "axial_force_n\n1\n", "time_s,axial_force_n\n", "time_s,axial_force_n\n1\n",
        "time_s,axial_force_n\n1,x\n", "time_s,axial_force_n\n1,1\n1,2\n", "time_s,axial_force_n\n1,nan\n"}) {
    std::ofstream(path, std::ios::trunc) << bad;
    EXPECT_THROW(read_measured_forces(path), InputError) << bad;
  }
}

TEST(MeasuredForcesFile, NamesTheSeparatorThatIsNoComma) {
  const TempDir dir;
  const std::string path = dir.path() + "/measured.csv";
  const auto expect_complaint = [&](const char* text, const char* complaint) {
    std::ofstream(path, std::ios::trunc) << text;
    try {
      read_measured_forces(path);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(complaint));
    }
  };
  expect_complaint("time_s;axial_force_n\n1;2\n",
                   "measured.csv:1: semicolons separate the columns; save it with commas");
  expect_complaint("time_s\taxial_force_n\n1\t2\n", "measured.csv:1: tabulators separate the columns");
  expect_complaint("time_s,axial_force_n\n1;2\n", "measured.csv:2: semicolons separate the columns");
  std::ofstream(path, std::ios::trunc) << "\xef\xbb\xbftime_s,axial_force_n\r\n1,2\r\n";
  EXPECT_EQ(read_measured_forces(path).time_s, (std::vector{1.0})) << "what \"CSV UTF-8\" of a spreadsheet is";
}

}  // namespace
}  // namespace reamsim::test::fit_tests

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The studies of trajectories/ run as they are; here coarsely, for what they claim to show.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <sstream>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

class Studies : public CliTest {
 protected:
  /// What a coarse run of a study left.
  struct Result {
    double removed_mm3 = 0;
    double energy_mj = 0;
    double rms_torque_nmm = 0;
    double peak_axial_force_n = 0;
    double balance = 0;
    std::string forces;
  };

  ProgramResult check(const std::string& study) const {
    return reamsim({.arguments = {"check", file_of(study)}, .environment = {}, .folder = "", .interrupt_when = {}});
  }
  Result coarse(const std::string& study, const char* voxel_mm = "0.5") const {
    return coarse_run(file_of(study), voxel_mm, {});
  }
  Result coarse_run(const std::string& file, const std::string& voxel_mm, const std::vector<std::string>& more) const {
    ProgramCall call{
        .arguments = {"run", file, "-o", "out", "--overwrite"}, .environment = {}, .folder = "", .interrupt_when = {}};
    std::vector<std::string> changes{"bone.voxel_mm=" + voxel_mm, "motion.frame_rate_hz=50", "render.enabled=false",
                                     "output.vti=false"};
    changes.insert(changes.end(), more.begin(), more.end());
    for (const std::string& change : changes) call.arguments.insert(call.arguments.end(), {"--set", change});
    expect_done(reamsim(call));
    const std::string summary = read("out/summary.json");
    return {number_after(summary, "\"removed_mm3\": "),    number_after(summary, "\"energy_mj\": "),
            number_after(summary, "\"rms_torque_nmm\": "), number_after(summary, "\"peak_axial_force_n\": "),
            number_after(summary, "\"balance\": "),        read("out/forces.csv")};
  }
  static std::string file_of(const std::string& study) {
    return std::string(REAMSIM_ROOT "/trajectories/study_") + study + ".yaml";
  }
};

std::string foam(const std::string& face, const std::string& reamer) {
  return REAMSIM_ROOT "/trajectories/foam_" + face + "_" + reamer + ".yaml";
}

/// The number in a row of forces.csv, counted from 1, and a column.
double field(const std::string& forces, int row, int column) {
  std::istringstream lines(forces);
  std::string line;
  for (int i = 0; i <= row; ++i) std::getline(lines, line);
  std::istringstream fields(line);
  std::string text;
  for (int i = 0; i <= column; ++i) std::getline(fields, text, ',');
  return std::stod(text);
}

TEST_F(Studies, AreAllValid) {
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(REAMSIM_ROOT "/trajectories")) {
    if (!entry.path().filename().string().starts_with("study_")) continue;
    const ProgramResult result = reamsim(
        {.arguments = {"check", entry.path().string(), "--set", "bone.voxel_mm=1", "--set", "motion.frame_rate_hz=50"},
         .environment = {},
         .folder = "",
         .interrupt_when = {}});
    EXPECT_EQ(result.status, 0) << entry.path() << result.err;
    EXPECT_THAT(result.out, HasSubstr("# Walch "));
    ++found;
  }
  EXPECT_EQ(found, 9);
}

TEST_F(Studies, ConcentricReamCutsNothingButThePlate) {
  const Result result = coarse("concentric", "0.4");
  EXPECT_GT(result.removed_mm3, 150);
  // The specific energy of the plate: 1.1 g/cm³, stored as grade 138; what is under it takes less.
  const double plate = 150 * std::pow(138 * 0.008 / 1.8, 2);
  EXPECT_NEAR(result.energy_mj / result.removed_mm3, plate, 0.01 * plate);
  EXPECT_LT(std::abs(result.balance), 1e-4);
}

TEST_F(Studies, EccentricReamTurnsTheFaceByTenDegrees) {
  EXPECT_THAT(check("eccentric_10deg").out, HasSubstr("retroversion 15.00 degrees, superior inclination 8.00 degrees"));
  const Result result = coarse("eccentric_10deg", "1");
  EXPECT_GT(result.removed_mm3, 300);
  const double w = field(result.forces, 1, 5);
  const double x = field(result.forces, 1, 6);
  const double y = field(result.forces, 1, 7);
  const double z = field(result.forces, 1, 8);
  // +z of the tool in B, whose axes are those of the scapular frame: x lateral, y posterior, z superior on a left one.
  const double lateral = 2 * (x * z + w * y);
  const double posterior = 2 * (y * z - w * x);
  const double superior = 1 - 2 * (x * x + y * y);
  EXPECT_NEAR(std::atan2(posterior, lateral) * 180 / std::numbers::pi, 5, 0.01);
  EXPECT_NEAR(std::asin(superior) * 180 / std::numbers::pi, 8, 0.01);
}

TEST_F(Studies, APlanHasItsNumbers) {
  coarse_run(REAMSIM_ROOT "/trajectories/plan_implant.yaml", "0.5", {});
  const auto metrics = nlohmann::json::parse(read("out/summary.json"))["metrics"];
  const auto& planning = metrics["planning"];
  EXPECT_NEAR(planning["native"]["version_deg"].get<double>(), 15, 0.1);
  EXPECT_NEAR(planning["planned"]["version_deg"].get<double>(), 5, 0.01);
  EXPECT_NEAR(planning["retroversion_corrected_deg"].get<double>(), 10, 0.1);
  // In B, as the axis of the tool above: x lateral, y posterior, z superior.
  const auto axis = planning["axis"].get<std::vector<double>>();
  const auto superior = planning["superior"].get<std::vector<double>>();
  EXPECT_NEAR(std::atan2(axis[1], axis[0]) * 180 / std::numbers::pi, 5, 0.01);
  EXPECT_NEAR(std::inner_product(axis.begin(), axis.end(), superior.begin(), 0.0), 0, 1e-6);
  EXPECT_GT(superior[2], 0.9);
  // The implant is 4 mm thick. It rests on the reamed face, and on the edge of the unreamed part, which holds it off.
  const double reamed_mm = metrics["joint_line"]["medialization_mm"].get<double>();
  EXPECT_NEAR(planning["medialization_mm"].get<double>(), reamed_mm - 4, 0.25);
  EXPECT_GT(metrics["seating"]["seated_percent"].get<double>(), 90);
  EXPECT_LT(metrics["seating"]["overhang_percent"].get<double>(), 1);
  const double left = planning["vault"]["left_percent"].get<double>();
  EXPECT_TRUE(left > 90 && left < 100) << left;
  ASSERT_EQ(planning["pegs"].size(), 4);
  for (const auto& peg : planning["pegs"]) EXPECT_EQ(peg["perforated_mm"], 0.0);
  // The pegs are symmetric, the vault is not: behind the posterior one there is less bone.
  const double anterior = planning["pegs"][2]["least_wall_mm"].get<double>();
  EXPECT_GT(anterior, planning["pegs"][3]["least_wall_mm"].get<double>() + 1);
  EXPECT_TRUE(metrics["seating"]["dense_percent"].is_number());
}

TEST_F(Studies, ADeeperPlanSeatsAsWell) {
  // At 20 degrees of correction the core is so tall that columns beside it once counted as reamed through.
  for (const std::string depth_mm : {"7", "7.5"}) {
    coarse_run(REAMSIM_ROOT "/trajectories/plan_implant.yaml", "0.5",
               {"bone.phantom.version_deg=20", "motion.plunge.from=contact", "motion.plunge.depth_mm=" + depth_mm,
                "motion.plunge.entry_mm=[0, 0, 0]", "motion.plunge.axis=[0.34202, 0, -0.93969]"});
    const auto summary = nlohmann::json::parse(read("out/summary.json"));
    EXPECT_GT(summary["metrics"]["seating"]["seated_percent"].get<double>(), 90) << depth_mm;
    EXPECT_TRUE(summary["metrics"]["seating"]["held_off"].is_null()) << summary["metrics"]["seating"];
  }
}

TEST_F(Studies, FlatReamerTakesMoreOfAUniconcaveAndLessOfABiconcaveFace) {
  const double uniconcave_convex = coarse("uniconcave_convex", "0.8").removed_mm3;
  const double uniconcave_flat = coarse("uniconcave_flat", "0.8").removed_mm3;
  const double biconcave_convex = coarse("biconcave_convex", "0.8").removed_mm3;
  const double biconcave_flat = coarse("biconcave_flat", "0.8").removed_mm3;
  EXPECT_GT(uniconcave_flat, 1.5 * uniconcave_convex);
  EXPECT_LT(biconcave_flat, 0.85 * biconcave_convex);
}

TEST_F(Studies, FoamReamedToContactAndToADepthDisagreeOnTheUniconcaveFace) {
  // docs/validation.md: which reamer removes more depends on the end point. The files end at 95 % of the largest
  // contact.
  const char* const coarsely = "0.7";
  const auto to_contact = [&](const char* face, const char* reamer) {
    return coarse_run(foam(face, reamer), coarsely, {});
  };
  // Travel from the entry point to first contact and 3 mm further.
  const auto to_depth = [&](const char* face, const char* reamer, const char* travel_mm) {
    return coarse_run(foam(face, reamer), coarsely, {std::string("motion.plunge.depth_mm=") + travel_mm});
  };
  const Result flat = to_contact("uniconcave", "flat"), convex = to_contact("uniconcave", "convex");
  EXPECT_NEAR(flat.removed_mm3, 1039, 60);
  EXPECT_NEAR(convex.removed_mm3, 529, 60);
  const Result flat_b2 = to_contact("biconcave", "flat"), convex_b2 = to_contact("biconcave", "convex");
  EXPECT_NEAR(flat_b2.removed_mm3, 913, 60);
  EXPECT_NEAR(convex_b2.removed_mm3, 1197, 60);
  EXPECT_GT(to_depth("uniconcave", "convex", "3.63").removed_mm3,
            2 * to_depth("uniconcave", "flat", "3.21").removed_mm3);
  EXPECT_GT(to_depth("biconcave", "convex", "3.71").removed_mm3, 2 * to_depth("biconcave", "flat", "3.16").removed_mm3);
}

TEST_F(Studies, FoamIsOfOneDensity) {
  const Result result = coarse_run(foam("biconcave", "flat"), "1", {});
  const double foam_n_mm2 = 150 * std::pow(0.32 / 1.8, 2);
  EXPECT_NEAR(result.energy_mj / result.removed_mm3, foam_n_mm2, 1e-3 * foam_n_mm2);
}

TEST_F(Studies, DefaultRunStaysUnderAHundredNewton) {
  const Result result = coarse_run(REAMSIM_ROOT "/trajectories/default.yaml", "0.5", {});
  EXPECT_LT(result.peak_axial_force_n, 100);
  EXPECT_GT(result.peak_axial_force_n, 50);
}

TEST_F(Studies, TorqueGoesWithOneOverSpin) {
  const Result slow = coarse("speed_100rpm", "1");
  const Result middle = coarse("speed_250rpm", "1");
  const Result fast = coarse("speed_500rpm", "1");
  EXPECT_EQ(slow.removed_mm3, fast.removed_mm3);
  EXPECT_EQ(slow.energy_mj, middle.energy_mj);
  EXPECT_NEAR(slow.rms_torque_nmm / middle.rms_torque_nmm, 2.5, 0.03);
  EXPECT_NEAR(slow.rms_torque_nmm / fast.rms_torque_nmm, 5, 0.06);
}

}  // namespace
}  // namespace reamsim::test

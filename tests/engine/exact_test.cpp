// `erosion: exact` against closed forms and against its serial reference.
#include <iostream>

#include "kernels/clip.h"
#include "tests/engine/outcome.h"

namespace reamsim::test {
namespace {

/// The same share by slicing the cube and integrating the part of each slice in closed form would hide the same
/// mistakes: count the points of a lattice instead.
double counted_share(const Vec3& n, double distance, int per_axis) {
  std::int64_t outside = 0;
  for (int i = 0; i < per_axis; ++i)
    for (int j = 0; j < per_axis; ++j)
      for (int k = 0; k < per_axis; ++k) {
        const Vec3 x = (Vec3(i, j, k) + Vec3::Constant(0.5)) / per_axis - Vec3::Constant(0.5);
        outside += x.dot(n) + distance > 0 ? 1 : 0;
      }
  return static_cast<double>(outside) / std::pow(per_axis, 3);
}

TEST(Clip, AgreesWithCountingPoints) {
  constexpr unsigned kSeed = 4711;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 300; ++i) {
    Vec3 n(gauss(random), gauss(random), gauss(random));
    if (i % 3 == 1) n[i / 3 % 3] *= 1e-4;  // all but parallel to a face
    if (i % 5 == 1) n[(i / 5 + 1) % 3] = 0;
    n.normalize();
    const double distance = u(random);
    const float nf[3] = {static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z())};
    EXPECT_NEAR(rs_outside_share(nf, static_cast<float>(distance)), counted_share(n, distance, 60), 0.012)
        << n.transpose() << ", " << distance;
  }
}

TEST(Clip, SharesOfAStackOfVoxelsAddUpToTheDistance) {
  // Along any axis the shares of a column of cubes add up to where the plane meets the column's middle, whatever the
  // tilt: no volume is made or lost.
  constexpr unsigned kSeed = 12;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> u(-0.5, 0.5);
  for (int i = 0; i < 2000; ++i) {
    Vec3 n(gauss(random), gauss(random), gauss(random));
    if (i % 4 == 0) n.head<2>() *= std::pow(10, -1 - i % 7);
    n.normalize();
    if (std::abs(n.z()) < 0.05) continue;
    const float nf[3] = {static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z())};
    const double middle = u(random);
    double sum = 0;
    for (int k = -40; k <= 40; ++k) sum += rs_outside_share(nf, static_cast<float>((k - middle) * n.z()));
    // Half of the 81 cubes' length, and the way of the plane along n from there.
    EXPECT_NEAR(sum, 40.5 - (n.z() > 0 ? middle : -middle), 2e-5) << n.transpose() << ", " << middle;
  }
}

ReamingScene exact(ReamingScene scene) {
  scene.scenario.cutting.erosion = "exact";
  return scene;
}

TEST(Exact, EqualsTheSerialReference) {
  const Outcome serial = run(exact(oblique_scene("serial")));
  EXPECT_GT(serial.removed.size(), 100U);
  for (const char* shape : {"cpu", "gpu"}) {
    for (const int batch : {1, 7, 1000}) {
      SCOPED_TRACE(std::string(shape) + ", batch " + std::to_string(batch));
      ReamingScene scene = exact(oblique_scene("auto"));
      scene.scenario.engine.kernel_shape = shape;
      scene.scenario.engine.batch_frames = batch;
      expect_same(run(scene), serial);
    }
  }
}

/// A ball, radius 29 mm, with an edge every `step_mm`.
Tool ball(double step_mm) {
  constexpr double kRadius = 29;
  Profile profile;
  const int steps = static_cast<int>(std::ceil(kRadius * M_PI / step_mm));
  for (int i = 0; i <= steps; ++i) {
    const double angle = M_PI * i / steps;
    profile.points.emplace_back(i == 0 || i == steps ? 0 : kRadius * std::sin(angle), kRadius * (1 - std::cos(angle)));
  }
  return make_tool(profile, 64);
}

/// The ball plunged 4 mm into a block, its middle off the lattice and its axis tilted.
ReamingScene plunged_ball(const Tool& tool, double voxel_mm, const Vec3& offset_mm, const Quat& turned,
                          const std::string& device = "auto") {
  ReamingScene scene = exact({});
  scene.scenario = quiet_scenario(device);
  scene.scenario.cutting.erosion = "exact";
  scene.bone.voxmap = block({34, 34, 8}, voxel_mm, 1.8);
  scene.tool = tool;
  const auto origin = [&](double depth) -> Vec3 {
    return offset_mm + Vec3(0, 0, 29 - depth) - turned * Vec3(0, 0, 29);
  };
  scene.motion = straight(origin(-0.1), origin(4), 40, 1000, 250, turned);
  return scene;
}

TEST(Exact, CapVolume) {
  constexpr unsigned kSeed = 31;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-0.5, 0.5);
  const double expected = M_PI * 16 * (3 * 29 - 4) / 3;
  const Tool tool = ball(0.1);
  for (const double voxel_mm : {1.0, 0.5, 0.25}) {
    double sum = 0;
    constexpr int kTimes = 4;
    for (int i = 0; i < kTimes; ++i) {
      const double tilt = M_PI / 3 * i / (kTimes - 1);
      const Quat turned(Eigen::AngleAxisd(tilt, Vec3(std::cos(i), std::sin(i), 0)));
      const Outcome outcome = run(plunged_ball(tool, voxel_mm, voxel_mm * Vec3(u(random), u(random), 0), turned));
      const double error = outcome.totals.removed_mm3 / expected - 1;
      std::cout << voxel_mm << " mm, " << tilt << " rad: " << 100 * error << " %\n";
      sum += error * error;
    }
    std::cout << voxel_mm << " mm: RMS " << 100 * std::sqrt(sum / kTimes) << " %\n";
  }
}

}  // namespace
}  // namespace reamsim::test

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The density of bone at its surface, where a CT's voxels mix it with what lies beside it, against blocks whose density
// is known. Specific cutting energy goes with the square of density, so that is what is compared.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <numbers>
#include <numeric>
#include <random>

#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/scan/ct_import.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

using Profile = std::function<double(double depth_mm)>;

/// A block whose radiodensity depends on the depth below a tilted face only, as a scanner with voxel averaging sees it.
struct Block {
  Profile hu = [](double) { return 1000.0; };
  double outside_hu = 0;
  double threshold_hu = 200;
  double tilt_deg = 0;
  double offset_mm = 0;  ///< of the face from a voxel's centre
  Vec3 spacing_mm = Vec3::Ones();
  double noise_hu = 0;
  unsigned seed = 0;
  double extent_mm = 26;
  double thickness_mm = 22;
  double step_mm = 22;           ///< where the profile is not straight
  Vec3 mirror = Vec3::Ones();    ///< 1, or -1 where the scene is mirrored along that axis
  Mat3 axes = Mat3::Identity();  ///< of the scan

  [[nodiscard]] Vec3 outward() const {
    const double tilt = tilt_deg * std::numbers::pi / 180;
    return mirror.cwiseProduct(Vec3(std::sin(tilt) * 0.8, std::sin(tilt) * 0.6, std::cos(tilt)));
  }
  [[nodiscard]] Vec3 face_mm() const { return mirror.cwiseProduct(Vec3(0.13, 0.21, 5 + offset_mm)); }
  [[nodiscard]] double depth_mm(const Vec3& p) const { return outward().dot(face_mm() - p); }
};

using Levels = std::array<std::size_t, 5>;

/// Calls for one of `parts` equal fractions of a factorial design, in which every pair of levels of two factors occurs;
/// with REAMSIM_CAMPAIGN in the environment for all combinations. `counts`: levels of each factor.
void for_levels(const Levels& counts, std::size_t parts, const std::function<void(const Levels&)>& call) {
  const bool all = std::getenv("REAMSIM_CAMPAIGN") != nullptr;
  Levels at{};
  for (at[0] = 0; at[0] < counts[0]; ++at[0])
    for (at[1] = 0; at[1] < counts[1]; ++at[1])
      for (at[2] = 0; at[2] < counts[2]; ++at[2])
        for (at[3] = 0; at[3] < counts[3]; ++at[3])
          for (at[4] = 0; at[4] < counts[4]; ++at[4])
            if (all || std::accumulate(at.begin(), at.end(), std::size_t{0}) % parts == 0) call(at);
}

/// Mean over the voxel.
double voxel_mean(const Block& block, const Vec3& center) {
  const Vec3 outward = block.outward();
  const Vec3 per_step = (block.axes.transpose() * outward).cwiseProduct(block.spacing_mm);  // height
  const double reach = 0.5 * per_step.cwiseAbs().sum();
  const double depth = outward.dot(block.face_mm() - center);
  const auto crosses = [&](double mm) { return std::abs(depth - mm) < reach + 1e-9; };
  if (!crosses(0) && !crosses(block.step_mm) && !crosses(block.thickness_mm)) {  // straight over the voxel
    return depth < 0 || depth > block.thickness_mm ? block.outside_hu : block.hu(depth);
  }
  static const std::vector<Vec3> steps = [] {
    constexpr int kPerAxis = 6, kAcross = 24;
    std::vector<Vec3> out;
    for (int n = 0; n < kPerAxis * kPerAxis * kAcross; ++n) {
      out.emplace_back((n % kPerAxis + 0.5) / kPerAxis - 0.5, (n / kPerAxis % kPerAxis + 0.5) / kPerAxis - 0.5,
                       (n / kPerAxis / kPerAxis + 0.5) / kAcross - 0.5);
    }
    return out;
  }();
  double sum = 0;
  for (const Vec3& step : steps) {
    const double at = depth - per_step.dot(step);
    sum += at < 0 || at > block.thickness_mm ? block.outside_hu : block.hu(at);
  }
  return sum / static_cast<double>(steps.size());
}

class BoundaryDensity : public ::testing::Test {
 protected:
  /// `by_label`: segmented by a label map, 1 in the voxels of which at least half is bone.
  FilledVoxmap import(const Block& block, double voxel_mm, bool by_label = false) {
    TestImage image;
    image.spacing_mm = block.spacing_mm;
    const double half = block.extent_mm / 2;
    image.dims = (block.extent_mm * block.spacing_mm.cwiseInverse()).array().round().cast<int>();
    const Vec3 last = (image.dims - Vec3i::Ones()).cast<double>().cwiseProduct(block.spacing_mm) - Vec3::Constant(half);
    for (int axis = 0; axis < 3; ++axis) image.origin_mm[axis] = block.mirror[axis] > 0 ? -half : -last[axis];
    image.origin_mm = block.axes * image.origin_mm;
    image.direction = block.axes;
    std::mt19937 random(block.seed);
    std::normal_distribution<double> noise(0, 1);
    image.sample([&](const Vec3& p) {
      const double hu = voxel_mean(block, p);
      return block.noise_hu == 0 ? hu : hu + block.noise_hu * noise(random);
    });
    write_image<float>(image, folder_.file("block.nrrd"));
    BoneSettings settings = settings_for(folder_.file("block.nrrd"), voxel_mm);
    settings.ct.threshold_hu = block.threshold_hu;
    settings.surface_voxels = SurfaceVoxels::partial;
    if (by_label) {
      Block mask = block;
      mask.hu = [](double) { return 1.0; };
      mask.outside_hu = 0;
      image.sample([&](const Vec3& p) { return voxel_mean(mask, p) >= 0.5 ? 1 : 0; });
      write_image<std::uint8_t>(image, folder_.file("label.nrrd"));
      settings.ct.label_map = LabelMapSettings{.path = folder_.file("label.nrrd"), .label = {"1"}};
    }
    report_ = {};
    return voxmap_from_ct(settings, report_);
  }

  /// Energy per volume of the bone down to `depth_mm` below the true face, over that of the truth, less 1.
  double energy_error(const Block& block, const FilledVoxmap& voxmap, double depth_mm) const {
    const Vec3 n = block.outward();
    const Vec3 u = block.mirror.cwiseProduct(block.mirror.cwiseProduct(n).unitOrthogonal()), w = n.cross(u);
    constexpr double kRadius_mm = 6, kStep_mm = 0.11;
    double energy = 0, volume = 0;
    for (double a = -kRadius_mm; a <= kRadius_mm; a += kStep_mm * 3) {
      for (double b = -kRadius_mm; b <= kRadius_mm; b += kStep_mm * 3) {
        for (double d = -1.5; d < depth_mm; d += kStep_mm / 4) {
          const Vec3 p = block.face_mm() + a * u + b * w - d * n;
          const Vec3i voxel = voxmap.grid.voxel_of(p);
          const std::uint8_t grade = voxmap.grade.get(voxel);
          if (grade == 0) continue;
          const double part = static_cast<double>(voxmap.fill.get(voxel)) / FillBricks::kWhole;
          energy += part * std::pow(DensityMapping::density_from_grade(grade), 2);
          volume += part;
        }
      }
    }
    double truth = 0;
    constexpr int kParts = 1000;
    for (int i = 0; i < kParts; ++i) {
      truth += std::pow(DensityMapping().density_from_hu(block.hu((i + 0.5) / kParts * depth_mm)), 2) / kParts;
    }
    return energy / volume / truth - 1;
  }

  double error(const Block& block, double voxel_mm, double depth_mm) {
    return energy_error(block, import(block, voxel_mm), depth_mm);
  }

  TempFolder folder_;
  Diagnostics report_;
};

TEST_F(BoundaryDensity, OfAUniformBlockHoldsAtEveryVoxelSize) {
  double worst = 0;
  constexpr std::array kOutside_hu{-1000.0, 0.0, 60.0}, kOffsets{0.0, 0.31, 0.74}, kVoxels_mm{1.0, 0.5, 0.25};
  constexpr std::array kSpacings_mm{0.6, 1.0}, kTilts_deg{0.0, 30.0};
  for_levels({3, 3, 3, 2, 2}, 3, [&](const Levels& at) {
    Block block;
    block.outside_hu = kOutside_hu[at[0]];
    const double voxel_mm = kVoxels_mm[at[2]], spacing_mm = kSpacings_mm[at[3]];
    block.spacing_mm = Vec3::Constant(spacing_mm);
    block.offset_mm = kOffsets[at[1]] * spacing_mm;
    block.tilt_deg = kTilts_deg[at[4]];
    const FilledVoxmap voxmap = import(block, voxel_mm);
    for (const double depth_mm : {1.0, 5.0}) {
      const double found = energy_error(block, voxmap, depth_mm);
      worst = std::max(worst, std::abs(found));
      EXPECT_NEAR(found, 0, 0.02) << "outside " << block.outside_hu << " HU, scan " << spacing_mm << " mm, offset "
                                  << block.offset_mm << " mm, " << block.tilt_deg << " deg, voxels " << voxel_mm
                                  << " mm, " << depth_mm << " mm deep";
    }
  });
  std::cout << "worst " << 100 * worst << " %\n";
}

TEST_F(BoundaryDensity, HoldsOnVoxelsThatAreNoCubes) {
  for (const double offset_mm : {0.0, 0.2, 0.55}) {
    Block block;
    block.hu = [](double) { return 1500.0; };
    block.spacing_mm = Vec3(0.5, 0.5, 1.25);
    block.offset_mm = offset_mm;
    EXPECT_NEAR(error(block, 0.25, 1), 0, 0.02) << offset_mm;
    block.tilt_deg = 50;
    EXPECT_NEAR(error(block, 0.25, 1), 0, 0.02) << offset_mm << ", tilted";
  }
}

TEST_F(BoundaryDensity, HoldsOnObliqueScans) {
  constexpr std::array kSlices_mm{0.5, 1.25, 2.5};
  constexpr std::array kThresholds_hu{200.0, 750.0};
  const std::array turns_deg{Vec3(15, 0, 0), Vec3(20, -30, 40)};
  for_levels({3, 2, 2, 1, 1}, 2, [&](const Levels& at) {
    const double slice_mm = kSlices_mm[at[0]];
    const Vec3 angle = turns_deg[at[1]] * std::numbers::pi / 180;
    Block block;
    block.hu = [](double) { return 1500.0; };
    block.threshold_hu = kThresholds_hu[at[2]];
    block.spacing_mm = Vec3(0.5, 0.5, slice_mm);
    block.offset_mm = 0.3 * slice_mm;
    block.extent_mm = 30;
    block.axes = (Eigen::AngleAxisd(angle.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(angle.y(), Vec3::UnitY()) *
                  Eigen::AngleAxisd(angle.x(), Vec3::UnitX()))
                     .toRotationMatrix();
    EXPECT_NEAR(error(block, 0.5, 1), 0, 0.02)
        << "slices of " << slice_mm << " mm, turned by " << turns_deg[at[1]].transpose() << " deg, threshold "
        << block.threshold_hu;
  });
}

/// The part of a voxel at `center` that lies in a box about the origin.
double part_in_box(const TestImage& image, const Vec3& center, const Vec3& half_mm) {
  constexpr int kPerAxis = 6;
  const Vec3 reach = 0.5 * image.direction.cwiseAbs() * image.spacing_mm;
  if (((center.cwiseAbs() + reach).array() < half_mm.array()).all()) return 1;
  if (((center.cwiseAbs() - reach).array() > half_mm.array()).any()) return 0;
  int inside = 0;
  for (int n = 0; n < kPerAxis * kPerAxis * kPerAxis; ++n) {
    const Vec3 step =
        (Vec3(n % kPerAxis, n / kPerAxis % kPerAxis, n / kPerAxis / kPerAxis) + Vec3::Constant(0.5)) / kPerAxis -
        Vec3::Constant(0.5);
    const Vec3 p = center + image.direction * image.spacing_mm.cwiseProduct(step);
    inside += (p.cwiseAbs().array() < half_mm.array()).all() ? 1 : 0;
  }
  return inside / std::pow(kPerAxis, 3);
}

// The normal near an edge leads along the slice, so that trusted voxels are many steps away.
TEST_F(BoundaryDensity, HoldsAtTheEdgesOfThickSlices) {
  for (const double slice_mm : {2.0, 3.0}) {
    for (const double degrees : {0.0, 5.0, 35.0}) {
      for (const double threshold_hu : {200.0, 400.0}) {
        TestImage image;
        image.spacing_mm = Vec3(0.6, 0.6, slice_mm);
        image.direction = Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vec3::UnitX()).toRotationMatrix();
        image.dims = (36 * image.spacing_mm.cwiseInverse()).array().round().cast<int>();
        const Vec3 last_mm = (image.dims - Vec3i::Ones()).cast<double>().cwiseProduct(image.spacing_mm);
        image.origin_mm = image.direction * (-0.5 * last_mm);
        image.sample([&](const Vec3& p) { return -50 + 850 * part_in_box(image, p, {11, 9, 10}); });
        write_image<float>(image, folder_.file("box.nrrd"));
        BoneSettings settings = settings_for(folder_.file("box.nrrd"), 0.5);
        settings.ct.threshold_hu = threshold_hu;
        const FilledVoxmap voxmap = voxmap_from_ct(settings, report_);
        double sum = 0, truth = 0;
        const double density = DensityMapping().density_from_hu(800);
        for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
          const std::uint8_t grade = voxmap.grade.get(voxmap.grid.coord(e));
          if (grade == 0) continue;
          sum += std::pow(DensityMapping::density_from_grade(grade), 2);
          truth += std::pow(density, 2);
        }
        EXPECT_NEAR(sum / truth - 1, 0, 0.01)
            << "slices of " << slice_mm << " mm, turned by " << degrees << " deg, threshold " << threshold_hu;
      }
    }
  }
}

TEST_F(BoundaryDensity, OfADensePlateInObliqueScansIsThatOfAnAlignedOne) {
  double worst = 0;
  constexpr std::array kTurns_deg{0.0, 0.05, 10.0, 25.0};
  constexpr std::array kPlates_mm{3.5, 5.0}, kSlices_mm{0.5, 1.25}, kTilts_deg{0.0, 60.0};
  for_levels({4, 2, 2, 2, 1}, 2, [&](const Levels& at) {
    const double degrees = kTurns_deg[at[0]], plate_mm = kPlates_mm[at[1]], slice_mm = kSlices_mm[at[2]];
    Block block;
    block.hu = [=](double depth_mm) { return depth_mm < plate_mm ? 1200.0 : 400.0; };
    block.step_mm = plate_mm;
    block.noise_hu = 30;
    block.seed = 1;
    block.spacing_mm = Vec3(0.5, 0.5, slice_mm);
    block.offset_mm = 0.3 * slice_mm;
    block.extent_mm = 30;
    block.tilt_deg = kTilts_deg[at[3]];
    block.axes = Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vec3::UnitX()).toRotationMatrix();
    const double found = error(block, 0.5, 2);
    worst = std::max(worst, std::abs(found));
    EXPECT_NEAR(found, 0, 0.035) << "plate of " << plate_mm << " mm, slices of " << slice_mm << " mm, turned by "
                                 << degrees << " deg, face tilted by " << block.tilt_deg << " deg, seed 1";
  });
  std::cout << "worst " << 100 * worst << " %\n";
}

TEST_F(BoundaryDensity, HoldsWithALabelMapToo) {
  for (const double outside_hu : {-1000.0, 60.0}) {
    for (const double offset_mm : {0.0, 0.31, 0.74}) {
      Block block;
      block.outside_hu = outside_hu;
      block.offset_mm = offset_mm;
      block.tilt_deg = 20;
      for (const double voxel_mm : {1.0, 0.25}) {
        EXPECT_NEAR(energy_error(block, import(block, voxel_mm, true), 1), 0, 0.02)
            << "outside " << outside_hu << " HU, offset " << offset_mm << ", voxels " << voxel_mm << " mm";
      }
    }
  }
}

TEST_F(BoundaryDensity, OfARampFollowsItToTheSurface) {
  constexpr std::array kOffsets{0.0, 0.31, 0.74}, kVoxels_mm{1.0, 0.5, 0.25};
  constexpr std::array kSpacings_mm{0.6, 1.0}, kTilts_deg{0.0, 30.0};
  for_levels({3, 3, 2, 2, 2}, 3, [&](const Levels& at) {
    const bool dense_outside = at[4] == 1;
    const double voxel_mm = kVoxels_mm[at[1]], spacing_mm = kSpacings_mm[at[2]];
    Block block;
    block.hu = [=](double depth_mm) { return dense_outside ? 1200 - 40 * depth_mm : 400 + 40 * depth_mm; };
    block.thickness_mm = 20;
    block.spacing_mm = Vec3::Constant(spacing_mm);
    block.offset_mm = kOffsets[at[0]] * spacing_mm;
    block.tilt_deg = kTilts_deg[at[3]];
    EXPECT_NEAR(error(block, voxel_mm, 5), 0, 0.02)
        << (dense_outside ? "dense outside" : "dense inside") << ", scan " << spacing_mm << " mm, offset "
        << block.offset_mm << " mm, " << block.tilt_deg << " deg, voxels " << voxel_mm << " mm";
  });
}

TEST_F(BoundaryDensity, OfADensePlateIsKept) {
  for (const double offset : {0.0, 0.31, 0.74}) {
    Block block;
    block.hu = [](double depth_mm) { return depth_mm < 2 ? 1600.0 : 400.0; };
    block.step_mm = 2;
    block.spacing_mm = Vec3::Constant(0.8);
    block.offset_mm = 0.8 * offset;
    for (const double voxel_mm : {0.8, 0.4, 0.2}) {
      const double found = error(block, voxel_mm, 1.5);
      std::cout << "plate, offset " << offset << ", voxels " << voxel_mm << " mm: " << 100 * found << " %\n";
      EXPECT_NEAR(found, 0, 0.10) << offset << ", voxels " << voxel_mm << " mm";
    }
  }
}

TEST_F(BoundaryDensity, MirroredBonesHaveTheSame) {
  // The voxmap's voxels lie elsewhere in a mirrored block; a face between two voxels of the scan made up to 14 %.
  constexpr double kLattice = 0.005;
  constexpr std::array kPlates_mm{1.2, 2.0, 22.0}, kTilts_deg{0.0, 35.0, 55.0};
  std::map<std::array<std::size_t, 2>, double> errors;  // as given, by plate and tilt
  for_levels({3, 3, 2, 2, 2}, 3, [&](const Levels& at) {
    const double plate_mm = kPlates_mm[at[0]];
    Block block;
    block.hu = [=](double depth_mm) { return depth_mm < plate_mm ? 1200.0 : 400.0; };
    block.step_mm = plate_mm;
    block.spacing_mm = Vec3::Constant(0.8);
    block.offset_mm = 0.2;
    block.tilt_deg = kTilts_deg[at[1]];
    const auto [as_given, is_new] = errors.try_emplace({at[0], at[1]});
    if (is_new) as_given->second = error(block, 0.4, 2);
    EXPECT_NEAR(as_given->second, 0, 0.10);
    for (int axis = 0; axis < 3; ++axis) block.mirror[axis] = at[static_cast<std::size_t>(axis) + 2] != 0 ? -1 : 1;
    if (block.mirror == Vec3::Ones()) return;
    EXPECT_NEAR(error(block, 0.4, 2), as_given->second, kLattice)
        << "plate of " << plate_mm << " mm, " << block.tilt_deg << " deg, mirrored as " << block.mirror.transpose();
  });
}

TEST_F(BoundaryDensity, NoiseIsNotAmplified) {
  constexpr int kSeeds = 4;
  for (const double hu : {400.0, 1000.0}) {
    for (const double outside_hu : {-1000.0, 40.0}) {
      for (const double voxel_mm : {1.0, 0.5}) {
        double shallow = 0, deep = 0;
        for (unsigned seed = 1; seed <= kSeeds; ++seed) {
          Block block;
          block.hu = [=](double) { return hu; };
          block.outside_hu = outside_hu;
          block.noise_hu = 50;
          block.seed = seed;
          block.offset_mm = 0.25 * seed;
          block.tilt_deg = seed % 2 == 0 ? 0 : 25;
          const FilledVoxmap voxmap = import(block, voxel_mm);
          shallow += energy_error(block, voxmap, 1) / kSeeds;
          deep += energy_error(block, voxmap, 5) / kSeeds;
        }
        std::cout << hu << " HU beside " << outside_hu << ", voxels " << voxel_mm << " mm: " << 100 * shallow
                  << " % to 1 mm, " << 100 * deep << " % to 5 mm, seeds 1 to " << kSeeds << "\n";
        EXPECT_NEAR(shallow, 0, 0.02);
        EXPECT_NEAR(deep, 0, 0.02);
      }
    }
  }
}

}  // namespace
}  // namespace reamsim::test

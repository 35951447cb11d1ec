// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Voxels that both the bone's surface and the tool intersect.
#include <iostream>

#include "kernels/bone_face.h"
#include "sim/engine/common/bone_faces.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::bone_face_tests {
namespace {

using std::numbers::pi;

constexpr unsigned kSeed = 30;

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> gauss;
  return Vec3(gauss(random), gauss(random), gauss(random)).normalized();
}

/// The fraction of a unit cube outside a plane through its centre moved by `away` along the outward normal.
double outside(const Vec3& normal, double away) {
  const float n[3] = {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z())};
  return rs_outside_fraction(n, static_cast<float>(away));
}

/// The fraction of a unit cube outside two planes, by points; that of a cell about a point falls linearly across it.
double outside_both(const Vec3& a, double away_a, const Vec3& b, double away_b) {
  constexpr int kPoints = 14;
  const auto soft = [&](const Vec3& n, double away, const Vec3& x) {
    return std::clamp((x.dot(n) + away) * kPoints / n.lpNorm<1>() + 0.5, 0.0, 1.0);
  };
  double sum = 0;
  for_each_voxel(Vec3i::Constant(kPoints), [&](const Vec3i& i) {
    const Vec3 x = (i.cast<double>() + Vec3::Constant(0.5)) / kPoints - Vec3::Constant(0.5);
    sum += soft(a, away_a, x) * soft(b, away_b, x);
  });
  return sum / std::pow(kPoints, 3);
}

TEST(BoneFace, KeptFractionIsRightInTheMean) {
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> away(-0.87, 0.87);
  constexpr int kPairs = 3000;
  for (const int degrees : {20, 45, 70, 90, 110, 135, 160}) {
    double error = 0, square = 0, of_smaller = 0;
    for (int i = 0; i < kPairs; ++i) {
      const Vec3 a = random_direction(random), b = Eigen::AngleAxisd(degrees * pi / 180, a.unitOrthogonal()) * a;
      const double away_a = away(random), away_b = away(random);
      const double f = outside(a, away_a), o = outside(b, away_b), both = outside_both(a, away_a, b, away_b);
      const Eigen::Vector3f bone = -a.cast<float>(), tool = b.cast<float>();
      const FaceCut cut =
          rs_face_cut_between(static_cast<float>(f), bone.data(), static_cast<float>(-away_a), tool.data());
      const double found = rs_kept_fraction(&cut, static_cast<float>(o));
      error += (found - both) / kPairs;
      square += (found - both) * (found - both) / kPairs;
      of_smaller += (std::min(f, o) - both) / kPairs;
    }
    std::cout << degrees << " degrees: mean " << error << ", RMS " << std::sqrt(square) << "; smaller fraction "
              << of_smaller << '\n';
    EXPECT_LT(std::abs(error), 0.001) << degrees;
    EXPECT_LT(std::sqrt(square), 0.008) << degrees;
    EXPECT_GT(of_smaller, 3 * std::abs(error)) << degrees;
  }
}

ClipPlane clip_plane(const Vec3& normal, double away) {
  const Eigen::Vector3f n = normal.cast<float>();
  return {.n = {n.x(), n.y(), n.z()}, .away = static_cast<float>(away), .nz = 0};
}

/// A face with the fill and the normal of a plane.
rs_i32 face_of(const Vec3& normal, double away) {
  return packed_face(static_cast<std::uint16_t>(std::lround((1 - outside(normal, away)) * RS_WHOLE_FILL)),
                     normal.cast<float>());
}

TEST(BoneFace, KeepsItsFillAndIsTouchedWhenThePlanesMeet) {
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> away(-0.5, 0.5);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 bone = i < 3 ? Vec3(Vec3::Unit(i)) : random_direction(random), tool = random_direction(random);
    const double bone_away = away(random);
    const rs_i32 face = face_of(bone, bone_away);
    const FaceCut cut = rs_face_cut(face, std::array{clip_plane(tool, 0)}.data());
    EXPECT_NEAR(cut.fill, 1 - outside(bone, bone_away), 5e-5) << bone.transpose() << "; " << bone_away;
    float b[3];
    rs_face_normal(face, b);
    const Vec3 kept = Eigen::Map<const Eigen::Vector3f>(b).cast<double>();
    // The lowest corner of the bone is a corner of the cube, or lies on one of its edges.
    double nearest = 9;
    for (int axis = 0; axis < 3; ++axis) {
      for (int corner = 0; corner < 4; ++corner) {
        Vec3 x = Vec3::Constant(-0.5);
        x[(axis + 1) % 3] += corner & 1, x[(axis + 2) % 3] += corner >> 1;
        const double low = kept.dot(x) + rs_face_away(face), high = low + kept[axis];
        for (const double along : {0.0, 1.0, -low / kept[axis]}) {
          if (!(along >= 0 && along <= 1) || low + along * (high - low) > 1e-6) continue;
          nearest = std::min(nearest, tool.dot(x + along * Vec3::Unit(axis)));
        }
      }
    }
    EXPECT_NEAR(cut.touch, outside(tool, -nearest), 2e-3) << bone.transpose() << "; " << tool.transpose();
    EXPECT_EQ(rs_kept_fill(&cut, static_cast<int>(std::ceil(cut.touch * RS_WHOLE_FILL)) + 1), RS_WHOLE_FILL);
  }
}

/// The fraction of a unit cube that is bone and outside a tool with a corner, by points.
double counted_bone(const Vec3& bone, double away, const Clip& clip) {
  constexpr int kPoints = 24;
  int kept = 0;
  const auto is_outside = [](const ClipPlane& plane, const Vec3& x) {
    return Eigen::Map<const Eigen::Vector3f>(plane.n).cast<double>().dot(x) + plane.away > 0;
  };
  for_each_voxel(Vec3i::Constant(kPoints), [&](const Vec3i& i) {
    const Vec3 x = (i.cast<double>() + Vec3::Constant(0.5)) / kPoints - Vec3::Constant(0.5);
    const bool first = is_outside(clip.plane, x), other = is_outside(clip.other, x);
    kept += bone.dot(x) + away < 0 && (clip.corner > 0 ? first || other : first && other) ? 1 : 0;
  });
  return kept / std::pow(kPoints, 3);
}

TEST(BoneFace, CornersAgreeWithCountingPoints) {
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> away(-0.5, 0.5);
  constexpr int kTimes = 1000;
  for (const float corner : {1.0F, -1.0F}) {
    double error = 0, square = 0, of_smaller = 0;
    for (int i = 0; i < kTimes; ++i) {
      const Vec3 bone = random_direction(random), first = random_direction(random);
      const Vec3 other = Eigen::AngleAxisd(1.4, first.unitOrthogonal()) * first;
      const double bone_away = away(random);
      Clip clip{};
      clip.plane = clip_plane(first, away(random));
      clip.other = clip_plane(other, away(random));
      clip.corner = corner;
      const double counted = counted_bone(bone, bone_away, clip);
      const double found = rs_clip_kept_fraction(&clip, face_of(bone, bone_away));
      const double smaller = std::min<double>(rs_clip_fractions(&clip).tool, 1 - outside(bone, bone_away));
      error += (found - counted) / kTimes;
      square += (found - counted) * (found - counted) / kTimes;
      of_smaller += (smaller - counted) / kTimes;
    }
    std::cout << (corner > 0 ? "convex" : "concave") << ": mean " << error << ", RMS " << std::sqrt(square)
              << "; smaller fraction " << of_smaller << '\n';
    EXPECT_LT(std::abs(error), 0.001) << corner;
    EXPECT_LT(std::sqrt(square), 0.015) << corner;
    EXPECT_GT(of_smaller, 0.05) << corner;
  }
}

TEST(BoneFace, KeptFractionIsExactWherePlanesAreParallelOrOneMissesTheVoxel) {
  for (float f = 0; f <= 1; f += 0.125F) {
    for (float o = 0; o <= 1; o += 0.125F) {
      const FaceCut same = rs_face_cut_at(f, 1, 1), opposite = rs_face_cut_at(f, 1, -1);
      EXPECT_NEAR(rs_kept_fraction(&same, o), std::min(f, o), 3e-4) << f << ", " << o;
      EXPECT_NEAR(rs_kept_fraction(&opposite, o), std::max(f + o - 1, 0.0F), 3e-4) << f << ", " << o;
    }
    for (const float cosine : {-0.9F, -0.3F, 0.0F, 0.3F, 0.9F}) {
      if (f == 0) continue;  // no face
      const FaceCut cut = rs_face_cut_at(f, 1, cosine);
      EXPECT_EQ(rs_kept_fill(&cut, 0), 0) << f << ", " << cosine;
      EXPECT_EQ(rs_kept_fill(&cut, RS_WHOLE_FILL), RS_WHOLE_FILL) << cosine << ": no limit";
    }
  }
  // A voxel without a face keeps what is outside the tool.
  const ClipPlane plane{{0.6F, 0, 0.8F}, 0, 0};
  const FaceCut none = rs_face_cut(RS_NO_FACE, &plane);
  for (const int o : {0, 1, 77, 32768, 65534, 65535}) EXPECT_EQ(rs_kept_fill(&none, o), o);
}

/// Bone below a plane through the origin.
FilledVoxmap tilted_half_space(const Vec3& normal, double voxel_mm) {
  const VoxelGrid grid{{44, 42, 40}, voxel_mm, {-22.3 * voxel_mm, -21.4 * voxel_mm, -24.1 * voxel_mm}};
  FilledVoxmap out(grid);
  for_each_voxel(grid.dims, [&](const Vec3i& voxel) {
    const double away = normal.dot(grid.center_mm(voxel)) / voxel_mm;
    const double bone = away > RS_CLIP_REACH ? 0 : away < -RS_CLIP_REACH ? 1 : 1 - outside(normal, away);
    const auto fill = static_cast<std::uint16_t>(std::lround(bone * FillBricks::kWhole));
    if (fill == 0) return;
    out.grade.set(voxel, 150);
    out.fill.set(voxel, fill);
  });
  return out;
}

const Vec3 kNormal = Vec3(0.3, -0.5, 0.8).normalized();

TEST(BoneFace, NormalIsTheSlopeOfTheFill) {
  const Bone bone(tilted_half_space(kNormal, 0.4));
  const BoneFaces faces(bone);
  const Vec3i inner = bone.voxmap->grid.dims - Vec3i::Constant(2);
  int found = 0;
  for_each_voxel(Vec3i::Ones(), inner, [&](const Vec3i& voxel) {
    const std::uint16_t fill = bone.voxmap->grade.get(voxel) == 0 ? 0 : bone.fill.get(voxel);
    const rs_i32 face = faces.at(voxel);
    if (fill == 0 || fill == FillBricks::kWhole) {
      EXPECT_EQ(face, RS_NO_FACE) << voxel.transpose();
      return;
    }
    ++found;
    const ClipPlane along{
        {static_cast<float>(-kNormal.x()), static_cast<float>(-kNormal.y()), static_cast<float>(-kNormal.z())}, 0, 0};
    const FaceCut cut = rs_face_cut(face, &along);
    EXPECT_NEAR(cut.fill * RS_WHOLE_FILL, fill, 3) << voxel.transpose();
    EXPECT_GT(cut.cosine, 0.99F) << voxel.transpose();
  });
  EXPECT_GT(found, 1000);
}

const Profile kBall = cap_profile(6, 11, 6, 0);

/// A tool, 2 mm deep along the normal of a tilted half-space, with forces of cutting edges.
SimulationInput tilted_plunge(const std::string& device, double voxel_mm, const Profile& tool = kBall) {
  SimulationInput scene;
  scene.scenario = quiet_scenario(device);
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.scenario.cutting.edge_force.emplace();
  scene.bone.set_voxels(tilted_half_space(kNormal, voxel_mm));
  scene.tool = make_tool(tool, 64);
  const Quat turned = Quat::FromTwoVectors(Vec3::UnitZ(), kNormal);
  scene.motion = straight(0.1 * kNormal, -2 * kNormal, 100, 1000, 250, turned);
  return scene;
}

TEST(BoneFace, VolumeOfACapInATiltedHalfSpace) {
  const double cap = pi * 4 * (6 - 2 / 3.0);
  for (const double voxel_mm : {0.4, 0.32}) {
    const SimulationInput scene = tilted_plunge("serial", voxel_mm);
    const double removed = run(scene).totals.removed_mm3;
    std::cout << voxel_mm << " mm: " << 100 * (removed / cap - 1) << " %\n";
    EXPECT_NEAR(removed / cap, 1, 3e-4) << voxel_mm;
  }
}

TEST(BoneFace, ShapesOfTheKernelEqualTheSerialReference) {
  for (const Profile& tool : {kBall, cap_profile(29, 5, 6, 1.25)}) {  // the second with sharp edges, convex and concave
    const auto scene = [&](const std::string& device) { return tilted_plunge(device, 0.4, tool); };
    const Outcome serial = run(scene("serial"));
    EXPECT_GT(serial.removed.size(), 200U);
    expect_all_shapes_give(serial, scene);
  }
}

TEST(BoneFace, ShapesOfTheKernelEqualTheSerialReferenceOnBoneWithoutASurface) {
  std::cout << "seed " << kSeed << '\n';
  const auto scene = [](const std::string& device) {
    std::mt19937 random(kSeed);
    SimulationInput out = oblique_scene(device);
    out.scenario.cutting.erosion = ErosionMode::exact;
    FilledVoxmap bone = random_bone({41, 37, 29}, 0.2, 7);
    for_each_voxel(bone.grid.dims, [&](const Vec3i& voxel) {
      if (random() % 2 == 0) bone.fill.set(voxel, static_cast<std::uint16_t>(random() % 65536));
    });
    out.bone.set_voxels(std::move(bone));
    return out;
  };
  const Outcome serial = run(scene("serial"));
  EXPECT_GT(serial.removed.size(), 100U);
  expect_all_shapes_give(serial, scene);
}

}  // namespace
}  // namespace reamsim::test::bone_face_tests

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Fit of implants of several shapes and poses, against closed forms: within a tenth of a voxel or 1 %.
#include "sim/mesh/mesh_io.h"
#include "tests/anatomy/implant_fixture.h"

namespace reamsim::test {
namespace {

constexpr double kPercent = 1;  // of the footprint

TEST(ImplantFit, AFlatDiscTiltedAgainstAPlane) {
  const double tilt = 8 * kDegree;
  const double radius = 10;
  ImplantSettings implant = disc(2 * radius);
  implant.axis = {std::sin(tilt), 0, std::cos(tilt)};
  const Planning found = plan(flat_block({40, 40, 12}, 3), implant);
  // The highest hundredth yields; from its chord on the gap grows by tan(tilt).
  const double chord = chord_of(radius, 0.01 * disc_mm2(radius));
  const double seated = segment_mm2(radius, chord - 0.5 / std::tan(tilt)) / disc_mm2(radius);
  EXPECT_NEAR(found.seating.footprint_mm2, disc_mm2(radius), 0.01 * disc_mm2(radius));
  EXPECT_NEAR(found.seating.seated_percent, 100 * seated, kPercent);
  EXPECT_NEAR(found.seating.max_gap_mm, (radius + chord) * std::tan(tilt), kTenthVoxel);
  EXPECT_NEAR(found.seating.mean_gap_mm, chord * std::tan(tilt), kTenthVoxel);
  EXPECT_NEAR(found.seating.overhang_percent, 0, 0.1);
}

TEST(ImplantFit, AConvexBackInACupOfAnotherRadius) {
  Block block({40, 40, 12}, kVoxel, 1.8);
  block.ream(both(cap({0, 0, -5}, 29), rod({0, 0, 0}, Vec3::UnitZ(), 14)));
  ImplantSettings implant = disc(20);
  implant.backside_radius_mm = 22;
  implant.gap_mm = 0.25;
  const Planning found = plan(block, implant);
  const auto difference = [](double r) { return sagitta(22, r) - sagitta(29, r); };
  double seated_r = 0;  // the innermost hundredth of the area, r = R/10, yields
  while (seated_r < 10 && difference(seated_r) - difference(1) <= implant.gap_mm) seated_r += 1e-4;
  EXPECT_NEAR(found.seating.seated_percent, seated_r * seated_r, kPercent);
  EXPECT_NEAR(found.seating.max_gap_mm, difference(10) - difference(1), kTenthVoxel);
}

TEST(ImplantFit, AConvexBackRollsInACupOfItsRadius) {
  const double radius = 29;
  const double tilt = 9 * kDegree;
  Block block({44, 40, 12}, kVoxel, 1.8);
  block.ream(both(cap({0, 0, -5}, radius), rod({0, 0, 0}, Vec3::UnitZ(), 16)));
  // Rotated about the centre of the cup, which lies on both axes.
  const Vec3 center(0, 0, radius - 5);
  ImplantSettings implant = disc(18);
  implant.backside_radius_mm = radius;
  implant.axis = {std::sin(tilt), 0, std::cos(tilt)};
  implant.center_mm = center - radius * implant.axis;
  const Planning found = plan(block, implant);
  EXPECT_NEAR(found.seating.seated_percent, 100, 0.1);
  EXPECT_LT(found.seating.max_gap_mm, 2 * kTenthVoxel);
  EXPECT_NEAR((found.bone_from_implant.translation() - implant.center_mm).norm(), 0, 2 * kTenthVoxel);
  implant.axis = Vec3::UnitZ();  // the same place without tilt: the back rests on the higher side
  EXPECT_LT(plan(block, implant).seating.seated_percent, 40);
}

/// A face of two planes: level up to x = 0, then inclined.
Block roof_block(double angle) {
  Block block({40, 40, 14}, kVoxel, 1.8);
  const Solid level = above_plane({0, 0, -3}, Vec3::UnitZ());
  const Solid inclined = above_plane({0, 0, -3}, {std::sin(angle), 0, std::cos(angle)});
  block.ream([=](const Vec3& p) { return std::min(level(p), inclined(p)); });
  return block;
}

TEST(ImplantFit, AHalfWedgeFillsAnInclinedHalf) {
  const double angle = 15 * kDegree;
  const double radius = 10;
  const Block block = roof_block(angle);
  ImplantSettings implant = disc(2 * radius);
  const Planning plain = plan(block, implant);
  const double reach = 0.5 / std::tan(angle);  // of a gap of 0.5 mm
  EXPECT_NEAR(plain.seating.seated_percent, 100 * (1 - segment_mm2(radius, reach) / disc_mm2(radius)), kPercent);
  implant.augment = AugmentSettings{.angle_deg = 15, .direction = {2, 0, 7}, .start_mm = 0};
  const Planning wedge = plan(block, implant);
  EXPECT_NEAR(wedge.seating.seated_percent, 100, 0.1);
  EXPECT_LT(wedge.seating.max_gap_mm, 2 * kTenthVoxel);
  // Turned away from the inclined half, the wedge holds the implant off.
  implant.augment->direction = {-1, 0, 0};
  EXPECT_LT(plan(block, implant).seating.seated_percent, 25);
}

TEST(ImplantFit, AStepFillsAStep) {
  const double radius = 10;
  Block block({40, 40, 14}, kVoxel, 1.8);
  block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
  block.ream(both(above_plane({0, 0, -6}, Vec3::UnitZ()), above_plane({0, 0, 0}, Vec3::UnitX())));
  ImplantSettings implant = disc(2 * radius);
  EXPECT_NEAR(plan(block, implant).seating.seated_percent, 50, 2 * kPercent);
  implant.augment = AugmentSettings{.shape = AugmentShape::step, .step_mm = 3};
  const Planning found = plan(block, implant);
  EXPECT_NEAR(found.seating.seated_percent, 100, 2 * kPercent);  // but beside the wall of the step
  EXPECT_NEAR(found.seating.mean_gap_mm, 0, kTenthVoxel);
  EXPECT_NEAR(found.bone_from_implant.translation().z(), -3, kTenthVoxel);
}

/// A plate with a round peg in the frame of the implant: the back at z = 0, its corners at (±9, ±7).
TriangleMesh plate_with_peg(double peg_radius, double peg_mm) {
  constexpr int kSides = 48;  // of the peg
  TriangleMesh out;
  for (const double z : {0.0, 4.0}) {
    for (const Vec2& p : {Vec2(-9, -7), Vec2(9, -7), Vec2(9, 7), Vec2(-9, 7)})
      out.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (const double z : {0.0, -peg_mm}) {
    for (int n = 0; n < kSides; ++n) {
      const double angle = kPi * (2 * n + 1) / kSides - kPi;  // each quarter faces a corner
      out.vertices.emplace_back(2 + peg_radius * std::cos(angle), peg_radius * std::sin(angle), z);
    }
  }
  out.vertices.emplace_back(2, 0, -peg_mm);
  const auto quad = [&](int a, int b, int c, int d) {
    out.triangles.push_back({a, b, c});
    out.triangles.push_back({a, c, d});
  };
  quad(4, 5, 6, 7);  // top, sides
  for (int n = 0; n < 4; ++n) quad(n, (n + 1) % 4, 4 + (n + 1) % 4, 4 + n);
  for (int n = 0; n < kSides; ++n) {
    const int next = (n + 1) % kSides, top = 8, low = 8 + kSides;
    quad(low + n, low + next, top + next, top + n);
    out.triangles.push_back({low + next, low + n, 8 + 2 * kSides});
    out.triangles.push_back({n * 4 / kSides, top + n, top + next});  // the back round the peg
    if (next % (kSides / 4) == 0) out.triangles.push_back({n * 4 / kSides, top + next, (n * 4 / kSides + 1) % 4});
  }
  return out;
}

TEST(ImplantFit, AMeshIsItsBackAndItsPeg) {
  const TriangleMesh mesh = plate_with_peg(2, 8);
  ASSERT_TRUE(diagnose(mesh).closed_manifold()) << diagnose(mesh).text();
  ASSERT_GT(mesh.volume_mm3(), 18 * 14 * 4);
  MetricSettings settings;
  settings.implant = ImplantSettings{.mesh = ImplantMeshSettings{}};
  Block block({40, 40, 14}, kVoxel, 1.8);
  carve(block, above_plane({8, 0, 0}, Vec3::UnitX()));
  block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
  const auto found = block.measure(Rigid::Identity(), settings, {}, &mesh).planning;
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->seating.footprint_mm2, 18 * 14, 0.01 * 18 * 14);
  EXPECT_NEAR(found->seating.overhang_mm2, 14, 0.7);
  EXPECT_NEAR(found->seating.mean_gap_mm, 0, kTenthVoxel);
  ASSERT_EQ(found->pegs.size(), 1);
  EXPECT_NEAR(found->pegs[0].length_mm, 8, kTenthVoxel);
  EXPECT_NEAR(found->pegs[0].in_bone_mm, 8, 2 * kTenthVoxel);
  EXPECT_NEAR(found->pegs[0].least_wall_mm.value_or(-1), std::min(8 - 2 - 2, 11 - 8), kTenthVoxel);
  EXPECT_EQ(found->pegs_perforated(), 0);
  EXPECT_NEAR((found->peg_axes_mm.at(0).second - Vec3(2, 0, -8)).norm(), 0, kTenthVoxel);
  const TriangleMesh longer = plate_with_peg(2, 12);
  const auto through = block.measure(Rigid::Identity(), settings, {}, &longer).planning;
  ASSERT_TRUE(through);
  EXPECT_NEAR(through->pegs.at(0).perforated_mm, 1, 2 * kTenthVoxel);
  EXPECT_EQ(through->pegs_perforated(), 1);
}

TEST(ImplantFit, AMeshFileIsClosedAndInTheFrameOfTheImplant) {
  const std::string path = ::testing::TempDir() + "implant.stl";
  ImplantSettings settings{.mesh = ImplantMeshSettings{.path = path}};
  const auto complaint = [&](TriangleMesh mesh, double shift_mm) -> std::string {
    for (Vec3& vertex : mesh.vertices) vertex.z() += shift_mm;
    write_stl(path, mesh);
    Diagnostics report;
    try {
      EXPECT_NEAR(read_implant_mesh(settings, report).volume_mm3(), mesh.volume_mm3(), 0.01);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const TriangleMesh whole = plate_with_peg(2, 8);
  EXPECT_EQ(complaint(whole, 0), "");
  EXPECT_NE(complaint(whole, 1.5).find("metrics.implant.mesh.path: 0 % of its underside lie within 1 mm"),
            std::string::npos)
      << complaint(whole, 1.5);
  TriangleMesh open = whole;
  open.triangles.pop_back();
  EXPECT_NE(complaint(open, 0).find("give a closed two-manifold surface"), std::string::npos) << complaint(open, 0);
  settings.mesh->scale = 1000;
  EXPECT_NE(complaint(whole, 0).find("check metrics.implant.mesh.scale"), std::string::npos) << complaint(whole, 0);
}

TEST(ImplantFit, AFullWedgeIsATiltedFlatBack) {
  const double angle = 12 * kDegree;
  Block block({40, 40, 16}, kVoxel, 1.8);
  block.ream(above_plane({0, 0, -5}, {std::sin(angle), 0, std::cos(angle)}));
  ImplantSettings implant = disc(18);
  implant.augment = AugmentSettings{.angle_deg = 12, .direction = {1, 0, 0}, .start_mm = -9};
  const Planning found = plan(block, implant);
  EXPECT_NEAR(found.seating.seated_percent, 100, 0.1);
  EXPECT_LT(found.seating.max_gap_mm, 2 * kTenthVoxel);
}

TEST(ImplantFit, AWedgeOnAConvexBackIsARotatedSphere) {
  const double radius = 29;
  const double angle = 15 * kDegree;
  // The spherical back and its copy, rotated about the line x = z = 0 of the apex.
  const Vec3 apex(0, 0, -4);
  const Vec3 rotated = apex + radius * Vec3(std::sin(angle), 0, std::cos(angle));
  Block block({40, 40, 16}, kVoxel, 1.8);
  const Solid first = cap(apex, radius);
  const Solid second = ball(rotated, radius);
  block.ream(both([=](const Vec3& p) { return std::min(first(p), second(p)); }, rod({0, 0, 0}, Vec3::UnitZ(), 14)));
  ImplantSettings implant = disc(20);
  implant.backside_radius_mm = radius;
  implant.augment = AugmentSettings{.angle_deg = 15, .direction = {1, 0, 0}, .start_mm = 0};
  const Planning found = plan(block, implant);
  EXPECT_NEAR(found.seating.seated_percent, 100, 0.1);
  EXPECT_LT(found.seating.max_gap_mm, 0.1);
  EXPECT_NEAR(found.bone_from_implant.translation().z(), apex.z(), 2 * kTenthVoxel);
}

TEST(ImplantFit, ADiscOverTheEdgeOfABlock) {
  const double radius = 10;
  for (const double edge : {20.0, 18.3, 17.1}) {
    Block block({40, 40, 12}, kVoxel, 1.8);
    carve(block, above_plane({edge, 0, 0}, Vec3::UnitX()));
    block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
    ImplantSettings implant = disc(2 * radius);
    implant.center_mm = {13, 0, 0};
    const Planning found = plan(block, implant);
    const double beyond = segment_mm2(radius, edge - 13);
    EXPECT_NEAR(found.seating.overhang_mm2, beyond, 0.01 * beyond) << "edge " << edge;
    EXPECT_NEAR(found.seating.overhang_percent, 100 * beyond / disc_mm2(radius), 0.01 * kPercent * 100) << edge;
    EXPECT_NEAR(found.seating.seated_percent, 100 - 100 * beyond / disc_mm2(radius), kPercent) << edge;
  }
}

TEST(ImplantFit, BoneFarBelowAndHolesAreNoEdge) {
  // Beside the edge at x = 5 lies bone 2 mm lower (a gap) or 6 mm lower (beyond the bone); a bore is a hole.

  for (const double step : {2.0, 6.0}) {
    Block block({40, 40, 14}, kVoxel, 1.8);
    carve(block, both(above_plane({5, 0, 0}, Vec3::UnitX()), above_plane({0, 0, -3 - step}, Vec3::UnitZ())));
    block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
    block.ream(rod({-3, 0, 0}, Vec3::UnitZ(), 2));
    const Planning found = plan(block, disc(20));
    const double beyond = segment_mm2(10, 5);
    EXPECT_NEAR(found.seating.overhang_mm2, step > kOverhangDepth_mm ? beyond : 0, 0.03 * beyond) << "step " << step;
  }
}

TEST(ImplantFit, FootprintsHaveTheirAreas) {
  const Block block = flat_block({44, 44, 9}, 3);
  ImplantSettings implant;
  implant.width_mm = 24;
  implant.height_mm = 34;
  const double ellipse = kPi * 12 * 17;
  EXPECT_NEAR(plan(block, implant).seating.footprint_mm2, ellipse, 0.002 * ellipse);
  implant.footprint = FootprintShape::pear;
  // Circles of 12 and 9 mm radius, 13 mm apart, and the tangents between them.
  const double lean = std::asin((12.0 - 9.0) / 13.0);
  const double tangent = 13 * std::cos(lean);
  const double pear = 144 * (kPi / 2 + lean) + 81 * (kPi / 2 - lean) + (12 + 9) * tangent;
  EXPECT_NEAR(plan(block, implant).seating.footprint_mm2, pear, 0.002 * pear);
}

TEST(ImplantFit, TheLongSideFollowsTheSuperiorDirection) {
  // A face of 20 mm along x: an ellipse of 30 mm stands out where its long side lies along x.
  Block block({20, 44, 9}, kVoxel, 1.8);
  block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
  ImplantSettings implant;
  implant.width_mm = 16;
  implant.height_mm = 30;
  EXPECT_NEAR(plan(block, implant).seating.overhang_percent, 0, 0.1);
  implant.superior = Vec3(1, 0, 0.3);
  const double half = std::asin(10.0 / 15);  // the ellipse as a disc, stretched
  const double beyond = 1 - (2 * half + std::sin(2 * half)) / kPi;
  EXPECT_NEAR(plan(block, implant).seating.overhang_percent, 100 * beyond, kPercent);
  implant.superior.reset();
  BoneAxes axes;  // the glenoid knows it as well
  axes.glenoid = ScapularAxes{.lateral = Vec3::UnitZ(), .superior = Vec3::UnitX(), .anterior = -Vec3::UnitY()};
  EXPECT_NEAR(plan(block, implant, axes).seating.overhang_percent, 100 * beyond, kPercent);
}

TEST(ImplantFit, AnUnseatedImplantStaysWhereItIs) {
  ImplantSettings implant = disc(20);
  implant.seat = false;
  implant.frame = ImplantFrame::bone;
  implant.center_mm = {0, 0, -1.8};
  const Planning found = plan(flat_block({40, 40, 9}, 3), implant);
  EXPECT_NEAR(found.seating.mean_gap_mm, 1.2, kTenthVoxel);
  EXPECT_EQ(found.seating.seated_percent, 0);
}

TEST(ImplantFit, DenseBoneUnderALayeredBlock) {
  // Dense down to z = −3; the face is inclined, so that the layer of 2 mm below it is dense in part.
  const double slope = std::tan(6 * kDegree);
  const double radius = 10;
  Block block({40, 40, 12}, kVoxel, [](const Vec3& p) { return p.z() > -3 ? 1.8 : 0.4; });
  block.ream(above_plane({0, 0, -2}, {slope, 0, 1}));
  ImplantSettings implant = disc(2 * radius);
  implant.support_depth_mm = 2;
  double dense = 0;
  const int steps = 20000;
  for (int i = 0; i < steps; ++i) {  // ∫ of the dense length over the chords of the disc
    const double x = radius * ((2 * i + 1.0) / steps - 1);
    dense += std::clamp(1 - slope * x, 0.0, 2.0) * 2 * std::sqrt(radius * radius - x * x) * 2 * radius / steps;
  }
  const Planning found = plan(block, implant);
  ASSERT_TRUE(found.seating.dense_percent);
  EXPECT_NEAR(*found.seating.dense_percent, 100 * dense / (2 * disc_mm2(radius)), kPercent);
}

TEST(ImplantFit, BoneLeftInTheVaultOfABlock) {
  const double radius = 10;
  Block block({40, 40, 9}, kVoxel, 1.8);
  block.ream(both(above_plane({0, 0, -3}, Vec3::UnitZ()), rod({0, 0, 0}, Vec3::UnitZ(), 14)));
  for (const double depth : {28.0, 5.0}) {
    ImplantSettings implant = disc(2 * radius);
    implant.vault_depth_mm = depth;
    const Vault found = plan(block, implant).vault;
    const double before = std::min(depth, 9.0);
    EXPECT_NEAR(found.before_mm3, before * disc_mm2(radius), 0.01 * before * disc_mm2(radius));
    EXPECT_NEAR(found.left_mm3, (before - 3) * disc_mm2(radius), 0.01 * (before - 3) * disc_mm2(radius));
    EXPECT_NEAR(found.mean_depth_mm, before - 3, kTenthVoxel);
    ASSERT_TRUE(found.axis_depth_mm);
    EXPECT_NEAR(*found.axis_depth_mm, before - 3, kTenthVoxel);
  }
}

TEST(ImplantFit, TheVaultEndsAtTheFirstAirOfABall) {
  // A ball of 18 mm radius about (0, 0, −20), reamed flat at z = −6: on the axis 32 mm of bone are left.
  Block block({40, 40, 40}, kVoxel, 1.8);
  const Solid inside = ball({0, 0, -20}, 18);
  carve(block, [=](const Vec3& p) { return -inside(p); });
  block.ream(above_plane({0, 0, -6}, Vec3::UnitZ()));
  ImplantSettings implant = disc(16);
  implant.vault_depth_mm = 60;
  const Vault found = plan(block, implant).vault;
  const double half = std::pow(18, 3) - std::pow(18 * 18 - 64, 1.5);  // ∫ of the lower half over the disc, by 2π/3
  const double left = 2 * kPi / 3 * half + 14 * disc_mm2(8);
  EXPECT_NEAR(found.left_mm3, left, 0.01 * left);
  EXPECT_NEAR(found.axis_depth_mm.value_or(0), 32, kTenthVoxel);
}

TEST(ImplantFit, TheAxisLiesBetweenTheColumnsOverASteepBottom) {
  for (const Vec3& down : {Vec3(0.6, 0.4, -1), Vec3(-0.6, 0.4, -1), Vec3(0.6, -0.4, -1), Vec3(-0.6, -0.4, -1)}) {
    Block block({40, 40, 30}, kVoxel, 1.8);
    carve(block, above_plane({0, 0, -15}, down));
    block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
    EXPECT_NEAR(plan(block, disc(10)).vault.axis_depth_mm.value_or(0), 12, kTenthVoxel) << down.transpose();
  }
}

TEST(ImplantFit, AnglesOfATiltedImplant) {
  BoneAxes axes;
  axes.scapula = ScapularAxes{.lateral = Vec3::UnitZ(), .superior = Vec3::UnitY(), .anterior = Vec3::UnitX()};
  ImplantSettings implant = disc(16);
  const double version = 10 * kDegree;
  const double inclination = 5 * kDegree;
  implant.axis = 7 * Vec3(-std::sin(version) * std::cos(inclination), std::sin(inclination),
                          std::cos(version) * std::cos(inclination));
  const Planning found = plan(flat_block({40, 40, 9}, 3), implant, axes);
  ASSERT_TRUE(found.planned.value);
  EXPECT_NEAR(found.planned.value->version_deg, 10, 1e-9);
  EXPECT_NEAR(found.planned.value->inclination_deg, 5, 1e-9);
  EXPECT_FALSE(found.native.value);
  EXPECT_FALSE(found.corrected.value);
  EXPECT_NE(found.corrected.reason, "");
  EXPECT_FALSE(plan(flat_block({40, 40, 9}, 3), implant).planned.value);
}

TEST(ImplantFit, WithoutBoneOrFrameThereIsNothingToPlan) {
  const Block block = flat_block({40, 40, 9}, 3);
  MetricSettings settings;
  settings.implant = disc(10);
  settings.implant->center_mm = {300, 0, 0};
  EXPECT_FALSE(block.measure(Rigid::Identity(), settings).planning);
  settings.implant = disc(10);
  settings.implant->frame = ImplantFrame::glenoid;
  EXPECT_FALSE(block.measure(Rigid::Identity(), settings).planning);
  BoneAxes axes;
  axes.bone_from_glenoid = Rigid(Eigen::Translation3d(0, 0, -3));
  EXPECT_TRUE(block.measure(Rigid::Identity(), settings, axes).planning);
}

}  // namespace
}  // namespace reamsim::test

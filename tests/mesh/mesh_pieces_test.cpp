// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/mesh_shapes.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

std::vector<MeshPiece> pieces_of(TriangleMesh mesh) {
  return turn_outwards(mesh);
}

TEST(MeshPieces, HaveVolumeAndCentreTheLargestFirst) {
  const auto pieces =
      pieces_of(joined({box_mesh({100, 0, 0}, {101, 2, 4}), inside_out(box_mesh({0, 0, 0}, {9, 9, 9}))}));
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_NEAR(pieces[0].volume_mm3, 729, 1e-9);
  EXPECT_NEAR((pieces[0].centre_mm - Vec3(4.5, 4.5, 4.5)).norm(), 0, 1e-9);
  EXPECT_NEAR(pieces[1].volume_mm3, 8, 1e-9);
  EXPECT_NEAR((pieces[1].centre_mm - Vec3(100.5, 1, 2)).norm(), 0, 1e-9);
}

TEST(MeshPieces, InsideAnotherIsWhollyInside) {
  const TriangleMesh outer = sphere_mesh({0, 0, 0}, 10, 3);
  const auto is_inside = [&](const TriangleMesh& part) { return pieces_of(joined({part, outer}))[1].inside_another; };
  EXPECT_TRUE(is_inside(sphere_mesh({1, 2, 3}, 4, 2)));
  EXPECT_TRUE(is_inside(inside_out(sphere_mesh({0, 0, 0}, 4, 2)))) << "the wall of a cavity";
  EXPECT_TRUE(is_inside(box_mesh({-1, -1, -1}, {1, 1, 1}))) << "aligned with vertices of the sphere";
  EXPECT_FALSE(is_inside(sphere_mesh({9, 0, 0}, 4, 2))) << "overlapping";
  EXPECT_FALSE(is_inside(sphere_mesh({0, 0, -20}, 4, 2))) << "below";
  EXPECT_FALSE(is_inside(sphere_mesh({0, 0, 20}, 4, 2))) << "above";
  EXPECT_FALSE(pieces_of(outer)[0].inside_another);
}

TEST(MeshPieces, AnIslandInACavityIsInsideAnother) {
  const auto pieces = pieces_of(joined({box_mesh({-5, -5, -5}, {5, 5, 5}), inside_out(sphere_mesh({0, 0, 0}, 4, 2)),
                                        sphere_mesh({0, 0, 0}, 2, 2), box_mesh({-1, -1, -1}, {1, 1, 1})}));
  ASSERT_EQ(pieces.size(), 4U);
  EXPECT_FALSE(pieces[0].inside_another);
  for (std::size_t n = 1; n < pieces.size(); ++n) EXPECT_TRUE(pieces[n].inside_another) << n;
  EXPECT_NEAR(outer_volume_mm3(pieces), 1000, 1e-9);
  EXPECT_THAT(warnings_of(pieces), ::testing::ElementsAre(HasSubstr("3 surfaces inside another")));
}

TEST(MeshPieces, OfTwoCopiesNoneIsInsideTheOther) {
  const TriangleMesh sphere = sphere_mesh({0, 0, 0}, 4, 2);
  for (const MeshPiece& piece : pieces_of(joined({sphere, sphere}))) EXPECT_FALSE(piece.inside_another);
}

TEST(MeshPieces, ThoseOutsideTheOthersAreTurnedOutwards) {
  const TriangleMesh large = box_mesh({0, 0, 0}, {9, 9, 9}), cavity = box_mesh({3, 3, 3}, {4, 4, 4}),
                     small = box_mesh({20, 0, 0}, {22, 2, 2});
  TriangleMesh mesh = joined({large, cavity, inside_out(small)});
  const auto pieces = turn_outwards(mesh);
  EXPECT_EQ(mesh.triangles, joined({large, cavity, small}).triangles);
  EXPECT_NEAR(outer_volume_mm3(pieces), 729 + 8, 1e-9);
  EXPECT_THAT(warnings_of(pieces)[0], ::testing::StrEq("the triangles of a piece of the mesh face inwards: 8.00 mm3 at "
                                                       "(21.0, 1.0, 1.0) mm; orientation flipped"));
  mesh = joined({large, inside_out(cavity), small});
  turn_outwards(mesh);
  EXPECT_EQ(mesh.triangles, joined({large, inside_out(cavity), small}).triangles) << "a cavity stays one";
  mesh = joined({inside_out(large), inside_out(small)});
  EXPECT_THAT(warnings_of(turn_outwards(mesh))[0], HasSubstr("the triangles of the mesh face inwards;"));
  EXPECT_NEAR(mesh.volume_mm3(), 729 + 8, 1e-9);
}

TEST(MeshPieces, ThreeAreNamedAndTheOthersCounted) {
  std::vector<TriangleMesh> parts{box_mesh({0, 0, 0}, {9, 9, 9}), box_mesh({3, 3, 3}, {4, 4, 4})};
  for (int i = 1; i <= 5; ++i) parts.push_back(box_mesh({20.0 * i, 0, 0}, {20.0 * i + i, 1, 1}));
  const std::vector<std::string> warnings = warnings_of(pieces_of(joined(parts)));
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_THAT(warnings[0],
              HasSubstr("5 pieces besides the largest: 5.00 mm3 at (102.5, 0.5, 0.5) mm, 4.00 mm3 at (82.0, "
                        "0.5, 0.5) mm, 3.00 mm3 at (61.5, 0.5, 0.5) mm and 2 more; all are kept as bone"));
  EXPECT_THAT(warnings[1], HasSubstr("a surface inside another"));
  EXPECT_TRUE(warnings_of(pieces_of(parts[0])).empty());
}

}  // namespace
}  // namespace reamsim::test

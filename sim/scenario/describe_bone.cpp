// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"
#include "sim/scenario/presets.h"

namespace reamsim {

namespace {

constexpr int kLeastRimPoints = 6;

}  // namespace

void describe_density(KeyVisitor& v, DensitySettings& density) {
  v.number(
      {.name = "ash_slope_g_cm3_per_hu",
       .doc = "Ash density = slope·HU + offset. Measured on a femur at 120 kVp (PMC5234499, Table 1), not on a scapula",
       .range = between(1e-6, 0.1)},
      density.ash_slope_g_cm3_per_hu);
  v.number({.name = "ash_offset_g_cm3", .doc = "See ash_slope_g_cm3_per_hu", .range = between(-2, 2)},
           density.ash_offset_g_cm3);
  v.number({.name = "ash_fraction", .doc = "Ash density over apparent density", .range = between(0.05, 1)},
           density.ash_fraction);
}

namespace {

void describe_landmarks(KeyVisitor& v, LandmarkSettings& landmarks) {
  v.vector({.name = "glenoid_center_mm",
            .doc = "Centre of the glenoid, bone frame",
            .required = true,
            .range = kPosition,
            .point = true},
           landmarks.glenoid_center_mm);
  v.vector({.name = "trigonum_spinae_mm",
            .doc = "Where the scapular spine meets the medial border, bone frame",
            .required = true,
            .range = kPosition,
            .point = true},
           landmarks.trigonum_spinae_mm);
  v.vector({.name = "inferior_angle_mm",
            .doc = "Lowest point of the scapula, bone frame",
            .required = true,
            .range = kPosition,
            .point = true},
           landmarks.inferior_angle_mm);
}

void describe_glenoid(KeyVisitor& v, GlenoidSettings& glenoid) {
  v.optional_vector({.name = "near_mm",
                     .doc = "A point within 8 mm of the centre of the face, bone frame. The face is found round it: "
                            "centre and normal, and superior too unless superior or landmarks give it",
                     .range = kPosition,
                     .point = true},
                    glenoid.near_mm);
  v.optional_vector(
      {.name = "center_mm", .doc = "Origin of the glenoid frame, bone frame", .range = kPosition, .point = true},
      glenoid.center_mm);
  v.optional_vector({.name = "normal",
                     .doc = "Out of the bone, along the face normal (+z of the glenoid frame)",
                     .range = kComponent,
                     .nonzero = true},
                    glenoid.normal);
  v.optional_vector({.name = "superior",
                     .doc = "Superior direction; its part perpendicular to the normal is +y",
                     .range = kComponent,
                     .nonzero = true},
                    glenoid.superior);
  v.optional_section(
      {.name = "landmarks",
       .doc = "Instead of center_mm, normal and superior; beside near_mm for superior and the scapular frame"},
      glenoid.landmarks, describe_landmarks);
  v.points({.name = "rim_mm",
            .doc = "Points on the rim of the face before reaming, bone frame, in order around it, at least 6. They "
                   "delimit the face whose orientation and area are measured. A glenoid or cup phantom has its own",
            .range = kPosition,
            .point = true,
            .least_points = kLeastRimPoints},
           glenoid.rim_mm);
  v.group({.names = {"near_mm", "center_mm"}, .one_needed = false});
  v.group({.names = {"near_mm", "normal"}, .one_needed = false});
  v.group({.names = {"landmarks", "center_mm"}, .one_needed = false});
  v.group({.names = {"landmarks", "normal"}, .one_needed = false});
  v.group({.names = {"landmarks", "superior"}, .one_needed = false});
}

void describe_glenoid_size(KeyVisitor& v, PhantomSettings& phantom) {
  const When glenoid{"shape", {"glenoid"}};
  v.number({.name = "height_mm",
            .doc = "Height of the face, superior to inferior",
            .range = between(10, 80),
            .when = glenoid,
            .default_by = "walch"},
           phantom.height_mm);
  v.number({.name = "width_mm",
            .doc = "Width of the face, anterior to posterior, of the lower, wider part",
            .range = between(6, 79),
            .when = glenoid,
            .default_by = "walch"},
           phantom.width_mm);
  v.number({.name = "face_radius_mm",
            .doc = "Radius of curvature of the concave face where it is not worn",
            .range = between(15, 1000),
            .when = glenoid,
            .default_by = "walch"},
           phantom.face_radius_mm);
  v.number({.name = "vault_depth_mm",
            .doc = "Depth of the vault, from face to neck",
            .range = between(5, 100),
            .when = glenoid},
           phantom.vault_depth_mm);
  v.number({.name = "version_deg",
            .doc = "Version of the face before wear, in the scapular frame; retroversion positive",
            .range = between(-45, 45),
            .when = glenoid,
            .default_by = "walch"},
           phantom.version_deg);
  v.number({.name = "inclination_deg",
            .doc = "Inclination of the face before wear, in the scapular frame; superior tilt positive",
            .range = between(-45, 45),
            .when = glenoid,
            .default_by = "walch"},
           phantom.inclination_deg);
}

void describe_wear(KeyVisitor& v, PhantomSettings& phantom) {
  const When biconcave{"walch", {"B2"}};
  v.number({.name = "medialization_mm",
            .doc = "Displacement of the centre of the face towards the trigonum spinae by wear",
            .range = between(0, 40),
            .when = {"walch", {"A1", "A2"}},
            .default_by = "walch"},
           phantom.medialization_mm);
  v.number({.name = "wear_radius_mm",
            .doc = "Radius of the humeral head that wore the face",
            .range = between(10, 100),
            .when = {"walch", {"A1", "A2", "B2"}}},
           phantom.wear_radius_mm);
  v.number({.name = "wear_direction_deg",
            .doc = "Direction of the neoglenoid from the centre, from posterior (0) to inferior (90)",
            .range = between(0, 90),
            .when = biconcave},
           phantom.wear_direction_deg);
  v.number({.name = "wear_ridge_mm",
            .doc = "Distance of the ridge of the neoglenoid from the centre, in that direction",
            .range = between(-20, 20),
            .when = biconcave},
           phantom.wear_ridge_mm);
  v.number({.name = "wear_tilt_deg",
            .doc = "Angle from the axis of the native face to that of the neoglenoid",
            .range = between(0.1, 40),
            .when = biconcave},
           phantom.wear_tilt_deg);
  v.number({.name = "rim_rounding_mm",
            .doc = "Width over which the deficient posteroinferior rim is rounded off",
            .range = between(2.4, 20),
            .when = {"walch", {"C"}}},
           phantom.rim_rounding_mm);
}

void describe_glenoid_phantom(KeyVisitor& v, PhantomSettings& phantom) {
  const When glenoid{"shape", {"glenoid"}};
  v.choice({.name = "walch",
            .doc = "Walch type, which sets other defaults. none: healthy; A1, A2: minor or severe concentric wear; B2: "
                   "biconcave; C: dysplastic",
            .when = glenoid},
           phantom.walch);
  v.defaults([&phantom] { apply_walch_defaults(phantom); });
  describe_glenoid_size(v, phantom);
  describe_wear(v, phantom);
  v.number({.name = "subchondral_density_g_cm3",
            .doc = "Density of the subchondral plate; the default was measured in one scanned shoulder",
            .range = kDensity,
            .when = glenoid},
           phantom.subchondral_density_g_cm3);
  v.number({.name = "subchondral_mm",
            .doc = "Thickness of the subchondral plate",
            .range = between(0.2, 10),
            .when = glenoid},
           phantom.subchondral_mm);
  v.number({.name = "shell_mm",
            .doc = "Thickness of the cortical wall of the vault",
            .range = between(0.2, 10),
            .when = glenoid},
           phantom.shell_mm);
  v.number({.name = "trabecular_gradient",
            .doc = "1: trabecular bone is twice as dense as trabecular_density_g_cm3 under the plate and 0.7 times as "
                   "dense deep in the vault; 0: one density throughout",
            .range = between(0, 1),
            .when = glenoid},
           phantom.trabecular_gradient);
  v.number({.name = "texture",
            .doc = "Relative amplitude of the trabecular texture",
            .range = between(0, 1),
            .when = glenoid},
           phantom.texture);
  v.integer({.name = "seed", .doc = "Seed of the texture", .range = between(0, 2147483647), .when = glenoid},
            phantom.seed);
}

void describe_phantom(KeyVisitor& v, PhantomSettings& phantom) {
  v.choice({.name = "shape",
            .doc = "half_space: a block; cup: a block with a spherical cup; sphere; layered: a block, cortical on "
                   "trabecular; glenoid: a parametric glenoid. The top face of a block is z = 0, its middle x = y = 0"},
           phantom.shape);
  v.number({.name = "density_g_cm3",
            .doc = "Density of the phantom",
            .range = kDensity,
            .when = {"shape", {"half_space", "cup", "sphere"}}},
           phantom.density_g_cm3);
  v.vector({.name = "size_mm",
            .doc = "Size of the block",
            .range = between(0.5, 1000),
            .when = {"shape", {"half_space", "cup", "layered"}}},
           phantom.size_mm);
  v.number({.name = "radius_mm",
            .doc = "Radius of the sphere, or of the spherical cup",
            .range = between(0.5, 500),
            .when = {"shape", {"sphere", "cup"}}},
           phantom.radius_mm);
  v.number({.name = "cup_depth_mm", .doc = "Depth of the cup", .range = between(0.01, 500), .when = {"shape", {"cup"}}},
           phantom.cup_depth_mm);
  v.number({.name = "cortical_mm",
            .doc = "Thickness of the top layer",
            .range = between(0.01, 500),
            .when = {"shape", {"layered"}}},
           phantom.cortical_mm);
  v.number({.name = "cortical_density_g_cm3",
            .doc = "Density of the dense layer, or of the cortical wall of a glenoid",
            .range = kDensity,
            .when = {"shape", {"layered", "glenoid"}}},
           phantom.cortical_density_g_cm3);
  v.number({.name = "trabecular_density_g_cm3",
            .doc = "Density of the interior; in a glenoid modified by trabecular_gradient",
            .range = kDensity,
            .when = {"shape", {"layered", "glenoid"}}},
           phantom.trabecular_density_g_cm3);
  describe_glenoid_phantom(v, phantom);
}

void describe_mesh(KeyVisitor& v, MeshBoneSettings& mesh) {
  v.text({.name = "path", .doc = "STL, OBJ or PLY", .required = true, .text = TextKind::input_file}, mesh.path);
  v.number({.name = "scale", .doc = "File units to mm", .range = kFileUnit}, mesh.scale);
  v.choice(
      {.name = "frame",
       .doc = "Frame of the coordinates in the file; in the bone frame they are LPS. file: as its header says "
              "(`SPACE=RAS`), and as they stand where it says nothing; ras: x and y are negated; lps: as they stand"},
      mesh.frame);
  v.number({.name = "cortical_mm", .doc = "Thickness of the cortical shell", .range = between(0, 50)},
           mesh.cortical_mm);
  v.number({.name = "cortical_hu", .doc = "HU of the shell", .range = kHu}, mesh.cortical_hu);
  v.number({.name = "trabecular_hu", .doc = "HU of the interior", .range = kHu}, mesh.trabecular_hu);
  v.flag({.name = "repair",
          .doc = "Close the holes of a mesh and turn its triangles alike, and report what was done. Small holes need "
                 "no repair"},
         mesh.repair);
  v.number({.name = "repair_change_percent",
            .doc = "The most by which a repair may change the volume, in percent of it",
            .range = between(0, 1000)},
           mesh.repair_change_percent);
}

void describe_vdb(KeyVisitor& v, VdbBoneSettings& vdb) {
  v.text({.name = "path",
          .doc = "A reamed.vdb, or a file of `reamsim import`",
          .required = true,
          .text = TextKind::input_file},
         vdb.path);
}

void describe_pilot_hole(KeyVisitor& v, PilotHoleSettings& hole) {
  v.number({.name = "diameter_mm", .doc = "Diameter of the hole", .range = between(0.01, 30)}, hole.diameter_mm);
  v.vector({.name = "entry_mm", .doc = "Start of the axis of the hole", .range = kPosition, .point = true},
           hole.entry_mm);
  v.vector({.name = "axis", .doc = "Direction of drilling", .range = kComponent, .nonzero = true}, hole.axis);
  v.number({.name = "depth_mm", .doc = "Depth of the hole from entry_mm", .range = between(0.01, 500)}, hole.depth_mm);
  v.choice({.name = "frame", .doc = "Frame of entry_mm and axis"}, hole.frame);
}

}  // namespace

void describe_bone(KeyVisitor& v, BoneSettings& bone) {
  v.choice({.name = "source", .doc = "Source of the bone", .required = true}, bone.source);
  v.choice({.name = "side",
            .doc = "Side of the body; required with a glenoid frame: with bone.glenoid, a glenoid phantom, or a frame: "
                   "glenoid. Without it that of a VDB applies"},
           bone.side);
  v.number({.name = "voxel_mm",
            .doc = "Edge length of a voxel. A VDB keeps its own",
            .range = between(BoneSettings::kLeastVoxel_mm, BoneSettings::kMostVoxel_mm)},
           bone.voxel_mm);
  v.choice(
      {.name = "surface_voxels",
       .doc =
           "Voxels on the surface of the bone. partial: fill is the fraction that is bone; whole: bone or air, by the "
           "voxel centre; auto: partial for `cutting.erosion: exact`, otherwise whole. A VDB keeps its own fill"},
      bone.surface_voxels);
  v.section({.name = "density", .doc = "Relation from HU to density"}, bone.density, describe_density);
  v.section({.name = "glenoid",
             .doc = "Glenoid frame (near_mm; or center_mm, normal and superior; or landmarks), and the rim of the "
                    "face. Without a "
                    "frame that of a phantom or VDB applies"},
            bone.glenoid, describe_glenoid);
  v.section({.name = "phantom", .doc = "A generated bone", .when = {"source", {"phantom"}}}, bone.phantom,
            describe_phantom);
  v.section({.name = "ct", .doc = "A CT scan", .required = true, .when = {"source", {"ct"}}}, bone.ct, describe_ct);
  v.section({.name = "mesh", .doc = "A closed surface", .required = true, .when = {"source", {"mesh"}}}, bone.mesh,
            describe_mesh);
  v.section({.name = "vdb", .doc = "A bone of an earlier run or import", .required = true, .when = {"source", {"vdb"}}},
            bone.vdb, describe_vdb);
  v.optional_section({.name = "pilot_hole", .doc = "Hole drilled before the run"}, bone.pilot_hole,
                     describe_pilot_hole);
}

}  // namespace reamsim

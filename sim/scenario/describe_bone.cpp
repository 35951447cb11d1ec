// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"
#include "sim/scenario/presets.h"

namespace reamsim {

namespace {

void describe_landmarks(KeyVisitor& v, LandmarkSettings& landmarks) {
  v.point("glenoid_center_mm", landmarks.glenoid_center_mm, "Centre of the glenoid, bone frame", {.required = true});
  v.point("trigonum_spinae_mm", landmarks.trigonum_spinae_mm,
          "Where the scapular spine meets the medial border, bone frame", {.required = true});
  v.point("inferior_angle_mm", landmarks.inferior_angle_mm, "Lowest point of the scapula, bone frame",
          {.required = true});
}

void describe_glenoid(KeyVisitor& v, GlenoidSettings& glenoid) {
  v.point("near_mm", glenoid.near_mm,
          "A point within 8 mm of the centre of the face, bone frame. The face is found round it: centre and normal, "
          "and superior too unless superior or landmarks give it");
  v.point("center_mm", glenoid.center_mm, "Origin of the glenoid frame, bone frame");
  v.direction("normal", glenoid.normal, "Out of the bone, along the face normal (+z of the glenoid frame)");
  v.direction("superior", glenoid.superior, "Superior direction; its part perpendicular to the normal is +y");
  v.section("landmarks", glenoid.landmarks, describe_landmarks,
            "Instead of center_mm, normal and superior; beside near_mm for superior and the scapular frame");
  v.point("rim_mm", glenoid.rim_mm,
          "Points on the rim of the face before reaming, bone frame, in order around it, at least 6. They delimit the "
          "face whose orientation and area are measured. A glenoid or cup phantom has its own",
          {.least_points = 6});
  v.group({.names = {"near_mm", "center_mm"}, .one_needed = false});
  v.group({.names = {"near_mm", "normal"}, .one_needed = false});
  v.group({.names = {"landmarks", "center_mm"}, .one_needed = false});
  v.group({.names = {"landmarks", "normal"}, .one_needed = false});
  v.group({.names = {"landmarks", "superior"}, .one_needed = false});
}

void describe_wear(KeyVisitor& v, PhantomSettings& phantom) {
  const When biconcave{"walch", {"B2"}};
  v.key("medialization_mm", phantom.medialization_mm,
        "Displacement of the centre of the face towards the trigonum spinae by wear",
        {.range = between(0, 40), .when = {"walch", {"A1", "A2"}}, .default_by = "walch"});
  v.key("wear_radius_mm", phantom.wear_radius_mm, "Radius of the humeral head that wore the face",
        {.range = between(10, 100), .when = {"walch", {"A1", "A2", "B2"}}});
  v.key("wear_direction_deg", phantom.wear_direction_deg,
        "Direction of the neoglenoid from the centre, from posterior (0) to inferior (90)",
        {.range = between(0, 90), .when = biconcave});
  v.key("wear_ridge_mm", phantom.wear_ridge_mm,
        "Distance of the ridge of the neoglenoid from the centre, in that direction",
        {.range = between(-20, 20), .when = biconcave});
  v.key("wear_tilt_deg", phantom.wear_tilt_deg, "Angle from the axis of the native face to that of the neoglenoid",
        {.range = between(0.1, 40), .when = biconcave});
  v.key("rim_rounding_mm", phantom.rim_rounding_mm, "Width over which the deficient posteroinferior rim is rounded off",
        {.range = between(2.4, 20), .when = {"walch", {"C"}}});
}

void describe_glenoid_phantom(KeyVisitor& v, PhantomSettings& phantom) {
  const When glenoid{"shape", {"glenoid"}};
  v.key("walch", phantom.walch,
        "Walch type, which sets other defaults. none: healthy; A1, A2: minor or severe concentric wear; B2: biconcave; "
        "C: dysplastic",
        {.when = glenoid});
  v.defaults([&phantom] { apply_walch_defaults(phantom); });
  v.key("height_mm", phantom.height_mm, "Height of the face, superior to inferior",
        {.range = between(10, 80), .when = glenoid, .default_by = "walch"});
  v.key("width_mm", phantom.width_mm, "Width of the face, anterior to posterior, of the lower, wider part",
        {.range = between(6, 79), .when = glenoid, .default_by = "walch"});
  v.key("face_radius_mm", phantom.face_radius_mm, "Radius of curvature of the concave face where it is not worn",
        {.range = between(15, 1000), .when = glenoid, .default_by = "walch"});
  v.key("vault_depth_mm", phantom.vault_depth_mm, "Depth of the vault, from face to neck",
        {.range = between(5, 100), .when = glenoid});
  v.key("version_deg", phantom.version_deg,
        "Version of the face before wear, in the scapular frame; retroversion positive",
        {.range = between(-45, 45), .when = glenoid, .default_by = "walch"});
  v.key("inclination_deg", phantom.inclination_deg,
        "Inclination of the face before wear, in the scapular frame; superior tilt positive",
        {.range = between(-45, 45), .when = glenoid, .default_by = "walch"});
  describe_wear(v, phantom);
  v.key("subchondral_density_g_cm3", phantom.subchondral_density_g_cm3,
        "Density of the subchondral plate; the default was measured in one scanned shoulder",
        {.range = kDensity, .when = glenoid});
  v.key("subchondral_mm", phantom.subchondral_mm, "Thickness of the subchondral plate",
        {.range = between(0.2, 10), .when = glenoid});
  v.key("shell_mm", phantom.shell_mm, "Thickness of the cortical wall of the vault",
        {.range = between(0.2, 10), .when = glenoid});
  v.key("trabecular_gradient", phantom.trabecular_gradient,
        "1: trabecular bone is twice as dense as trabecular_density_g_cm3 under the plate and 0.7 times as dense deep "
        "in the vault; 0: one density throughout",
        {.range = between(0, 1), .when = glenoid});
  v.key("texture", phantom.texture, "Relative amplitude of the trabecular texture",
        {.range = between(0, 1), .when = glenoid});
  v.key("seed", phantom.seed, "Seed of the texture", {.range = between(0, 2147483647), .when = glenoid});
}

void describe_phantom(KeyVisitor& v, PhantomSettings& phantom) {
  v.key("shape", phantom.shape,
        "half_space: a block; cup: a block with a spherical cup; sphere; layered: a block, cortical on trabecular; "
        "glenoid: a parametric glenoid. The top face of a block is z = 0, its middle x = y = 0");
  v.key("density_g_cm3", phantom.density_g_cm3, "Density of the phantom",
        {.range = kDensity, .when = {"shape", {"half_space", "cup", "sphere"}}});
  v.key("size_mm", phantom.size_mm, "Size of the block",
        {.range = between(0.5, 1000), .when = {"shape", {"half_space", "cup", "layered"}}});
  v.key("radius_mm", phantom.radius_mm, "Radius of the sphere, or of the spherical cup",
        {.range = between(0.5, 500), .when = {"shape", {"sphere", "cup"}}});
  v.key("cup_depth_mm", phantom.cup_depth_mm, "Depth of the cup",
        {.range = between(0.01, 500), .when = {"shape", {"cup"}}});
  v.key("cortical_mm", phantom.cortical_mm, "Thickness of the top layer",
        {.range = between(0.01, 500), .when = {"shape", {"layered"}}});
  v.key("cortical_density_g_cm3", phantom.cortical_density_g_cm3,
        "Density of the dense layer, or of the cortical wall of a glenoid",
        {.range = kDensity, .when = {"shape", {"layered", "glenoid"}}});
  v.key("trabecular_density_g_cm3", phantom.trabecular_density_g_cm3,
        "Density of the interior; in a glenoid modified by trabecular_gradient",
        {.range = kDensity, .when = {"shape", {"layered", "glenoid"}}});
  describe_glenoid_phantom(v, phantom);
}

void describe_mesh(KeyVisitor& v, MeshBoneSettings& mesh) {
  v.key("path", mesh.path, "STL, OBJ or PLY", {.required = true, .text = TextKind::input_file});
  v.key("scale", mesh.scale, "File units to mm", kFileUnit);
  v.key("frame", mesh.frame,
        "Frame of the coordinates in the file; in the bone frame they are LPS. file: as its header says (`SPACE=RAS`), "
        "and as they stand where it says nothing; ras: x and y are negated; lps: as they stand");
  v.key("cortical_mm", mesh.cortical_mm, "Thickness of the cortical shell", between(0, 50));
  v.key("cortical_hu", mesh.cortical_hu, "HU of the shell", kHu);
  v.key("trabecular_hu", mesh.trabecular_hu, "HU of the interior", kHu);
  v.key("repair", mesh.repair,
        "Close the holes of a mesh and turn its triangles alike, and report what was done. Small holes need no repair");
  v.key("repair_change_percent", mesh.repair_change_percent,
        "The most by which a repair may change the volume, in percent of it", between(0, 1000));
}

void describe_vdb(KeyVisitor& v, VdbBoneSettings& vdb) {
  v.key("path", vdb.path, "A reamed.vdb, or a file of `reamsim import`",
        {.required = true, .text = TextKind::input_file});
}

void describe_pilot_hole(KeyVisitor& v, PilotHoleSettings& hole) {
  v.key("diameter_mm", hole.diameter_mm, "Diameter of the hole", between(0.01, 30));
  v.point("entry_mm", hole.entry_mm, "Start of the axis of the hole");
  v.direction("axis", hole.axis, "Direction of drilling");
  v.key("depth_mm", hole.depth_mm, "Depth of the hole from entry_mm", between(0.01, 500));
  v.key("frame", hole.frame, "Frame of entry_mm and axis");
}

void describe_label_map(KeyVisitor& v, LabelMapSettings& labels) {
  v.key("path", labels.path,
        "NRRD (.seg.nrrd of 3D Slicer, layers included), NIfTI or MetaImage with a label per voxel, on any grid",
        {.required = true, .text = TextKind::input_file});
  v.key("label", labels.label,
        "Label of the bone: a number, or the name of a segment in the file (a to z as A to Z). Several in a list form "
        "one bone");
  v.key("refine_mm", labels.refine_mm,
        "Largest distance over which the surface of the mask moves to the isosurface of refine_hu; 0: no refinement",
        between(0, 5));
  v.key("refine_hu", labels.refine_hu,
        "Radiodensity of the surface with refine_mm; what is denser and has no label is warned of", kHu);
  v.key("fill", labels.fill,
        "Add bone without a label, at or above refine_hu, that the label surrounds or that lies in its holes up to 10 "
        "mm wide, and cavities that it encloses");
}

void describe_hu(KeyVisitor& v, HuSettings& hu) {
  v.key("slope", hu.slope, "HU for each unit of the values", between(0.001, 1000));
  v.key("intercept", hu.intercept, "HU of the value 0", between(-70000, 70000));
}

void describe_cut_sphere(KeyVisitor& v, CutSphereSettings& sphere) {
  v.point("center_mm", sphere.center_mm, "LPS", {.required = true});
  v.key("radius_mm", sphere.radius_mm, "Bone inside the sphere is removed",
        {.required = true, .range = between(0.01, 500)});
}

void describe_cut_plane(KeyVisitor& v, CutPlaneSettings& plane) {
  v.point("point_mm", plane.point_mm, "A point of the plane, LPS", {.required = true});
  v.direction("normal", plane.normal, "Normal of the plane; bone on the side to which it points is removed",
              {.required = true});
}

constexpr std::string_view kLabels = "label_map";

/// What a label map replaces.
void describe_segmentation(KeyVisitor& v, CtSettings& ct) {
  v.key("threshold_hu", ct.threshold_hu, "Least radiodensity of bone", {.range = kHu, .unless = kLabels});
  v.key("closing_mm", ct.closing_mm, "Radius of the closing that bridges gaps in the cortex; 0: none",
        {.range = between(0, 20), .unless = kLabels});
  v.key("fill_holes", ct.fill_holes, "Fill the interior of the cortex, to keep trabecular bone below the threshold",
        {.unless = kLabels});
  v.point("seed_mm", ct.seed_mm, "Point inside the connected piece to keep, LPS; without it the largest piece is kept",
          {.unless = kLabels});
  v.key(
      "separate", ct.separate,
      "humerus: a sphere is fitted to the head of the humerus next to the glenoid (bone.glenoid.near_mm, center_mm or "
      "landmarks), and the bone is cut along the joint gap. Without seed_mm the scapula is the piece behind the gap",
      {.unless = kLabels});
  v.list("cut_spheres", ct.cut_spheres, describe_cut_sphere, "Spheres that separate the bone from its neighbours",
         {.unless = kLabels});
  v.list("cut_planes", ct.cut_planes, describe_cut_plane, "Planes that separate the bone from its neighbours",
         {.unless = kLabels});
}

void describe_ct(KeyVisitor& v, CtSettings& ct) {
  v.key("path", ct.path, "DICOM folder (searched with its subfolders), DICOMDIR, NRRD, NIfTI or MetaImage",
        {.required = true, .text = TextKind::input_path});
  v.section("hu", ct.hu, describe_hu,
            "HU from the values of a scan that are no HU, after the scale of the file: slope · value + intercept");
  v.key("series", ct.series,
        "DICOM series: UID, or number in the list that a warning gives; without it the CT series with the most slices. "
        "SERIES/2 or SERIES#AcquisitionNumber=1 chooses a volume of a series that holds several",
        {.number_too = true});
  v.key("modality", ct.modality, "Accepted DICOM modality; any: also series that are not CT");
  v.key("uneven", ct.uneven,
        "DICOM slices whose spacing changes, or that are missing; resample: interpolated at the finest spacing, with a "
        "warning");
  v.key("crop_min_mm", ct.crop_min_mm, "Lower corner of the crop, LPS; with crop_max_mm",
        {.range = between(-10000, 9990), .point = true});
  v.key("crop_max_mm", ct.crop_max_mm, "Upper corner of the crop, LPS; with crop_min_mm",
        {.range = between(-9990, 10000), .point = true});
  v.key("filter", ct.filter, "Noise filter before thresholding");
  v.key("median_radius_voxels", ct.median_radius_voxels, "Used by `filter: median` only", between(1, 10));
  v.key("anisotropic_iterations", ct.anisotropic_iterations, "Used by `filter: curvature_anisotropic` only",
        between(1, 100));
  v.key("anisotropic_conductance", ct.anisotropic_conductance, "Used by `filter: curvature_anisotropic` only",
        between(0.01, 100));
  v.section(kLabels, ct.label_map, describe_label_map, "Instead of threshold, closing, filling, seed and cuts");
  v.key("psf_mm", ct.psf_mm,
        "Full width of the point spread function (PSF) of the scanner; 0: the voxel spacing along each axis, or of an "
        "oblique scan 1.25 times the extent of its voxel along each axis of LPS",
        between(0, 10));
  describe_segmentation(v, ct);
}

}  // namespace

void describe_density(KeyVisitor& v, DensitySettings& density) {
  v.key("ash_slope_g_cm3_per_hu", density.ash_slope_g_cm3_per_hu,
        "Ash density = slope·HU + offset. Measured on a femur at 120 kVp (PMC5234499, Table 1), not on a scapula",
        between(1e-6, 0.1));
  v.key("ash_offset_g_cm3", density.ash_offset_g_cm3, "See ash_slope_g_cm3_per_hu", between(-2, 2));
  v.key("ash_fraction", density.ash_fraction, "Ash density over apparent density", between(0.05, 1));
}

void describe_bone(KeyVisitor& v, BoneSettings& bone) {
  v.key("source", bone.source, "Source of the bone", {.required = true});
  v.key("side", bone.side,
        "Side of the body; required with a glenoid frame: with bone.glenoid, a glenoid phantom, or a frame: glenoid. "
        "Without it that of a VDB applies");
  v.key("voxel_mm", bone.voxel_mm, "Edge length of a voxel. A VDB keeps its own",
        between(BoneSettings::kLeastVoxel_mm, BoneSettings::kMostVoxel_mm));
  v.key("surface_voxels", bone.surface_voxels,
        "Voxels on the surface of the bone. partial: fill is the fraction that is bone; whole: bone or air, by the "
        "voxel centre; auto: partial for `cutting.erosion: exact`, otherwise whole. A VDB keeps its own fill");
  v.section("density", bone.density, describe_density, "Relation from HU to density");
  v.section("glenoid", bone.glenoid, describe_glenoid,
            "Glenoid frame (near_mm; or center_mm, normal and superior; or landmarks), and the rim of the face. "
            "Without a frame that of a phantom or VDB applies");
  v.section("phantom", bone.phantom, describe_phantom, "A generated bone", {.when = {"source", {"phantom"}}});
  v.section("ct", bone.ct, describe_ct, "A CT scan", {.required = true, .when = {"source", {"ct"}}});
  v.section("mesh", bone.mesh, describe_mesh, "A closed surface", {.required = true, .when = {"source", {"mesh"}}});
  v.section("vdb", bone.vdb, describe_vdb, "A bone of an earlier run or import",
            {.required = true, .when = {"source", {"vdb"}}});
  v.section("pilot_hole", bone.pilot_hole, describe_pilot_hole, "Hole drilled before the run");
}

}  // namespace reamsim

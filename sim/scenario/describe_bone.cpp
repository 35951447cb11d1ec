// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse.h"
#include "sim/scenario/parse_steps.h"

namespace reamsim {

namespace {

void describe_landmarks(KeyVisitor& v, LandmarkSettings& landmarks) {
  v.point("glenoid_center_mm", landmarks.glenoid_center_mm, "Glenoid centre, bone frame", {.required = true});
  v.point("trigonum_spinae_mm", landmarks.trigonum_spinae_mm,
          "Where the scapular spine meets the medial border, bone frame", {.required = true});
  v.point("inferior_angle_mm", landmarks.inferior_angle_mm, "Lowest point of the scapula, bone frame",
          {.required = true});
}

void describe_version_landmarks(KeyVisitor& v, VersionLandmarks& marks) {
  v.point("face_mm", marks.face_mm, "At least 3 points on the rim of the unreamed face, bone frame, for two_planes",
          {.least_points = 3});
  v.point("anterior_margin_mm", marks.anterior_margin_mm,
          "Anterior margin of the face, bone frame, for friedman_2d and vault_2d; the points below in the same axial "
          "slice through the middle of the glenoid");
  v.point("posterior_margin_mm", marks.posterior_margin_mm, "Posterior margin of the face, likewise");
  v.point("medial_tip_mm", marks.medial_tip_mm, "Medial tip of the scapula, for friedman_2d");
  v.point("vault_tip_mm", marks.vault_tip_mm, "Medial tip of the glenoid vault, for vault_2d");
}

void describe_glenoid(KeyVisitor& v, GlenoidSettings& glenoid) {
  v.point("near_mm", glenoid.near_mm,
          "Point within 8 mm of the face centre, bone frame. Centre and normal are detected from it, and superior "
          "unless superior or landmarks give it");
  v.point("center_mm", glenoid.center_mm, "Origin, bone frame");
  v.direction("normal", glenoid.normal, "Face normal, out of the bone (+z)");
  v.direction("superior", glenoid.superior, "Superior direction; its component perpendicular to the normal is +y");
  v.section("landmarks", glenoid.landmarks, describe_landmarks,
            "Replaces center_mm, normal and superior; with near_mm gives superior and the scapular frame");
  v.point("rim_mm", glenoid.rim_mm,
          "At least 6 points in order around the rim of the unreamed face, bone frame; they delimit the face whose "
          "orientation and area are measured. A glenoid or cup phantom has its own",
          {.least_points = 6});
  v.section("version_landmarks", glenoid.version_landmarks, describe_version_landmarks,
            "Points for further definitions of version (metrics.version in summary.json)");
  v.group({.names = {"near_mm", "center_mm"}, .one_needed = false});
  v.group({.names = {"near_mm", "normal"}, .one_needed = false});
  v.group({.names = {"landmarks", "center_mm"}, .one_needed = false});
  v.group({.names = {"landmarks", "normal"}, .one_needed = false});
  v.group({.names = {"landmarks", "superior"}, .one_needed = false});
}

void describe_wear(KeyVisitor& v, PhantomSettings& phantom) {
  const When biconcave{"walch", {"B2"}};
  v.key("medialization_mm", phantom.medialization_mm,
        "Displacement of the face centre towards the trigonum spinae by wear",
        {.range = between(0, 40), .when = {"walch", {"A1", "A2"}}, .default_by = "walch"});
  v.key("wear_radius_mm", phantom.wear_radius_mm, "Radius of the humeral head",
        {.range = between(10, 100), .when = {"walch", {"A1", "A2", "B2"}}});
  v.key("wear_direction_deg", phantom.wear_direction_deg,
        "Direction from the centre to the neoglenoid: 0 posterior, 90 inferior",
        {.range = between(0, 90), .when = biconcave});
  v.key("wear_ridge_mm", phantom.wear_ridge_mm,
        "Distance from the centre to the neoglenoid ridge along wear_direction_deg",
        {.range = between(-20, 20), .when = biconcave});
  v.key("wear_tilt_deg", phantom.wear_tilt_deg, "Angle between the axes of native face and neoglenoid",
        {.range = between(0.1, 40), .when = biconcave});
  v.key("rim_rounding_mm", phantom.rim_rounding_mm, "Rounding width of the deficient posteroinferior rim",
        {.range = between(2.4, 20), .when = {"walch", {"C"}}});
}

void describe_glenoid_phantom(KeyVisitor& v, PhantomSettings& phantom) {
  const When glenoid{"shape", {"glenoid"}};
  const auto key = [&](std::string_view name, auto& value, std::string_view doc, Range range,
                       std::string_view default_by = "") {
    v.key(name, value, doc, {.range = range, .when = glenoid, .default_by = default_by});
  };
  v.key("walch", phantom.walch,
        "Walch type; changes other defaults. none: healthy; A1, A2: minor, severe concentric wear; B2: biconcave; C: "
        "dysplastic",
        {.when = glenoid});
  v.defaults([&phantom] { apply_walch_defaults(phantom); });
  key("height_mm", phantom.height_mm, "Face height, superior to inferior", between(10, 80), "walch");
  key("width_mm", phantom.width_mm, "Face width, anterior to posterior, of the wider inferior part", between(6, 79),
      "walch");
  key("face_radius_mm", phantom.face_radius_mm, "Radius of curvature of the unworn face", between(15, 1000), "walch");
  key("vault_depth_mm", phantom.vault_depth_mm, "Vault depth, face to neck", between(5, 100));
  key("version_deg", phantom.version_deg, "Version before wear, scapular frame; retroversion positive",
      between(-45, 45), "walch");
  key("inclination_deg", phantom.inclination_deg, "Inclination before wear, scapular frame; superior tilt positive",
      between(-45, 45), "walch");
  describe_wear(v, phantom);
  key("subchondral_density_g_cm3", phantom.subchondral_density_g_cm3,
      "Subchondral plate density; default measured in one scanned shoulder", kDensity);
  key("subchondral_mm", phantom.subchondral_mm, "Subchondral plate thickness", between(0.2, 10));
  key("shell_mm", phantom.shell_mm, "Cortical thickness of the vault", between(0.2, 10));
  key("trabecular_gradient", phantom.trabecular_gradient,
      "1: trabecular density is 2 times trabecular_density_g_cm3 under the plate, 0.7 times deep in the vault; 0: "
      "uniform",
      between(0, 1));
  key("texture", phantom.texture, "Relative amplitude of trabecular texture", between(0, 1));
  key("seed", phantom.seed, "Texture seed", between(0, 2147483647));
}

void describe_phantom(KeyVisitor& v, PhantomSettings& phantom) {
  v.key("shape", phantom.shape,
        "half_space: block; cup: block with a spherical cup; layered: block, cortical on trabecular; glenoid: "
        "parametric glenoid. Origin of a block: centre of its top face, +z outwards");
  v.key("density_g_cm3", phantom.density_g_cm3, "Density",
        {.range = kDensity, .when = {"shape", {"half_space", "cup", "sphere"}}});
  v.key("size_mm", phantom.size_mm, "Block size",
        {.range = between(0.5, 1000), .when = {"shape", {"half_space", "cup", "layered"}}});
  v.key("radius_mm", phantom.radius_mm, "Radius of sphere or cup",
        {.range = between(0.5, 500), .when = {"shape", {"sphere", "cup"}}});
  v.key("cup_depth_mm", phantom.cup_depth_mm, "Cup depth", {.range = between(0.01, 500), .when = {"shape", {"cup"}}});
  v.key("cortical_mm", phantom.cortical_mm, "Top layer thickness",
        {.range = between(0.01, 500), .when = {"shape", {"layered"}}});
  v.key("cortical_density_g_cm3", phantom.cortical_density_g_cm3,
        "Density of the top layer, or of the cortical wall of a glenoid",
        {.range = kDensity, .when = {"shape", {"layered", "glenoid"}}});
  v.key("trabecular_density_g_cm3", phantom.trabecular_density_g_cm3,
        "Density of the interior; see trabecular_gradient",
        {.range = kDensity, .when = {"shape", {"layered", "glenoid"}}});
  describe_glenoid_phantom(v, phantom);
}

void describe_mesh(KeyVisitor& v, MeshBoneSettings& mesh) {
  v.key("path", mesh.path, "STL, OBJ, PLY or VTP", {.required = true, .text = TextKind::input_file});
  v.key("scale", mesh.scale, "mm per file unit", kFileUnit);
  v.key("frame", mesh.frame,
        "Frame of the coordinates in the file; the bone frame is LPS. file: as its header says (`SPACE=RAS`), else "
        "lps; ras: x and y are negated; lps: unchanged");
  v.key("cortical_mm", mesh.cortical_mm, "Cortical shell thickness", between(0, 50));
  v.key("cortical_hu", mesh.cortical_hu, "HU of the shell", kHu);
  v.key("trabecular_hu", mesh.trabecular_hu, "HU of the interior", kHu);
  v.key("repair", mesh.repair,
        "Close holes and orient triangles consistently; changes are reported. Small holes need no repair");
  v.key("repair_change_percent", mesh.repair_change_percent, "Largest volume change by a repair, percent",
        between(0, 1000));
}

void describe_vdb(KeyVisitor& v, VdbBoneSettings& vdb) {
  v.key("path", vdb.path, "A reamed.vdb or file of `reamsim import`", {.required = true, .text = TextKind::input_file});
}

void describe_pilot_hole(KeyVisitor& v, PilotHoleSettings& hole) {
  v.key("diameter_mm", hole.diameter_mm, "Hole diameter", between(0.01, 30));
  v.point("entry_mm", hole.entry_mm, "Start of the hole axis");
  v.direction("axis", hole.axis, "Drilling direction");
  v.key("depth_mm", hole.depth_mm, "Depth from entry_mm", between(0.01, 500));
  v.key("frame", hole.frame, "Frame of entry_mm and axis");
}

void describe_label_map(KeyVisitor& v, LabelMapSettings& labels) {
  v.key("path", labels.path, "NRRD (.seg.nrrd of 3D Slicer, layers included), NIfTI or MetaImage, on any grid",
        {.required = true, .text = TextKind::input_file});
  v.key("label", labels.label,
        "Label number or segment name (a-z: case-insensitive) of the bone; several form one bone");
  v.key("refine_mm", labels.refine_mm,
        "Largest displacement of the mask surface to the isosurface of refine_hu; 0: none", between(0, 5));
  v.key("refine_hu", labels.refine_hu, "Isosurface for refine_mm; denser bone without a label causes a warning", kHu);
  v.key("fill", labels.fill,
        "Add unlabelled bone of at least refine_hu that the label surrounds or that lies in its holes up to 10 mm "
        "wide, and enclosed cavities");
}

void describe_hu(KeyVisitor& v, HuSettings& hu) {
  v.key("slope", hu.slope, "HU per unit", between(0.001, 1000));
  v.key("intercept", hu.intercept, "HU of value 0", between(-70000, 70000));
}

void describe_cut_sphere(KeyVisitor& v, CutSphereSettings& sphere) {
  v.point("center_mm", sphere.center_mm, "LPS", {.required = true});
  v.key("radius_mm", sphere.radius_mm, "Bone inside is removed", required(between(0.01, 500)));
}

void describe_cut_plane(KeyVisitor& v, CutPlaneSettings& plane) {
  v.point("point_mm", plane.point_mm, "Point on the plane, LPS", {.required = true});
  v.direction("normal", plane.normal, "Points to the side that is removed", {.required = true});
}

constexpr std::string_view kLabels = "label_map";

/// What a label map replaces.
void describe_segmentation(KeyVisitor& v, CtSettings& ct) {
  v.key("threshold_hu", ct.threshold_hu, "Least HU of bone", {.range = kHu, .unless = kLabels});
  v.key("closing_mm", ct.closing_mm, "Closing radius, to bridge cortical gaps; 0: none",
        {.range = between(0, 20), .unless = kLabels});
  v.key("fill_holes", ct.fill_holes, "Fill the cortex interior, to keep trabecular bone below the threshold",
        {.unless = kLabels});
  v.point("seed_mm", ct.seed_mm, "Point in the connected piece to keep, LPS; default: the largest piece",
          {.unless = kLabels});
  v.key("separate", ct.separate,
        "humerus: fit a sphere to the humeral head next to the glenoid (bone.glenoid.near_mm, center_mm or landmarks) "
        "and cut along the joint gap. Without seed_mm the piece behind the gap is kept",
        {.unless = kLabels});
  v.list("cut_spheres", ct.cut_spheres, describe_cut_sphere, "Spheres that remove neighbouring bone",
         {.unless = kLabels});
  v.list("cut_planes", ct.cut_planes, describe_cut_plane, "Planes that remove neighbouring bone", {.unless = kLabels});
}

void describe_ct(KeyVisitor& v, CtSettings& ct) {
  v.key("path", ct.path, "DICOM folder (searched recursively), DICOMDIR, NRRD, NIfTI or MetaImage",
        {.required = true, .text = TextKind::input_path});
  v.section("hu", ct.hu, describe_hu,
            "HU = slope·value + intercept, for scans not in HU; value: after the file's own scaling");
  v.key("series", ct.series,
        "DICOM series: UID, or number in the list of the warning; default: the CT series with most slices. SERIES/2 or "
        "SERIES#AcquisitionNumber=1 selects one of several volumes",
        {.number_too = true});
  v.key("modality", ct.modality, "Accepted DICOM modality; any: also non-CT");
  v.key("uneven", ct.uneven,
        "Unevenly spaced or missing DICOM slices; resample: interpolate at the finest spacing, with a warning");
  v.key("crop_min_mm", ct.crop_min_mm, "Lower crop corner, LPS; needs crop_max_mm",
        {.range = between(-10000, 9990), .point = true});
  v.key("crop_max_mm", ct.crop_max_mm, "Upper crop corner, LPS; needs crop_min_mm",
        {.range = between(-9990, 10000), .point = true});
  v.key("filter", ct.filter, "Noise filter before thresholding");
  v.key("median_radius_voxels", ct.median_radius_voxels, "For `filter: median`", between(1, 10));
  v.key("anisotropic_iterations", ct.anisotropic_iterations, "For `filter: curvature_anisotropic`", between(1, 100));
  v.key("anisotropic_conductance", ct.anisotropic_conductance, "For `filter: curvature_anisotropic`",
        between(0.01, 100));
  v.section(kLabels, ct.label_map, describe_label_map, "Replaces threshold, closing, filling, seed and cuts");
  v.key("psf_mm", ct.psf_mm,
        "Full width of the scanner's point spread function (PSF); 0: the voxel spacing per axis, for an oblique scan "
        "1.25 times the voxel extent along each LPS axis",
        between(0, 10));
  describe_segmentation(v, ct);
}

}  // namespace

void describe_density(KeyVisitor& v, DensitySettings& density) {
  v.key("ash_slope_g_cm3_per_hu", density.ash_slope_g_cm3_per_hu,
        "Ash density = slope·HU + offset. Measured on a femur at 120 kVp (PMC5234499, Table 1), not on a scapula",
        between(1e-6, 0.1));
  v.key("ash_offset_g_cm3", density.ash_offset_g_cm3, "See ash_slope_g_cm3_per_hu", between(-2, 2));
  v.key("ash_fraction", density.ash_fraction, "Ash density / apparent density", between(0.05, 1));
}

void describe_bone(KeyVisitor& v, BoneSettings& bone) {
  v.key("source", bone.source, "Source of the bone", {.required = true});
  v.key("side", bone.side,
        "Side of the body; required with bone.glenoid, a glenoid phantom or any `frame: glenoid`. Default: that of the "
        "VDB");
  v.key("voxel_mm", bone.voxel_mm, "Voxel edge length; a VDB keeps its own",
        between(BoneSettings::kLeastVoxel_mm, BoneSettings::kMostVoxel_mm));
  v.key("cache", bone.cache, "Keep the loaded bone on disk, encrypted, for the next command");
  v.key("surface_voxels", bone.surface_voxels,
        "Fill of surface voxels. partial: the fraction that is bone; whole: bone or air, by the voxel centre; auto: "
        "partial for `cutting.erosion: exact`, else whole. A VDB keeps its own");
  v.section("density", bone.density, describe_density, "Density from HU");
  v.section("glenoid", bone.glenoid, describe_glenoid,
            "Glenoid frame (near_mm; or center_mm, normal and superior; or landmarks) and rim. Default frame: that of "
            "the phantom or VDB");
  v.section("phantom", bone.phantom, describe_phantom, "Generated bone", {.when = {"source", {"phantom"}}});
  v.section("ct", bone.ct, describe_ct, "CT scan", {.required = true, .when = {"source", {"ct"}}});
  v.section("mesh", bone.mesh, describe_mesh, "Closed surface", {.required = true, .when = {"source", {"mesh"}}});
  v.section("vdb", bone.vdb, describe_vdb, "Bone of an earlier run or import",
            {.required = true, .when = {"source", {"vdb"}}});
  v.section("pilot_hole", bone.pilot_hole, describe_pilot_hole, "Hole drilled before the run");
}

}  // namespace reamsim

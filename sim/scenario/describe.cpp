// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"

namespace reamsim {

namespace {

constexpr Range kChip = between(1e-5, 10);  // mm

void describe_cutting_edges(KeyVisitor& v, int& count) {
  v.key("cutting_edges", count, "Number of cutting edges", required(between(1, 1000)));
}

void describe_specific_energy(KeyVisitor& v, SpecificEnergySettings& point) {
  v.key("density_g_cm3", point.density_g_cm3, "Apparent density", required(between(0, 2)));
  v.key("energy_j_mm3", point.energy_j_mm3, "Specific cutting energy", required(between(0, 10)));
}

void describe_size_effect(KeyVisitor& v, SizeEffectSettings& size) {
  v.key("exponent", size.exponent, "1: force independent of chip thickness", required(between(0.001, 1)));
  v.key("reference_mm", size.reference_mm, "Chip thickness at which specific energy was measured", required(kChip));
  describe_cutting_edges(v, size.cutting_edges);
  v.key("least_mm", size.least_mm, "Lower limit of chip thickness", kChip);
  v.key("most_mm", size.most_mm, "Upper limit of chip thickness", kChip);
}

void describe_edge_force(KeyVisitor& v, EdgeForceSettings& edge) {
  v.key("tangential_n_mm", edge.tangential_n_mm, "Force against the motion, per edge length",
        required(between(1e-6, 1000)));
  v.key("normal_n_mm", edge.normal_n_mm, "Normal force out of the bone, per edge length", required(between(0, 1000)));
  describe_cutting_edges(v, edge.cutting_edges);
}

/// Energy per volume by density: a table, a preset or a power law.
void describe_specific_energies(KeyVisitor& v, CuttingSettings& cutting) {
  constexpr std::string_view kTable = "specific_energy_table";
  v.list(kTable, cutting.specific_energy_table, describe_specific_energy,
         "Specific cutting energy by density, replaces the power law: two or more points in ascending density, "
         "interpolated linearly, constant beyond the ends");
  v.key("preset", cutting.preset,
        "Constants of the law: assumed ones, which do not bound the result, or those fitted to the forces of a drill, "
        "with its edge_force. Given keys take precedence",
        {.unless = kTable});
  v.key("specific_energy_j_mm3", cutting.specific_energy_j_mm3,
        "Specific cutting energy u0 at the reference density. Uncalibrated; assumed 0.05 to 0.30, more for thin chips",
        {.range = between(1e-6, 10), .unless = kTable});
  v.key("reference_density_g_cm3", cutting.reference_density_g_cm3, "Density of specific_energy_j_mm3",
        {.range = kDensity, .unless = kTable});
  v.key("density_exponent", cutting.density_exponent, "p in u = u0·(density/reference density)^p; assumed 1 to 2.5",
        {.range = between(0, 5), .unless = kTable});
}

/// Options of the energetic law.
void describe_options(KeyVisitor& v, CuttingSettings& cutting) {
  v.key("normal_ratio", cutting.normal_ratio, "Normal force / tangential force (k_n)", between(0, 10));
  v.key("friction_fraction", cutting.friction_fraction,
        "Friction fraction of the tangential force; changes no force, only energies in summary.json",
        {.range = between(0, 1), .when = {"law", {"energy"}}});
  v.group({.names = {"size_effect", "edge_force"}, .one_needed = false});
  v.section(
      "size_effect", cutting.size_effect, describe_size_effect,
      "Higher specific energy of thin chips: u·(reference/h)^exponent, h: uncut chip thickness. Not with `edge_force`",
      {.when = {"law", {"energy"}}});
  v.section("edge_force", cutting.edge_force, describe_edge_force,
            "Force per length of cutting edge in contact, cutting or not. Needs `law: energy`; not with `size_effect` "
            "or `tool.spin: resolved`",
            {.when = {"erosion", {"exact"}}});
}

void describe_augment(KeyVisitor& v, AugmentSettings& augment) {
  v.key("shape", augment.shape, "wedge: inclined back; step: back parallel to the plain one");
  v.key("angle_deg", augment.angle_deg,
        "Wedge angle: the back is the lower of plain back and its copy rotated by this angle",
        {.required = true, .range = between(0.1, 60), .when = {"shape", {"wedge"}}});
  v.key("step_mm", augment.step_mm, "Height of the step",
        {.required = true, .range = between(0.1, 50), .when = {"shape", {"step"}}});
  v.direction("direction", augment.direction, "Direction of increasing thickness, implant frame; z is ignored");
  v.key("start_mm", augment.start_mm,
        "Start of the augment, along `direction` from the implant axis; 0: half wedge; minus half the footprint "
        "width: full wedge",
        between(-100, 100));
}

void describe_peg(KeyVisitor& v, PegSettings& peg) {
  v.key("from_mm", peg.from_mm, "One end of the peg axis, implant frame", required(between(-200, 200)));
  v.key("to_mm", peg.to_mm, "Other end", required(between(-200, 200)));
  v.key("diameter_mm", peg.diameter_mm, "Peg diameter; the ends are hemispheres about from_mm and to_mm",
        required(between(0.1, 50)));
}

void describe_implant_mesh(KeyVisitor& v, ImplantMeshSettings& mesh) {
  v.key("path", mesh.path, "STL, OBJ, PLY or VTP in the implant frame; closed",
        {.required = true, .text = TextKind::input_file});
  v.key("scale", mesh.scale, "mm per file unit", kFileUnit);
  v.key("pegs_below_mm", mesh.pegs_below_mm,
        "What lies further below the plain back (backside_radius_mm) is peg; more than the height of an augment",
        between(0.1, 50));
}

void describe_implant(KeyVisitor& v, ImplantSettings& implant) {
  v.key("backside_radius_mm", implant.backside_radius_mm, "Radius of the spherical back; 0: flat",
        required(between(0, 500)));
  constexpr std::string_view kMesh = "mesh";
  v.section(kMesh, implant.mesh, describe_implant_mesh, "Implant with its pegs from a mesh file");
  v.key("diameter_mm", implant.diameter_mm,
        "Diameter of a round footprint about the axis; 0 without width_mm: the reamed face",
        {.range = between(0, 200), .unless = kMesh});
  v.key("gap_mm", implant.gap_mm, "Largest gap that counts as seated", between(0.001, 10));
  v.key("width_mm", implant.width_mm, "Footprint width along implant x; needs height_mm; 0: see diameter_mm",
        {.range = between(0, 200), .unless = kMesh});
  v.key("height_mm", implant.height_mm, "Footprint height along implant y",
        {.range = between(0, 200), .unless = kMesh});
  v.key("footprint", implant.footprint,
        "Footprint shape with width_mm and height_mm. pear: two circles and their common tangents, the inferior of "
        "full width, the superior of 3/4 of it",
        {.unless = kMesh});
  v.key("frame", implant.frame, "Frame of center_mm, axis and superior. reamer: the tool frame at its deepest pose");
  v.point("center_mm", implant.center_mm, "Apex of the back; `seat` ignores its position along the axis");
  v.direction("axis", implant.axis, "Implant axis, out of the bone");
  v.direction("superior", implant.superior, "Superior direction; default: that of the glenoid, else +y of the frame");
  v.key("seat", implant.seat, "Translate the implant along its axis until seated; false: it stays at center_mm");
  v.key("thickness_mm", implant.thickness_mm, "Axial distance from back to articular surface, for the joint line",
        between(0, 50));
  v.key("support_depth_mm", implant.support_depth_mm,
        "Depth below the implant over which the dense bone fraction is measured", between(0.1, 50));
  v.key("vault_depth_mm", implant.vault_depth_mm,
        "Depth below the unreamed surface over which remaining bone is measured", between(0.1, 200));
  v.section("augment", implant.augment, describe_augment, "Wedge or step on the back", {.unless = kMesh});
  v.list("pegs", implant.pegs, describe_peg, "Pegs and keels: capsules", {.unless = kMesh});
}

void describe_metrics(KeyVisitor& v, MetricSettings& metrics) {
  v.key("dense_g_cm3", metrics.dense_g_cm3,
        "Least density of dense bone (subchondral plate and cortex); below it: trabecular", kDensity);
  v.section("implant", metrics.implant, describe_implant, "Glenoid implant whose fit is measured");
}

void describe_user_camera(KeyVisitor& v, UserCamera& camera) {
  v.key("name", camera.name, "File suffix: lower-case letters, digits, _ and -", {.required = true});
  v.key("frame", camera.frame, "Frame of position_mm, target_mm and up");
  v.point("position_mm", camera.position_mm, "Camera position", {.required = true});
  v.point("target_mm", camera.target_mm, "Centre of the view; default: the glenoid centre, or the reamed region");
  v.direction("up", camera.up, "Upward direction; default: superior");
  v.key("projection", camera.projection,
        "perspective: the scale bar holds at the target distance only; orthographic: everywhere");
  v.key("fov_deg", camera.fov_deg, "Vertical field of view",
        {.range = between(1, 120), .when = {"projection", {"perspective"}}});
  v.key("width_mm", camera.width_mm, "View width without the label column",
        {.range = between(0.1, 10000), .when = {"projection", {"orthographic"}}});
}

}  // namespace

void describe_engine(KeyVisitor& v, EngineSettings& engine) {
  v.key("type", engine.type,
        "auto: exact for `cutting.erosion: exact`, else bricked. exact: voxels of sparse bricks clipped by the tool "
        "surface. bricked: cells of shell points in sparse bricks. For comparison, on dense voxel arrays: direct, "
        "voxel lookup per shell point (Faieghi et al.); octree, grid descent per shell point (Zheng et al.); implicit, "
        "envelope of revolution per voxel (Yau et al.)");
  v.key("device", engine.device,
        "auto: the OpenCL device that `reamsim devices` marks; serial: C++ reference without OpenCL (slow); other "
        "text: part of PLATFORM: NAME of an OpenCL device; #2 at its end takes the second that matches");
  v.key("batch_frames", engine.batch_frames, "Frames per readback of results; affects speed only", between(1, 10000));
  v.key("max_step_voxels", engine.max_step_voxels,
        "Longest motion of any tool point per substep, voxels; above 0.5 bone may remain between steps",
        between(0.001, 10));
}

void describe_cutting(KeyVisitor& v, CuttingSettings& cutting) {
  v.key("law", cutting.law,
        "energy: force from the specific cutting energy of the removed volume; per_point: force_per_point_n per shell "
        "point in contact, as in the paper");
  v.defaults([&cutting] {
    if (cutting.law == CuttingLaw::per_point) cutting.erosion = ErosionMode::remove;
  });
  v.key("erosion", cutting.erosion,
        "exact: voxels keep their fraction outside the tool (needs engine.type auto or exact, and `law: energy`); "
        "remove: touched voxels are removed, the default where exact is impossible; wear: touched voxels lose density "
        "at a constant rate",
        {.default_by = "engine.type"});
  describe_specific_energies(v, cutting);
  describe_options(v, cutting);
  v.key("speed_floor_mm_s", cutting.speed_floor_mm_s,
        "Lower limit of the cutting speed in the force law; keeps the force finite", between(0.001, 10000));
  v.key("force_per_point_n", cutting.force_per_point_n, "Force per shell point in contact, for `law: per_point`",
        between(0, 1000));
  v.key("wear_g_cm3_per_s", cutting.wear_g_cm3_per_s, "Density loss rate of touched voxels, for `erosion: wear`",
        between(0.001, 1e6));
}

void describe_render(KeyVisitor& v, RenderSettings& render) {
  v.key("enabled", render.enabled, "Render pictures");
  v.key("context", render.context, "Off-screen OpenGL context. auto: OSMesa, else EGL");
  v.key("width_px", render.width_px, "Picture width", between(64, 16384));
  v.key("height_px", render.height_px, "Picture height", between(64, 16384));
  v.key("frame_height_px", render.frame_height_px,
        "Height of the pictures along the run, in the proportions of the others; at most height_px. The contact sheet "
        "shows them reduced",
        between(64, 16384));
  v.key("every_frames", render.every_frames,
        "Frames between pictures; 0: eight pictures, six of them during expected contact (eleven and nine where "
        "several passes touch bone), and 150 for a film",
        between(0, 1e9));
  v.key("cameras", render.cameras, "Views, each at most once; files of the first have no suffix");
  v.list("user_cameras", render.user_cameras, describe_user_camera, "User cameras; their files end in _NAME");
  v.key("before_after", render.before_after, "Render before_after.png per camera: bone before and after, side by side");
  v.key("contact_sheet", render.contact_sheet,
        "Render contact_sheet.png: up to sixteen small pictures of the contact phase");
  v.key("turntable_pictures", render.turntable_pictures,
        "Turntable pictures (turntable/NNN.png), 360° about the superior axis; 0: none", between(0, 3600));
  v.key("film", render.film,
        "Film of the first camera with force and torque curves, and of the turntable. Needs ffmpeg");
  v.key("film_rate_hz", render.film_rate_hz, "Film frame rate", between(1, 120));
  v.key("tool", render.tool, "Draw the reamer");
  v.key("tool_look", render.tool_material,
        "Reamer material: transparent or brushed steel; cut surfaces are always steel");
  v.key("force_arrow", render.force_arrow,
        "Draw the force of the bone on the reamer as an arrow with its magnitude, in pictures along the run");
  v.key("background", render.background,
        "Background. Films, contact sheet and report use white instead of transparent; labels have a white ground");
  v.direction("light", render.light, "Main light direction: right, up, towards the viewer");
  v.key("supersampling", render.supersampling, "Supersampling factor per axis; time and memory grow with its square",
        between(1, 4));
  v.key("report", render.report, "Write report.html: the run on one page");
  v.key("depth_max_mm", render.depth_max_mm, "End of the depth legend; 0: just above the predicted depth",
        between(0, 200));
}

void describe_output(KeyVisitor& v, OutputSettings& output) {
  v.key("dir", output.dir, "Results folder; \"\": out/NAME below the working directory. `-o` takes precedence",
        {.text = TextKind::output_folder});
  v.key("vti", output.vti, "Write reamed.vti beside reamed.vdb");
  v.key("segmentation", output.segmentation, "Write reamed.seg.nrrd, a segmentation for 3D Slicer; not of a phantom");
  v.key("meshes", output.meshes, "Write the reamed surface as reamed.glb and reamed.stl");
  v.key("plots", output.plots, "Plot forces, depth and energy; `reamsim render DIR --only plots` does it later");
  v.key("force_basis", output.force_basis,
        "Write force_basis.npy, from which `reamsim reforce` and `reamsim fit` compute forces for other constants. "
        "Needs `law: energy`, and erosion exact, or remove with engine.type bricked or engine.device serial");
  v.key("checkpoint_s", output.checkpoint_s, "Wall time between checkpoints for `run --resume`; 0: none",
        between(0, 86400));
}

void describe_scenario(KeyVisitor& v, Scenario& scenario) {
  v.key("version", scenario.version, "Scenario format", required(between(kScenarioVersion, kScenarioVersion)));
  v.key("name", scenario.name, "Name of the run; default: the file name without extension");
  v.section("bone", scenario.bone, describe_bone, "The bone to be reamed", {.required = true});
  v.section("tool", scenario.tool, describe_tool, "The reamer", {.required = true});
  v.section("clearance", scenario.clearance, describe_clearance, "Clearance of tool.holder along the motion");
  v.section("motion", scenario.motion, describe_motion, "Motion of the reamer", {.required = true});
  v.section("engine", scenario.engine, describe_engine, "Engine and device");
  v.defaults([&scenario] {
    const EngineKind engine = scenario.engine.type;
    if (engine != EngineKind::automatic && engine != EngineKind::exact) scenario.cutting.erosion = ErosionMode::remove;
  });
  v.section("cutting", scenario.cutting, describe_cutting, "Erosion and cutting-force model");
  v.section("metrics", scenario.metrics, describe_metrics, "Metrics of the reamed bone in summary.json");
  v.section("render", scenario.render, describe_render, "Pictures");
  v.section("output", scenario.output, describe_output, "Results folder and files");
}

}  // namespace reamsim

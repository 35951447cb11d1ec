// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"

namespace reamsim {

namespace {

constexpr Range kChip = between(1e-5, 10);  // mm

void describe_cutting_edges(KeyVisitor& v, int& count) {
  v.key("cutting_edges", count, "Number of cutting edges", {.required = true, .range = between(1, 1000)});
}

void describe_specific_energy(KeyVisitor& v, SpecificEnergySettings& point) {
  v.key("density_g_cm3", point.density_g_cm3, "Apparent density", {.required = true, .range = between(0, 2)});
  v.key("energy_j_mm3", point.energy_j_mm3, "Energy to cut 1 mm³ of bone of that density",
        {.required = true, .range = between(0, 10)});
}

void describe_size_effect(KeyVisitor& v, SizeEffectSettings& size) {
  v.key("exponent", size.exponent, "m in u·(reference/h)^m; 1: the force is independent of the chip thickness",
        {.required = true, .range = between(0.001, 1)});
  v.key("reference_mm", size.reference_mm, "Chip thickness at which the specific energy was measured",
        {.required = true, .range = kChip});
  describe_cutting_edges(v, size.cutting_edges);
  v.key("least_mm", size.least_mm, "Lower limit of the chip thickness", kChip);
  v.key("most_mm", size.most_mm, "Upper limit of the chip thickness", kChip);
}

void describe_edge_force(KeyVisitor& v, EdgeForceSettings& edge) {
  v.key("tangential_n_mm", edge.tangential_n_mm, "Force against the motion per length of cutting edge in contact",
        {.required = true, .range = between(1e-6, 1000)});
  v.key("normal_n_mm", edge.normal_n_mm,
        "Normal force per length of cutting edge in contact; it pushes the tool out of the bone",
        {.required = true, .range = between(0, 1000)});
  describe_cutting_edges(v, edge.cutting_edges);
}

/// Energy per volume by density: a table, a preset or a power law.
void describe_specific_energies(KeyVisitor& v, CuttingSettings& cutting) {
  constexpr std::string_view kTable = "specific_energy_table";
  v.list(kTable, cutting.specific_energy_table, describe_specific_energy,
         "Specific cutting energy over density instead of the power law: two or more points in ascending density, "
         "interpolated linearly, constant beyond the ends");
  v.key(
      "preset", cutting.preset,
      "Sets specific_energy_j_mm3, reference_density_g_cm3 and density_exponent to the low end, the middle or the high "
      "end of the ranges that this project assumes; they do not bound the result. A key that is given takes precedence",
      {.unless = kTable});
  v.key("specific_energy_j_mm3", cutting.specific_energy_j_mm3,
        "Specific cutting energy at the reference density (u0). Uncalibrated; 0.05 to 0.30 is assumed, thin chips need "
        "more",
        {.range = between(1e-6, 10), .unless = kTable});
  v.key("reference_density_g_cm3", cutting.reference_density_g_cm3,
        "Density at which the specific cutting energy is specific_energy_j_mm3", {.range = kDensity, .unless = kTable});
  v.key("density_exponent", cutting.density_exponent, "p in u = u0·(density/reference density)^p; 1 to 2.5 is assumed",
        {.range = between(0, 5), .unless = kTable});
}

/// Options of the energetic law.
void describe_options(KeyVisitor& v, CuttingSettings& cutting) {
  v.key("normal_ratio", cutting.normal_ratio, "Normal force as a multiple of the tangential force (k_n)",
        between(0, 10));
  v.key("friction_fraction", cutting.friction_fraction,
        "Fraction of the tangential force that is friction. It changes no force; summary.json states its energy",
        {.range = between(0, 1), .when = {"law", {"energy"}}});
  v.group({.names = {"size_effect", "edge_force"}, .one_needed = false});
  v.section("size_effect", cutting.size_effect, describe_size_effect,
            "Thin chips need more energy per volume: u·(reference/h)^exponent, where h is the uncut chip thickness. "
            "Not with `edge_force`",
            {.when = {"law", {"energy"}}});
  v.section("edge_force", cutting.edge_force, describe_edge_force,
            "Force per length of cutting edge in contact, cutting or not. Needs `law: energy`; not with `size_effect`, "
            "nor with tool.spin: resolved",
            {.when = {"erosion", {"exact"}}});
}

void describe_augment(KeyVisitor& v, AugmentSettings& augment) {
  v.key("angle_deg", augment.angle_deg,
        "Angle of the wedge: the back is the lower of the plain back and its copy rotated by this angle",
        {.required = true, .range = between(0.1, 60)});
  v.direction("direction", augment.direction,
              "Direction in which the implant becomes thicker, in the frame of the implant; z is ignored");
  v.key("start_mm", augment.start_mm,
        "Place of the line at which the wedge begins, along `direction` from the axis of the implant; 0: half wedge; "
        "minus the half width of the footprint: full wedge",
        between(-100, 100));
}

void describe_peg(KeyVisitor& v, PegSettings& peg) {
  v.key("from_mm", peg.from_mm, "One end of the axis of the peg, in the frame of the implant",
        {.required = true, .range = between(-200, 200)});
  v.key("to_mm", peg.to_mm, "The other end", {.required = true, .range = between(-200, 200)});
  v.key("diameter_mm", peg.diameter_mm, "Diameter of the peg; its ends are hemispheres around from_mm and to_mm",
        {.required = true, .range = between(0.1, 50)});
}

void describe_implant(KeyVisitor& v, ImplantSettings& implant) {
  v.key("backside_radius_mm", implant.backside_radius_mm, "Radius of the spherical back of the implant; 0: flat",
        {.required = true, .range = between(0, 500)});
  v.key("diameter_mm", implant.diameter_mm,
        "Diameter of a round footprint around the axis of the implant; with 0 and no width_mm the footprint is the "
        "reamed face",
        between(0, 200));
  v.key("gap_mm", implant.gap_mm, "Largest gap that counts as seated", between(0.001, 10));
  v.key("width_mm", implant.width_mm,
        "Width of the footprint, along x of the implant; needs height_mm; 0: see diameter_mm", between(0, 200));
  v.key("height_mm", implant.height_mm, "Height of the footprint, along y of the implant", between(0, 200));
  v.key("footprint", implant.footprint,
        "Shape of a footprint with width_mm and height_mm. pear: two circles and their common tangents, the inferior "
        "circle of the full width, the superior one of three quarters of it");
  v.key("frame", implant.frame, "Frame of center_mm, axis and superior. reamer: the tool frame at its deepest pose");
  v.point("center_mm", implant.center_mm,
          "Apex of the back of the implant; with `seat` only its place across the axis counts");
  v.direction("axis", implant.axis,
              "Axis of the implant, out of the bone: another axis than that of the reamer tilts the implant");
  v.direction("superior", implant.superior,
              "Superior direction of the implant; without it that of the glenoid, or else +y of the frame");
  v.key("seat", implant.seat,
        "Translate the implant along its axis until it rests on the bone; false: it stays at center_mm");
  v.key("thickness_mm", implant.thickness_mm,
        "Distance from back to articular surface along the axis, for the joint line", between(0, 50));
  v.key("support_depth_mm", implant.support_depth_mm,
        "Thickness of the layer of bone under the implant whose fraction of dense bone is measured", between(0.1, 50));
  v.key("vault_depth_mm", implant.vault_depth_mm,
        "Depth of the vault below the unreamed surface, over which the remaining bone is measured", between(0.1, 200));
  v.section("augment", implant.augment, describe_augment, "Wedge on the back of the implant");
  v.list("pegs", implant.pegs, describe_peg, "Pegs and keels; each is a capsule in the frame of the implant");
}

void describe_metrics(KeyVisitor& v, MetricSettings& metrics) {
  v.key("dense_g_cm3", metrics.dense_g_cm3,
        "Least density of dense bone (subchondral plate and cortex); bone below it is trabecular", kDensity);
  v.section("implant", metrics.implant, describe_implant, "Glenoid implant whose fit in the reamed bone is measured");
}

void describe_user_camera(KeyVisitor& v, UserCamera& camera) {
  v.key("name", camera.name, "Lower-case letters, digits, _ and -; suffix of its file names", {.required = true});
  v.key("frame", camera.frame, "Frame of position_mm, target_mm and up");
  v.point("position_mm", camera.position_mm, "Position of the camera", {.required = true});
  v.point("target_mm", camera.target_mm,
          "Point in the centre of the view; without it the centre of the glenoid, or the reamed region");
  v.direction("up", camera.up, "Upward direction of the picture; without it superior");
  v.key("projection", camera.projection,
        "perspective: the scale bar holds at the distance of the target only; orthographic: all lengths are to scale");
  v.key("fov_deg", camera.fov_deg, "Vertical field of view",
        {.range = between(1, 120), .when = {"projection", {"perspective"}}});
  v.key("width_mm", camera.width_mm, "Width of the view, without the column of labels",
        {.range = between(0.1, 10000), .when = {"projection", {"orthographic"}}});
}

}  // namespace

void describe_engine(KeyVisitor& v, EngineSettings& engine) {
  v.key("type", engine.type,
        "auto: exact where cutting.erosion is exact, else bricked. exact: clips the voxels of sparse bricks against "
        "the surface of the tool. bricked: cells of shell points against sparse bricks. Comparison systems on dense "
        "voxel arrays: direct, one work-item per shell point looks up its voxel (Faieghi et al.); octree, one "
        "work-item per shell point descends the grid (Zheng et al.); implicit, one work-item per voxel against the "
        "envelope of revolution (Yau et al.)");
  v.key("device", engine.device,
        "auto: the OpenCL device that `reamsim devices` marks; serial: the reference in plain C++, without OpenCL "
        "(slow); any other text: part of the name of an OpenCL device");
  v.key("batch_frames", engine.batch_frames,
        "Number of frames whose results are read back at once. It affects speed only", between(1, 10000));
  v.key("max_step_voxels", engine.max_step_voxels,
        "Longest motion of any point of the tool in one substep, voxels; above 0.5 bone may survive between steps",
        between(0.001, 10));
}

void describe_cutting(KeyVisitor& v, CuttingSettings& cutting) {
  v.key("law", cutting.law,
        "energy: force from the specific cutting energy of the removed volume; per_point: a given force per shell "
        "point in contact, as in the paper");
  v.defaults([&cutting] {
    if (cutting.law == CuttingLaw::per_point) cutting.erosion = ErosionMode::remove;
  });
  v.key("erosion", cutting.erosion,
        "exact: a voxel keeps the part of it that lies outside the tool (needs engine.type: auto or exact, and law: "
        "energy); remove: a touched voxel is removed as a whole, the default where exact is not possible; wear: it "
        "loses density at a constant rate",
        {.default_by = "engine.type"});
  describe_specific_energies(v, cutting);
  describe_options(v, cutting);
  v.key("speed_floor_mm_s", cutting.speed_floor_mm_s,
        "Lower limit of the cutting speed in the force law; it keeps the force finite where the tool hardly moves",
        between(0.001, 10000));
  v.key("force_per_point_n", cutting.force_per_point_n,
        "Force of one shell point in contact; used by `law: per_point` only", between(0, 1000));
  v.key("wear_g_cm3_per_s", cutting.wear_g_cm3_per_s,
        "Density that a touched voxel loses per second; used by `erosion: wear` only", between(0.001, 1e6));
}

void describe_render(KeyVisitor& v, RenderSettings& render) {
  v.key("enabled", render.enabled, "Render pictures");
  v.key("context", render.context, "Off-screen OpenGL context. auto: OSMesa, or EGL where this system has no OSMesa");
  v.key("width_px", render.width_px, "Width of the pictures", between(64, 16384));
  v.key("height_px", render.height_px, "Height of the pictures", between(64, 16384));
  v.key("every_frames", render.every_frames,
        "Number of frames between pictures; 0: eleven pictures, nine of them over the expected time of contact, and "
        "150 along the run for a film",
        between(0, 1e9));
  v.key("cameras", render.cameras, "Views, each at most once; the files of the first have no suffix");
  v.list("user_cameras", render.user_cameras, describe_user_camera, "User cameras; their files end in _NAME");
  v.key("before_after", render.before_after,
        "Render before_after.png for every camera: the bone before and after, side by side");
  v.key("contact_sheet", render.contact_sheet,
        "Render contact_sheet.png: the time of contact in up to twenty small pictures");
  v.key("turntable_pictures", render.turntable_pictures,
        "Number of turntable pictures (turntable/NNN.png), 360° about the superior axis; 0: none", between(0, 3600));
  v.key("film", render.film,
        "Make a film of the pictures of the first camera, with the curves of force and torque beside them, and a film "
        "of the turntable. Needs ffmpeg");
  v.key("film_rate_hz", render.film_rate_hz, "Frame rate of the film, pictures per second", between(1, 120));
  v.key("tool", render.tool, "Draw the reamer");
  v.key("tool_look", render.tool_material,
        "Material of the reamer: transparent or brushed steel; a cut surface is always steel");
  v.key("force_arrow", render.force_arrow,
        "Draw the force of the bone on the reamer as an arrow with its magnitude, in pictures along the run");
  v.key("background", render.background,
        "Background of the pictures. Films, contact sheet and report use white instead of transparent, and labels have "
        "a white ground");
  v.direction("light", render.light, "Direction of the main light in the picture: right, up, towards the viewer");
  v.key("supersampling", render.supersampling,
        "Supersampling factor per axis, for smoother edges and lines; time and memory grow with its square",
        between(1, 4));
  v.key("report", render.report, "Write report.html: the run on one page");
  v.key("depth_max_mm", render.depth_max_mm,
        "End of the depth legend; 0: just above the depth predicted from motion and tool", between(0, 200));
}

void describe_output(KeyVisitor& v, OutputSettings& output) {
  v.key("dir", output.dir, "Results folder; \"\": out/NAME below the working directory. `-o` takes precedence",
        {.text = TextKind::output_folder});
  v.key("vti", output.vti, "Write reamed.vti beside reamed.vdb");
  v.key("meshes", output.meshes, "Write the surface of the reamed bone as reamed.glb and reamed.stl");
  v.key("force_basis", output.force_basis,
        "Write force_basis.npy, from which `reamsim reforce` and `reamsim fit` compute forces for other constants "
        "without a run. Needs `law: energy`, and erosion exact, or remove with engine.type bricked or engine.device "
        "serial");
  v.key("checkpoint_s", output.checkpoint_s,
        "Wall time between two checkpoints, from which `run --resume` continues an interrupted run; 0: none",
        between(0, 86400));
}

void describe_scenario(KeyVisitor& v, Scenario& scenario) {
  v.key("version", scenario.version, "Version of the scenario format",
        {.required = true, .range = between(kScenarioVersion, kScenarioVersion)});
  v.key("name", scenario.name, "Name of the run; without it the file name without its extension");
  v.section("bone", scenario.bone, describe_bone, "The bone to be reamed", {.required = true});
  v.section("tool", scenario.tool, describe_tool, "The reamer", {.required = true});
  v.section("clearance", scenario.clearance, describe_clearance,
            "Clearance of the parts of tool.holder along the motion");
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

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"
#include "sim/scenario/key_visitor.h"

namespace reamsim {

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

namespace {

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

void describe_metrics(KeyVisitor& v, MetricSettings& metrics) {
  v.key("dense_g_cm3", metrics.dense_g_cm3,
        "Least density of dense bone (subchondral plate and cortex); bone below it is trabecular", kDensity);
  v.section("implant", metrics.implant, describe_implant, "Glenoid implant whose fit in the reamed bone is measured");
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

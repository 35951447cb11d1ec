// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"
#include "sim/scenario/key_visitor.h"

namespace reamsim {

void describe_engine(KeyVisitor& v, EngineSettings& engine) {
  v.choice({.name = "type",
            .doc = "auto: exact where cutting.erosion is exact, else bricked. exact: clips the voxels of sparse bricks "
                   "against the surface of the tool. bricked: cells of shell points against sparse bricks. "
                   "Comparison systems on dense voxel arrays: direct, one work-item per shell point looks up its voxel "
                   "(Faieghi et al.); octree, one work-item per shell point descends the grid (Zheng et al.); "
                   "implicit, one work-item per voxel against the envelope of revolution (Yau et al.)"},
           engine.type);
  v.text({.name = "device",
          .doc = "auto: the OpenCL device that `reamsim devices` marks; serial: the reference in plain C++, without "
                 "OpenCL (slow); any other text: part of the name of an OpenCL device"},
         engine.device);
  v.integer({.name = "batch_frames",
             .doc = "Number of frames whose results are read back at once. It affects speed only",
             .range = between(1, 10000)},
            engine.batch_frames);
  v.number(
      {.name = "max_step_voxels",
       .doc =
           "Longest motion of any point of the tool in one substep, voxels; above 0.5 bone may survive between steps",
       .range = between(0.001, 10)},
      engine.max_step_voxels);
}

namespace {

void describe_user_camera(KeyVisitor& v, UserCamera& camera) {
  v.text({.name = "name", .doc = "Lower-case letters, digits, _ and -; suffix of its file names", .required = true},
         camera.name);
  v.choice({.name = "frame", .doc = "Frame of position_mm, target_mm and up"}, camera.frame);
  v.vector(
      {.name = "position_mm", .doc = "Position of the camera", .required = true, .range = kPosition, .point = true},
      camera.position_mm);
  v.optional_vector(
      {.name = "target_mm",
       .doc = "Point in the centre of the view; without it the centre of the glenoid, or the reamed region",
       .range = kPosition,
       .point = true},
      camera.target_mm);
  v.optional_vector({.name = "up",
                     .doc = "Upward direction of the picture; without it superior",
                     .range = kComponent,
                     .nonzero = true},
                    camera.up);
  v.choice({.name = "projection",
            .doc = "perspective: the scale bar holds at the distance of the target only; orthographic: all lengths are "
                   "to scale"},
           camera.projection);
  v.number({.name = "fov_deg",
            .doc = "Vertical field of view",
            .range = between(1, 120),
            .when = {"projection", {"perspective"}}},
           camera.fov_deg);
  v.number({.name = "width_mm",
            .doc = "Width of the view, without the column of labels",
            .range = between(0.1, 10000),
            .when = {"projection", {"orthographic"}}},
           camera.width_mm);
}

}  // namespace

void describe_metrics(KeyVisitor& v, MetricSettings& metrics) {
  v.number({.name = "dense_g_cm3",
            .doc = "Least density of dense bone (subchondral plate and cortex); bone below it is trabecular",
            .range = kDensity},
           metrics.dense_g_cm3);
  v.optional_section({.name = "implant", .doc = "Glenoid implant whose fit in the reamed bone is measured"},
                     metrics.implant, describe_implant);
}

void describe_render(KeyVisitor& v, RenderSettings& render) {
  v.flag({.name = "enabled", .doc = "Render pictures"}, render.enabled);
  v.choice(
      {.name = "context", .doc = "Off-screen OpenGL context. auto: OSMesa, or EGL where this system has no OSMesa"},
      render.context);
  v.integer({.name = "width_px", .doc = "Width of the pictures", .range = between(64, 16384)}, render.width_px);
  v.integer({.name = "height_px", .doc = "Height of the pictures", .range = between(64, 16384)}, render.height_px);
  v.integer({.name = "every_frames",
             .doc = "Number of frames between pictures; 0: eleven pictures, nine of them over the expected time of "
                    "contact, and 150 along the run for a film",
             .range = between(0, 1e9)},
            render.every_frames);
  v.choice_list({.name = "cameras", .doc = "Views, each at most once; the files of the first have no suffix"},
                render.cameras);
  v.list({.name = "user_cameras", .doc = "User cameras; their files end in _NAME"}, render.user_cameras,
         describe_user_camera);
  v.flag({.name = "before_after",
          .doc = "Render before_after.png for every camera: the bone before and after, side by side"},
         render.before_after);
  v.flag(
      {.name = "contact_sheet", .doc = "Render contact_sheet.png: the time of contact in up to twenty small pictures"},
      render.contact_sheet);
  v.integer({.name = "turntable_pictures",
             .doc = "Number of turntable pictures (turntable/NNN.png), 360° about the superior axis; 0: none",
             .range = between(0, 3600)},
            render.turntable_pictures);
  v.choice({.name = "film",
            .doc = "Make a film of the pictures of the first camera, with the curves of force and torque beside them, "
                   "and a film of the turntable. Needs ffmpeg"},
           render.film);
  v.integer({.name = "film_rate_hz", .doc = "Frame rate of the film, pictures per second", .range = between(1, 120)},
            render.film_rate_hz);
  v.flag({.name = "tool", .doc = "Draw the reamer"}, render.tool);
  v.choice({.name = "tool_look",
            .doc = "Material of the reamer: transparent or brushed steel; a cut surface is always steel"},
           render.tool_material);
  v.flag({.name = "force_arrow",
          .doc = "Draw the force of the bone on the reamer as an arrow with its magnitude, in pictures along the run"},
         render.force_arrow);
  v.choice(
      {.name = "background",
       .doc =
           "Background of the pictures. Films, contact sheet and report use white instead of transparent, and labels "
           "have a white ground"},
      render.background);
  v.vector({.name = "light",
            .doc = "Direction of the main light in the picture: right, up, towards the viewer",
            .range = kComponent,
            .nonzero = true},
           render.light);
  v.integer({.name = "supersampling",
             .doc = "Supersampling factor per axis, for smoother edges and lines; time and memory grow with its square",
             .range = between(1, 4)},
            render.supersampling);
  v.flag({.name = "report", .doc = "Write report.html: the run on one page"}, render.report);
  v.number({.name = "depth_max_mm",
            .doc = "End of the depth legend; 0: just above the depth predicted from motion and tool",
            .range = between(0, 200)},
           render.depth_max_mm);
}

void describe_output(KeyVisitor& v, OutputSettings& output) {
  v.text({.name = "dir",
          .doc = "Results folder; \"\": out/NAME below the working directory. `-o` takes precedence",
          .text = TextKind::output_folder},
         output.dir);
  v.flag({.name = "vti", .doc = "Write reamed.vti beside reamed.vdb"}, output.vti);
  v.flag({.name = "meshes", .doc = "Write the surface of the reamed bone as reamed.glb and reamed.stl"}, output.meshes);
  v.flag({.name = "force_basis",
          .doc = "Write force_basis.npy, from which `reamsim reforce` and `reamsim fit` compute forces for other "
                 "constants without a run. Needs `law: energy`, and erosion exact, or remove with engine.type bricked "
                 "or engine.device serial"},
         output.force_basis);
  v.number({.name = "checkpoint_s",
            .doc = "Wall time between two checkpoints, from which `run --resume` continues an interrupted run; 0: none",
            .range = between(0, 86400)},
           output.checkpoint_s);
}

void describe_scenario(KeyVisitor& v, Scenario& scenario) {
  v.integer({.name = "version",
             .doc = "Version of the scenario format",
             .required = true,
             .range = between(kScenarioVersion, kScenarioVersion)},
            scenario.version);
  v.text({.name = "name", .doc = "Name of the run; without it the file name without its extension"}, scenario.name);
  v.section({.name = "bone", .doc = "The bone to be reamed", .required = true}, scenario.bone, describe_bone);
  v.section({.name = "tool", .doc = "The reamer", .required = true}, scenario.tool, describe_tool);
  v.section({.name = "clearance", .doc = "Clearance of the parts of tool.holder along the motion"}, scenario.clearance,
            describe_clearance);
  v.section({.name = "motion", .doc = "Motion of the reamer", .required = true}, scenario.motion, describe_motion);
  v.section({.name = "engine", .doc = "Engine and device"}, scenario.engine, describe_engine);
  v.defaults([&scenario] {
    const EngineKind engine = scenario.engine.type;
    if (engine != EngineKind::automatic && engine != EngineKind::exact) scenario.cutting.erosion = ErosionMode::remove;
  });
  v.section({.name = "cutting", .doc = "Erosion and cutting-force model"}, scenario.cutting, describe_cutting);
  v.section({.name = "metrics", .doc = "Metrics of the reamed bone in summary.json"}, scenario.metrics,
            describe_metrics);
  v.section({.name = "render", .doc = "Pictures"}, scenario.render, describe_render);
  v.section({.name = "output", .doc = "Results folder and files"}, scenario.output, describe_output);
}

}  // namespace reamsim

#include "sim/scenario/describe_sections.h"
#include "sim/scenario/key_visitor.h"

namespace reamsim {

void describe_engine(KeyVisitor& v, EngineSettings& engine) {
  v.choice(
      {.name = "detector",
       .doc = "How contact is found. bricked: cells of shell points against bricks of voxels, the fast one; on dense "
              "voxel arrays, direct: one work-item per shell point looks its voxel up (Faieghi et al.); octree: one "
              "per shell point descends the grid (Zheng et al.); implicit: one per voxel against the surface that the "
              "tool sweeps, without a shell (Yau et al.)"},
      engine.detector);
  v.text(
      {.name = "device",
       .doc = "auto: the OpenCL device that `reamsim devices` marks; serial: the slow reference in plain C++, without "
              "OpenCL; anything else: part of an OpenCL device's name"},
      engine.device);
  v.choice(
      {.name = "kernel_shape",
       .doc = "How the kernels of bricked are laid out: cpu, few work-items that do much in vectors; gpu, many that do "
              "little; auto, by the device. Changes the speed, never a result"},
      engine.kernel_shape);
  v.flag({.name = "culling",
          .doc = "bricked passes over cells of shell points that cannot touch. Changes the speed, never a result"},
         engine.culling);
  v.integer(
      {.name = "work_group_size",
       .doc = "Work-items per work-group, at most what the device can have (256 on a processor); 0: chosen from the "
              "device. Changes the speed, never a result",
       .range = between(0, 4096)},
      engine.work_group_size);
  v.integer({.name = "batch_frames",
             .doc = "Frames whose results are read back at once. Changes the speed, never a result",
             .range = between(1, 10000)},
            engine.batch_frames);
  v.number({.name = "max_step_voxels",
            .doc = "No point of the tool moves further in one substep; above 0.5 bone may survive between steps",
            .range = above(0, 10)},
           engine.max_step_voxels);
}

namespace {

void describe_implant(KeyVisitor& v, ImplantSettings& implant) {
  v.number({.name = "backside_radius_mm",
            .doc = "Radius of its spherical back; 0: flat",
            .required = true,
            .range = between(0, 500)},
           implant.backside_radius_mm);
  v.number({.name = "diameter_mm",
            .doc = "Of its footprint, a circle round the reamer's axis; 0: the footprint is the reamed face",
            .range = between(0, 200)},
           implant.diameter_mm);
  v.number({.name = "gap_mm", .doc = "Up to this gap the back counts as seated", .range = above(0, 10)},
           implant.gap_mm);
}

/// Positions further out than this are mistakes of unit or frame.
constexpr Range kPlace = between(-10000, 10000);

void describe_user_camera(KeyVisitor& v, UserCamera& camera) {
  v.text({.name = "name", .doc = "Lower-case letters, digits, _ and -; ends the names of its files", .required = true},
         camera.name);
  v.choice({.name = "frame", .doc = "Frame of position_mm, target_mm and up"}, camera.frame);
  v.vector({.name = "position_mm", .doc = "Where the camera stands", .required = true, .range = kPlace},
           camera.position_mm);
  v.optional_vector({.name = "target_mm",
                     .doc = "The middle of the picture; without it the glenoid's centre, or the reamed region",
                     .range = kPlace},
                    camera.target_mm);
  v.optional_vector({.name = "up",
                     .doc = "Upwards in the picture; without it superior",
                     .range = between(-1000, 1000),
                     .nonzero = true},
                    camera.up);
  v.choice({.name = "projection",
            .doc = "perspective: as an eye sees, and the scale bar holds at the target's distance only; orthographic: "
                   "every length to scale"},
           camera.projection);
  v.number({.name = "fov_deg",
            .doc = "Angle that the picture's height covers",
            .range = between(1, 120),
            .when = {"projection", {"perspective"}}},
           camera.fov_deg);
  v.number({.name = "width_mm",
            .doc = "What the picture's width covers",
            .range = between(0.1, 10000),
            .when = {"projection", {"orthographic"}}},
           camera.width_mm);
}

}  // namespace

void describe_metrics(KeyVisitor& v, MetricSettings& metrics) {
  v.number({.name = "dense_g_cm3",
            .doc = "From this density on bone counts as dense: subchondral plate and cortex; below it as trabecular",
            .range = above(0, 2)},
           metrics.dense_g_cm3);
  v.optional_section({.name = "implant", .doc = "A glenoid component whose seating on the reamed face is measured"},
                     metrics.implant, describe_implant);
}

void describe_render(KeyVisitor& v, RenderSettings& render) {
  v.flag({.name = "enabled", .doc = "Make pictures"}, render.enabled);
  v.choice({.name = "context", .doc = "What draws: osmesa or egl, both without a display"}, render.context);
  v.integer({.name = "width_px", .doc = "Width of the pictures", .range = between(64, 16384)}, render.width_px);
  v.integer({.name = "height_px", .doc = "Height of the pictures", .range = between(64, 16384)}, render.height_px);
  v.integer({.name = "every_frames",
             .doc = "Frames from one picture to the next; 0: ten pictures over the run, and a film of 150",
             .range = between(0, 1e9)},
            render.every_frames);
  v.choice_list({.name = "cameras", .doc = "Views, each at most once; the first names its files without a suffix"},
                render.cameras);
  v.list({.name = "user_cameras", .doc = "Cameras of your own; their files end in _NAME"}, render.user_cameras,
         describe_user_camera);
  v.flag({.name = "before_after",
          .doc = "Make before_after.png for every camera: the bone before and after, side by side"},
         render.before_after);
  v.flag({.name = "contact_sheet", .doc = "Make contact_sheet.png: the run in up to twenty small pictures"},
         render.contact_sheet);
  v.integer({.name = "turntable_pictures",
             .doc = "Make turntable/NNN.png: so many pictures of the reamed bone, all round its superior axis; 0: none",
             .range = between(0, 3600)},
            render.turntable_pictures);
  v.choice(
      {.name = "film",
       .doc = "Make a film of the pictures of the first camera, with force and torque running beside them, and one "
              "of the turntable. Takes ffmpeg"},
      render.film);
  v.integer({.name = "film_rate_hz", .doc = "Pictures that a film shows per second", .range = between(1, 120)},
            render.film_rate_hz);
  v.flag({.name = "tool", .doc = "Draw the reamer"}, render.tool);
  v.choice({.name = "tool_look",
            .doc = "How the reamer looks: see-through, or as brushed steel; where it is cut open it is always steel"},
           render.tool_look);
  v.flag({.name = "force_arrow",
          .doc = "Draw the bone's force on the reamer as an arrow with its magnitude, in pictures along the run"},
         render.force_arrow);
  v.choice({.name = "background",
            .doc = "What lies behind the bone. Films, contact sheet and report show white instead of nothing"},
           render.background);
  v.vector({.name = "light",
            .doc = "Where the main light comes from, as the picture is seen: right, up, towards the viewer",
            .range = between(-1000, 1000),
            .nonzero = true},
           render.light);
  v.integer({.name = "supersampling",
             .doc = "Draw pictures so many times as wide and as high and average, for smoother edges and lines; "
                    "time and memory go with its square",
             .range = between(1, 4)},
            render.supersampling);
  v.flag({.name = "report", .doc = "Write report.html, a page that holds the run, beside the pictures"}, render.report);
  v.number({.name = "depth_max_mm",
            .doc = "Top of the depth legend; 0: just above the depth that motion and tool foresee",
            .range = between(0, 200)},
           render.depth_max_mm);
}

void describe_output(KeyVisitor& v, OutputSettings& output) {
  v.text({.name = "dir",
          .doc = "The results' folder; \"\": out/NAME below the folder where reamsim is started. `-o` wins over it",
          .text = TextKind::output_folder},
         output.dir);
  v.flag({.name = "vti", .doc = "Write reamed.vti beside reamed.vdb"}, output.vti);
  v.flag({.name = "meshes", .doc = "Write the reamed bone's surface as reamed.glb and reamed.stl"}, output.meshes);
}

void describe_scenario(KeyVisitor& v, Scenario& scenario) {
  v.integer({.name = "version", .doc = "Version of this format", .required = true, .range = between(1, 1)},
            scenario.version);
  v.text({.name = "name", .doc = "Names the run in output; without it the file's name without its ending"},
         scenario.name);
  v.section({.name = "bone", .doc = "The bone to be reamed", .required = true}, scenario.bone, describe_bone);
  v.section({.name = "tool", .doc = "The reamer", .required = true}, scenario.tool, describe_tool);
  v.section({.name = "motion", .doc = "How the reamer moves", .required = true}, scenario.motion, describe_motion);
  v.section({.name = "engine", .doc = "How contact is computed, and where"}, scenario.engine, describe_engine);
  v.defaults([&scenario] {
    // Only bricks are clipped.
    if (scenario.engine.detector != EngineKind::bricked) scenario.cutting.erosion = ErosionMode::remove;
  });
  v.section({.name = "cutting", .doc = "How bone goes, and what force that takes"}, scenario.cutting, describe_cutting);
  v.section({.name = "metrics", .doc = "What summary.json measures of the reamed bone"}, scenario.metrics,
            describe_metrics);
  v.section({.name = "render", .doc = "Pictures"}, scenario.render, describe_render);
  v.section({.name = "output", .doc = "Where the results go"}, scenario.output, describe_output);
}

}  // namespace reamsim

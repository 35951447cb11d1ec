// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/figures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include "render/pictures/canvas.h"
#include "render/pictures/renderer.h"
#include "sim/base/file.h"
#include "sim/base/text.h"

namespace reamsim {
namespace {

constexpr int kSetupViews = 3, kSetupView_px = 632, kPanelGap_px = 8, kTitles_px = 68;
constexpr double kTitle_px = 20, kSmallText_px = 16;
constexpr std::uint32_t kSetupPaper_rgb = 0xffffff;
constexpr Rgba kToolPathColor{0.84, 0.37, 0.0, 1};  // Okabe and Ito's vermilion
constexpr Rgba kPathHaloColor{1, 1, 1, 0.85};
constexpr const char* kSoftware = "reamsim check";

/// The fractions of a picture that make_camera() leaves for bone and tool.
constexpr double kUsedWidth = 0.60, kUsedHeight = 0.84;

/// A camera for a square panel, which has no legends beside the bone.
Camera square_camera(CameraView view, const ViewTarget& target) {
  Camera camera = make_camera(view, target, static_cast<int>(kSetupView_px * kUsedHeight / kUsedWidth), kSetupView_px);
  camera.width_px = kSetupView_px;
  return camera;
}

/// The target with the tool, and its path, in the picture.
ViewTarget with_tool_path(ViewTarget target, const RunInputs& run, const PlacedTool& tool) {
  const ToolPass& pass = run.passes[tool.pass];
  for (const Vec3& v : pass.tool.vertices) target.tool_head_mm.emplace_back(tool.bone_from_tool * v);
  for (const PathSample& at : pass.path) target.tool_head_mm.push_back(at.pose.position_mm);
  return target;
}

struct SetupView {
  std::string title;
  std::string note;
  Camera camera;
  PlacedTool tool;
  bool marks_gap = false;  ///< the smallest distance between tool and bone
};

class SetupPainter {
 public:
  SetupPainter(const RunSetup& setup, PixelImage& image, const SetupView& panel)
      : setup_(setup), panel_(panel), canvas_(image) {
    cairo_set_line_cap(canvas_.get(), CAIRO_LINE_CAP_ROUND);
    cairo_set_line_join(canvas_.get(), CAIRO_LINE_JOIN_ROUND);
  }

  void paint() {
    draw_path();
    if (!panel_.camera.shows_tool) draw_rim();
    if (panel_.marks_gap) draw_gap();
    draw_scale_bar();
    canvas_.finish();
  }

 private:
  void stroke_with_halo(double width_px) {
    canvas_.stroke_halo(kPathHaloColor, width_px + 3);
    canvas_.stroke(kToolPathColor, width_px);
  }

  void line_to(const Vec3& point_mm) {
    const Vec2 p = panel_.camera.pixel(point_mm);
    cairo_line_to(canvas_.get(), p.x(), p.y());
  }

  [[nodiscard]] const ToolPass& pass() const { return setup_.inputs.passes[panel_.tool.pass]; }

  /// The path of the tool's origin, with a dot at its start.
  void draw_path() {
    for (const PathSample& at : pass().path) line_to(at.pose.position_mm);
    stroke_with_halo(2.5);
    const Vec2 start = panel_.camera.pixel(pass().path.front().pose.position_mm);
    cairo_new_sub_path(canvas_.get());
    cairo_arc(canvas_.get(), start.x(), start.y(), 4, 0, 2 * M_PI);
    stroke_with_halo(4);
  }

  /// The circle of the tool's outermost point.
  void draw_rim() {
    const std::vector<Vec3>& vertices = pass().tool.vertices;
    const Vec3 widest = *std::ranges::max_element(vertices, {}, [](const Vec3& v) { return v.head<2>().norm(); });
    constexpr int kPoints = 96;
    for (int i = 0; i <= kPoints; ++i) {
      line_to(panel_.tool.bone_from_tool * (Eigen::AngleAxisd(2 * M_PI * i / kPoints, Vec3::UnitZ()) * widest));
    }
    stroke_with_halo(1.5);
  }

  /// A dashed line between the bone and the tool where they are nearest.
  void draw_gap() {
    const Vec3& bone_mm = setup_.contact.bone_mm;
    const Rigid& bone_from_tool = panel_.tool.bone_from_tool;
    const Vec3 at_t = bone_from_tool.inverse() * bone_mm;
    const std::vector<Vec3>& vertices = pass().tool.vertices;
    const Vec3 tool_t = *std::ranges::min_element(vertices, {}, [&](const Vec3& v) { return (v - at_t).norm(); });
    const double dashes[] = {7, 7};
    line_to(bone_mm);
    line_to(bone_from_tool * tool_t);
    cairo_set_dash(canvas_.get(), dashes, 2, 0);
    stroke_with_halo(3);
    cairo_set_dash(canvas_.get(), nullptr, 0, 0);
  }

  void draw_scale_bar() {
    const double length_mm = round_down(0.3 * panel_.camera.width_px * panel_.camera.mm_per_px);
    const double length_px = length_mm / panel_.camera.mm_per_px;
    const double y = panel_.camera.height_px - 20;
    const TextLine text(canvas_, shortest_text(length_mm) + " mm", kSmallText_px);
    canvas_.fill_panel({8, y - text.height - 12, std::max(length_px, text.width) + 24, text.height + 24}, 5);
    cairo_set_line_cap(canvas_.get(), CAIRO_LINE_CAP_BUTT);
    canvas_.line({20, y}, {20 + length_px, y}, kTextColor, 4);
    text.draw(20, y - text.height - 6);
  }

  const RunSetup& setup_;
  const SetupView& panel_;
  Canvas canvas_;
};

std::string setup_time(const RunSetup& setup, std::int64_t frame) {
  return fixed_text(static_cast<double>(frame) * setup.frame_s, 2) + " s";
}

/// From three sides, at the smallest distance.
std::vector<SetupView> views_without_contact(const RunSetup& setup, const ViewTarget& target) {
  const RunInputs& run = setup.inputs;
  const PlacedTool nearest{run.pose_at(setup.contact.frame).bone_from_tool(), run.pass_at(setup.contact.frame)};
  const PlacedTool first{run.passes[nearest.pass].path.front().pose.bone_from_tool(), nearest.pass};
  const ViewTarget wide = with_tool_path(with_tool_path(target, run, nearest), run, first);
  ViewTarget other = wide;
  other.anterior = wide.anterior ? -*wide.anterior : Vec3(wide.outward.cross(wide.superior));
  ViewTarget above = wide;
  std::swap(above.outward, above.superior);
  const std::string note = "path in orange; dashed: the smallest distance";
  return {{"The tool never touches the bone: " + fixed_text(setup.contact.nearest_mm, 1) + " mm at " +
               setup_time(setup, setup.contact.frame),
           note, square_camera(CameraView::overview, wide), nearest, true},
          {"From the other side", "", square_camera(CameraView::overview, other), nearest, true},
          {target.anatomical ? "From superior" : "From a third side", "", square_camera(CameraView::overview, above),
           nearest, true}};
}

/// At the start; and at the greatest depth en face and in a section.
std::vector<SetupView> views_with_contact(const RunSetup& setup, const ViewTarget& target, const PlacedTool& deepest,
                                          double depth_mm) {
  const PlacedTool first{setup.inputs.passes.front().path.front().pose.bone_from_tool()};
  std::string contact;
  if (setup.contact.start_mm3 > setup.inputs.voxmap->grid.voxel_mm3()) {
    contact = "; the tool starts in the bone";
  } else if (setup.contact.frames) {
    contact = "; first contact at " + setup_time(setup, setup.contact.frames->first);
  }
  return {{"Start", "path in orange, with a dot at its start" + contact,
           square_camera(CameraView::overview, with_tool_path(target, setup.inputs, first)), first},
          {target.bone_from_glenoid ? "Greatest depth, en face" : "Greatest depth, along the tool axis",
           "with the rim of the tool; bone as it is left: removed to a depth of " + fixed_text(depth_mm, 2) + " mm",
           square_camera(CameraView::glenoid, target), deepest},
          {"Greatest depth, section along the tool axis", "density from dark (0) to light (2 g/cm³)",
           square_camera(CameraView::section, target), deepest}};
}

/// The unreamed bone at the start, or where no bone is removed; else the bone after the sweep.
PixelImage drawn(const RunSetup& setup, const RunData& run, std::string& warning) {
  RenderSettings settings = setup.settings;
  settings.background = Background::studio;
  settings.tool_material = ToolMaterial::steel;
  settings.supersampling = 1;
  const RunView view(run, settings);
  const PredictedRun after = predict_run(setup.inputs);
  const PlacedTool deepest{after.bone.deepest.bone_from_tool(), after.pass};
  const std::vector<SetupView> views = setup.contact.touches
                                           ? views_with_contact(setup, run.target(), deepest, run.unreamed().deepest_mm)
                                           : views_without_contact(setup, run.target());
  PixelImage page = plain_image(kSetupViews * kSetupView_px + (kSetupViews - 1) * kPanelGap_px,
                                kTitles_px + kSetupView_px, kSetupPaper_rgb);
  Renderer renderer(view);
  warning = renderer.warning();
  int left_px = 0;
  for (const SetupView& panel : views) {
    if (&panel == &views[1]) renderer.show(after.bone.fill);
    PixelImage image = renderer.render(panel.camera, panel.tool);
    SetupPainter(setup, image, panel).paint();
    page.paste(image, left_px, kTitles_px);
    const Canvas canvas(page);
    TextLine(canvas, panel.title, kTitle_px, true).draw(left_px + 12, 8);
    TextLine(canvas, panel.note, kSmallText_px).draw(left_px + 12, 38, kFaintTextColor);
    canvas.finish();
    left_px += kSetupView_px + kPanelGap_px;
  }
  return page;
}

}  // namespace

std::string write_setup_picture(const std::string& path, const RunSetup& setup) {
  std::string warning;
  const PixelImage image = drawn(setup, RunData(setup.inputs), warning);
  const std::string unfinished = path + ".tmp";
  std::error_code error;
  try {
    write_png(unfinished, image, kSoftware);
    std::filesystem::rename(unfinished, path, error);
    if (error) fail_to_write(path);
  } catch (const RunError&) {
    std::filesystem::remove(unfinished, error);
    throw;
  }
  return warning;
}

bool is_setup_picture(const std::string& path) {
  const std::string start = read_file_start(path, 256);
  return start.starts_with("\x89PNG") && start.find(kSoftware) != std::string::npos;
}

}  // namespace reamsim

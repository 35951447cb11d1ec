// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/figures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "render/pictures/canvas.h"
#include "render/pictures/contour_lines.h"
#include "render/surface/bone_surface.h"
#include "sim/base/parallel.h"
#include "sim/base/text.h"
#include "sim/mesh/mesh_io.h"

namespace reamsim {
namespace {

constexpr int kWidth_px = 1600, kHeight_px = 1080;
constexpr double kMapFraction = 0.95;  // of the view, at most
constexpr int kMapSamples = 2;         // per pixel along each axis

using Rgb = Eigen::Vector3d;
using Outlines = std::vector<std::vector<Vec2>>;  ///< pixels

const Rgb kPaperRgb(0.984, 0.984, 0.988), kBoneRgb(0.90, 0.87, 0.82), kHoleRgb(0.75, 0.10, 0.12);

/// The view along −z of the map.
Camera map_camera(const DepthField& field, const PageLayout& page) {
  const Vec2 size = field.shown_mm().sizes(), middle = field.shown_mm().center();
  Camera camera{.name = "depth_map", .width_px = page.view_width_px, .height_px = page.height_px};
  camera.mm_per_px = std::max(size.x() / camera.width_px, size.y() / camera.height_px) / kMapFraction;
  camera.eye_from_bone.translation() = Vec3(-middle.x(), -middle.y(), 0);
  return camera;
}

Outlines outlines_px(const Camera& camera, const std::vector<ContourLine>& lines) {
  Outlines out(lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (const Vec2& p : lines[i].points_mm) out[i].push_back(camera.pixel({p.x(), p.y(), 0}));
  }
  return out;
}

/// Renders the map without labels.
class DepthPainter {
 public:
  DepthPainter(const DepthField& field, const Camera& camera, const Scale& scale)
      : field_(field), camera_(camera), scale_(scale), colors_(depth_colors()) {
    const Vec3 middle = camera.eye_from_bone.inverse().translation();
    for (int n = 0; n < kMapSamples * camera.width_px; ++n) {
      columns_.push_back(field.along(0, (sample_px(n) - 0.5 * camera.width_px) * camera.mm_per_px + middle.x()));
    }
    for (int n = 0; n < kMapSamples * camera.height_px; ++n) {
      rows_.push_back(field.along(1, (0.5 * camera.height_px - sample_px(n)) * camera.mm_per_px + middle.y()));
    }
  }

  [[nodiscard]] PixelImage paint() const {
    PixelImage page = plain_image(camera_.width_px, camera_.height_px, packed(kPaperRgb));
    const Canvas canvas(page);
    const Outlines bone = outlines_px(camera_, field_.bone_outlines());
    const Outlines reamed = outlines_px(camera_, field_.reamed_outlines());
    fill(canvas, bone, image_of(bone, [&](const Along& x, const Along& y) { return bone_color(x, y); }));
    cairo_save(canvas.get());
    for (const auto& outline : bone) canvas.trace(outline);
    cairo_clip(canvas.get());
    fill(canvas, reamed, image_of(reamed, [&](const Along& x, const Along& y) { return depth_color(x, y); }));
    cairo_restore(canvas.get());
    canvas.finish();
    return page;
  }

 private:
  using Along = DepthField::Along;

  /// The middle of the n-th sample along an axis of the picture.
  static double sample_px(int n) {
    const int pixel = n / kMapSamples;
    return pixel + (n % kMapSamples + 0.5) / kMapSamples;
  }

  /// A layer: the mean colour of the samples of each pixel in the box of outlines, and a pixel around it.
  template <class Color>
  [[nodiscard]] PixelImage image_of(const Outlines& outlines, const Color& color) const {
    PixelImage image = plain_image(camera_.width_px, camera_.height_px, 0);
    Eigen::AlignedBox2d box;
    for (const auto& outline : outlines) {
      for (const Vec2& p : outline) box.extend(p);
    }
    const Vec2 picture(camera_.width_px, camera_.height_px);
    using Pixel = Eigen::Matrix<std::size_t, 2, 1>;
    const Pixel first = (box.min().array() - 1).max(0).min(picture.array()).matrix().cast<std::size_t>();
    const Pixel end = (box.max().array() + 2).min(picture.array()).max(0).matrix().cast<std::size_t>();
    parallel_items(end.y(), [&](std::size_t y) {
      if (y < first.y()) return;
      for (std::size_t x = first.x(); x < end.x(); ++x) {
        Rgb sum = Rgb::Zero();
        for (std::size_t n = 0; n < std::size_t{kMapSamples} * kMapSamples; ++n) {
          sum += color(columns_[kMapSamples * x + n % kMapSamples], rows_[kMapSamples * y + n / kMapSamples]);
        }
        image.pixels[x + static_cast<std::size_t>(camera_.width_px) * y] = packed(sum / (kMapSamples * kMapSamples));
      }
    });
    return image;
  }

  /// Fills the area within outlines, without that within inner ones, with a layer.
  static void fill(const Canvas& canvas, const Outlines& outlines, PixelImage layer) {
    const Canvas source(layer);
    for (const auto& outline : outlines) canvas.trace(outline);
    cairo_set_fill_rule(canvas.get(), CAIRO_FILL_RULE_EVEN_ODD);
    cairo_set_source_surface(canvas.get(), source.surface(), 0, 0);
    cairo_fill(canvas.get());
  }

  [[nodiscard]] Rgb depth_color(const Along& x, const Along& y) const {
    const DepthField::Sample sample = field_.at(x, y);
    if (sample.perforated > 0.5 * sample.reamed && sample.reamed > 0) return kHoleRgb;
    return colors_.at(sample.smooth_mm / scale_.max).cast<double>();
  }

  /// Unreamed bone, lit from the upper left.
  [[nodiscard]] Rgb bone_color(const Along& x, const Along& y) const {
    const double light = field_.normal_before(x, y).dot(Vec3(-0.4, 0.5, 0.77).normalized());
    return kBoneRgb * std::clamp(0.55 + 0.45 * light, 0.35, 1.0);
  }

  static std::uint32_t packed(const Rgb& color) {
    const auto channel = [](double value) {
      return static_cast<std::uint32_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
    };
    return 0xff000000U | channel(color.x()) << 16 | channel(color.y()) << 8 | channel(color.z());
  }

  const DepthField& field_;
  const Camera& camera_;
  const Scale& scale_;
  ColorMap colors_;
  std::vector<Along> columns_, rows_;  ///< of the samples
};

/// The contour lines as seen by the camera, all of them visible.
std::vector<SeenContour> map_contours(const DepthField& field, const Camera& camera, const Scale& scale) {
  std::vector<SeenContour> out;
  for (const ContourLine& line : depth_contours(field.signed_depth_mm(), scale)) {
    SeenContour& seen = out.emplace_back(contour_style(line.value, scale));
    seen.points_px = outlines_px(camera, {line}).front();
    seen.visible.assign(seen.points_px.size(), true);
  }
  return out;
}

Labels map_labels(const DepthField& field, const RunInputs& run, const Scale& scale) {
  Labels labels;
  labels.title = run.glenoid ? "Depth along the glenoid's axis" : "Depth along the reamer's axis";
  labels.values = {{"deepest along axis", fixed_text(field.deepest_mm(), 2) + " mm"},
                   {"mean", fixed_text(field.mean_mm(), 2) + " mm"},
                   {"reamed area", fixed_text(field.area_mm2(), 0) + " mm²"}};
  if (field.perforated_mm2() > 0) {
    labels.values.emplace_back("hole (red)", fixed_text(field.perforated_mm2(), 1) + " mm²");
  }
  labels.legends.push_back({"Depth", "mm along axis", depth_colors(), scale});
  if (!run.glenoid) return labels;
  labels.directions = {{"superior", Vec3::UnitY()}};
  // +x of G is superior × lateral: posterior on a left shoulder, anterior on a right one.
  if (run.side == BodySide::left) labels.directions.emplace_back("anterior", -Vec3::UnitX());
  if (run.side == BodySide::right) labels.directions.emplace_back("anterior", Vec3::UnitX());
  return labels;
}

}  // namespace

void write_depth_picture(const RunData& run, double depth_max_mm) {
  const std::string path = run.dir() + "/depth_map.csv";
  if (!std::filesystem::exists(path)) return;
  const DepthField field(path);
  if (field.deepest_mm() == 0) return;
  const Scale scale = depth_max_mm > 0 ? scale_exactly(depth_max_mm) : scale_up_to(field.deepest_mm());
  const PageLayout page = page_layout(kWidth_px, kHeight_px);
  const Camera camera = map_camera(field, page);
  PixelImage image = DepthPainter(field, camera, scale).paint();
  Labels labels = map_labels(field, run.inputs(), scale);
  labels.contours = map_contours(field, camera, scale);
  draw_contours(image, page.unit, labels.contours);
  image = annotated_picture(std::move(image), page, camera, labels, Background::studio);
  write_png(run.dir() + "/depth_map.png", image);
}

void write_meshes(const RunData& run, double depth_max_mm, Diagnostics& report) {
  const std::string& dir = run.dir();
  const ReamedMesh reamed =
      make_reamed_mesh(dir + "/reamed.vdb", {run.voxmap(), run.last_fill()}, run.unreamed(), run.inputs().whole_voxels);
  if (reamed.mesh.triangles.empty()) {
    std::filesystem::remove(dir + "/reamed.glb");
    std::filesystem::remove(dir + "/reamed.stl");
    report.warn("no bone remains: reamed.glb and reamed.stl are not written");
    return;
  }
  write_glb(dir + "/reamed.glb", reamed, depth_scale(run, depth_max_mm).max);
  write_stl(dir + "/reamed.stl", reamed.mesh, "LPS");
}

}  // namespace reamsim

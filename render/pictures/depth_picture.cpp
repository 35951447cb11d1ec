// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/figures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "render/pictures/canvas.h"
#include "render/pictures/contour_labels.h"
#include "render/pictures/depth_field.h"
#include "render/pictures/overlay.h"
#include "sim/base/parallel.h"
#include "sim/base/text.h"

namespace reamsim {
namespace {

constexpr int kWidth_px = 1600;
constexpr int kHeight_px = 1080;
/// The fraction of the view that the map may fill.
constexpr double kMapFraction = 0.95;
/// Samples per pixel along each axis.
constexpr int kMapSamples = 2;

using Rgb = Eigen::Vector3d;

const Rgb kPaperRgb(0.984, 0.984, 0.988);
const Rgb kBoneRgb(0.90, 0.87, 0.82);
const Rgb kHoleRgb(0.75, 0.10, 0.12);

/// The view along −z of the map.
Camera map_camera(const DepthField& field, const PageLayout& page) {
  const Vec2 size = field.max_mm() - field.min_mm();
  const Vec2 middle = 0.5 * (field.min_mm() + field.max_mm());
  Camera camera;
  camera.name = "depth_map";
  camera.width_px = page.view_width_px;
  camera.height_px = page.height_px;
  camera.mm_per_px = std::max(size.x() / camera.width_px, size.y() / camera.height_px) / kMapFraction;
  camera.eye_from_bone.translation() = Vec3(-middle.x(), -middle.y(), 0);
  return camera;
}

/// Renders the map without labels.
class DepthPainter {
 public:
  DepthPainter(const DepthField& field, const Camera& camera, const Scale& scale)
      : field_(field),
        camera_(camera),
        map_from_eye_(camera.eye_from_bone.inverse()),
        scale_(scale),
        colors_(depth_colors()) {}

  [[nodiscard]] PixelImage paint() const {
    PixelImage page = plain_image(camera_.width_px, camera_.height_px, packed(kPaperRgb));
    const Canvas canvas(page);
    fill(canvas, field_.bone_outlines(), image_of([&](const Vec2& at) { return bone_color(at); }));
    cairo_save(canvas.get());
    trace(canvas, field_.bone_outlines());
    cairo_clip(canvas.get());
    fill(canvas, field_.reamed_outlines(), image_of([&](const Vec2& at) { return depth_color(at); }));
    cairo_restore(canvas.get());
    canvas.finish();
    return page;
  }

 private:
  [[nodiscard]] Vec2 place(double x_px, double y_px) const {
    const Vec3 eye((x_px - 0.5 * camera_.width_px) * camera_.mm_per_px,
                   (0.5 * camera_.height_px - y_px) * camera_.mm_per_px, 0);
    return (map_from_eye_ * eye).head<2>();
  }

  /// A layer of the map: the mean colour of the samples of each pixel.
  template <class Color>
  [[nodiscard]] PixelImage image_of(const Color& color) const {
    PixelImage image = plain_image(camera_.width_px, camera_.height_px, 0);
    const auto width = static_cast<std::size_t>(camera_.width_px);
    parallel_items(static_cast<std::size_t>(camera_.height_px), [&](std::size_t y) {
      for (std::size_t x = 0; x < width; ++x) {
        Rgb sum = Rgb::Zero();
        for (int n = 0; n < kMapSamples * kMapSamples; ++n) {
          const double across = static_cast<double>(x) + (n % kMapSamples + 0.5) / kMapSamples;
          const double down = static_cast<double>(y) + (n / kMapSamples + 0.5) / kMapSamples;
          sum += color(place(across, down));
        }
        image.pixels[x + width * y] = packed(sum / (kMapSamples * kMapSamples));
      }
    });
    return image;
  }

  void trace(const Canvas& canvas, const std::vector<ContourLine>& outlines) const {
    for (const ContourLine& line : outlines) {
      cairo_new_sub_path(canvas.get());
      for (const Vec2& p : line.points_mm) {
        const Vec2 px = camera_.pixel({p.x(), p.y(), 0});
        cairo_line_to(canvas.get(), px.x(), px.y());
      }
      cairo_close_path(canvas.get());
    }
  }

  /// Fills the area within outlines, without that within inner ones, with a layer.
  void fill(const Canvas& canvas, const std::vector<ContourLine>& outlines, PixelImage layer) const {
    const Canvas source(layer);
    trace(canvas, outlines);
    cairo_set_fill_rule(canvas.get(), CAIRO_FILL_RULE_EVEN_ODD);
    cairo_set_source_surface(canvas.get(), source.surface(), 0, 0);
    cairo_fill(canvas.get());
  }

  [[nodiscard]] Rgb depth_color(const Vec2& at) const {
    const DepthField::Sample sample = field_.at(at);
    if (sample.perforated > 0.5 * sample.reamed && sample.reamed > 0) return kHoleRgb;
    return colors_.at(sample.smooth_mm / scale_.max).cast<double>();
  }

  /// Unreamed bone, lit from the upper left.
  [[nodiscard]] Rgb bone_color(const Vec2& at) const {
    const double light = field_.normal_before(at).dot(Vec3(-0.4, 0.5, 0.77).normalized());
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
  Rigid map_from_eye_;
  const Scale& scale_;
  ColorMap colors_;
};

/// The contour lines as seen by the camera, all of them visible.
std::vector<SeenContour> map_contours(const DepthField& field, const Camera& camera, const Scale& scale) {
  std::vector<SeenContour> out;
  for (const ContourLine& line : depth_contours(field.signed_depth_mm(), scale)) {
    SeenContour& seen = out.emplace_back(contour_style(line.value, scale));
    for (const Vec2& p : line.points_mm) seen.points_px.push_back(camera.pixel({p.x(), p.y(), 0}));
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
  image = labelled_page(std::move(image), page, camera, labels, Background::studio);
  write_png(run.dir() + "/depth_map.png", image);
}

}  // namespace reamsim

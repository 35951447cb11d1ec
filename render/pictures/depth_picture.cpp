#include "render/pictures/figures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "render/pictures/depth_field.h"
#include "render/pictures/overlay.h"
#include "sim/base/parallel.h"
#include "sim/base/text.h"

namespace reamsim {
namespace {

constexpr int kWidth_px = 1600;
constexpr int kHeight_px = 1080;
/// The fraction of the picture that the map may fill, and its offset to the right, between values and legend.
constexpr double kMapWidth = 0.57;
constexpr double kMapHeight = 0.95;
constexpr double kShift_px = 125;
/// Samples per pixel along each axis.
constexpr int kMapSamples = 2;
constexpr double kContourWidth_px = 1.3;
/// Contour lines end where the reamed fraction is lower, because the mean depth is biased there.
constexpr double kMinContourFraction = 0.75;
/// Least slope of the depth with a contour line, mm per mm.
constexpr double kMinSlope = 0.01;

using Rgb = Eigen::Vector3d;

const Rgb kPaperRgb(0.97, 0.97, 0.975);
const Rgb kBoneRgb(0.90, 0.87, 0.82);
const Rgb kHoleRgb(0.75, 0.10, 0.12);

/// The view along −z of the map.
Camera map_camera(const DepthField& field) {
  const Vec2 size = field.max_mm() - field.min_mm();
  const Vec2 middle = 0.5 * (field.min_mm() + field.max_mm());
  Camera camera;
  camera.name = "depth_map";
  camera.width_px = kWidth_px;
  camera.height_px = kHeight_px;
  camera.mm_per_px = std::max(size.x() / (kMapWidth * kWidth_px), size.y() / (kMapHeight * kHeight_px));
  camera.eye_from_bone.translation() = Vec3(kShift_px * camera.mm_per_px - middle.x(), -middle.y(), 0);
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

  [[nodiscard]] std::vector<std::uint32_t> paint() const {
    const auto width = static_cast<std::size_t>(camera_.width_px), height = static_cast<std::size_t>(camera_.height_px);
    std::vector<std::uint32_t> pixels(width * height);
    parallel_items(height, [&](std::size_t y) {
      for (std::size_t x = 0; x < width; ++x) {
        pixels[x + width * y] = packed(pixel(static_cast<int>(x), static_cast<int>(y)));
      }
    });
    return pixels;
  }

 private:
  [[nodiscard]] Vec2 place(double x_px, double y_px) const {
    const Vec3 eye((x_px - 0.5 * camera_.width_px) * camera_.mm_per_px,
                   (0.5 * camera_.height_px - y_px) * camera_.mm_per_px, 0);
    return (map_from_eye_ * eye).head<2>();
  }

  [[nodiscard]] Rgb pixel(int x, int y) const {
    Rgb sum = Rgb::Zero();
    for (int n = 0; n < kMapSamples * kMapSamples; ++n) {
      sum += color(place(x + (n % kMapSamples + 0.5) / kMapSamples, y + (n / kMapSamples + 0.5) / kMapSamples));
    }
    return sum / (kMapSamples * kMapSamples);
  }

  [[nodiscard]] Rgb color(const Vec2& at) const {
    const DepthField::Sample sample = field_.at(at);
    if (sample.bone < 0.5) return kPaperRgb;
    if (sample.reamed < 0.5 * sample.bone) return bone_color(at);
    if (sample.perforated > 0.5 * sample.reamed) return kHoleRgb;
    const Rgb color = colors_.at(sample.depth_mm / scale_.max).cast<double>();
    return color + contour(at, sample) * (Rgb::Ones() - color);
  }

  /// Unreamed bone, lit from the upper left.
  [[nodiscard]] Rgb bone_color(const Vec2& at) const {
    const double light = field_.normal_before(at).dot(Vec3(-0.4, 0.5, 0.77).normalized());
    return kBoneRgb * std::clamp(0.55 + 0.45 * light, 0.35, 1.0);
  }

  /// Opacity of the contour lines, 0…1; they lie at multiples of the legend's step.
  [[nodiscard]] double contour(const Vec2& at, const DepthField::Sample& sample) const {
    const double nearest = std::round(sample.smooth_mm / scale_.step) * scale_.step;
    if (nearest <= 0) return 0;
    const double h = 0.5 * field_.spacing_mm();
    Vec2 slope;
    for (int axis = 0; axis < 2; ++axis) {
      const DepthField::Sample low = field_.at(at - h * Vec2::Unit(axis));
      const DepthField::Sample high = field_.at(at + h * Vec2::Unit(axis));
      if (low.reamed < kMinContourFraction || high.reamed < kMinContourFraction) return 0;
      slope[axis] = (high.smooth_mm - low.smooth_mm) / (2 * h);
    }
    // A terrace at a multiple of the step is no line.
    if (slope.norm() < kMinSlope) return 0;
    const double off_px = std::abs(sample.smooth_mm - nearest) / slope.norm() / camera_.mm_per_px;
    return 0.55 * std::clamp(kContourWidth_px - off_px, 0.0, 1.0);
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
  const Camera camera = map_camera(field);
  PixelImage image{camera.width_px, camera.height_px, DepthPainter(field, camera, scale).paint()};
  draw_labels(image, camera, map_labels(field, run.inputs(), scale));
  write_png(run.dir() + "/depth_map.png", image);
}

}  // namespace reamsim

#include "render/pictures/before_after.h"

#include <algorithm>

#include "render/gl/pixel_image.h"

namespace reamsim {
namespace {

constexpr std::uint32_t kGap_rgb = 0xffffff;

/// White between the halves; what is left of an odd width.
int gap_px(int width_px) {
  const int thin = std::max(1, width_px / 480);
  return width_px < 3 ? 0 : thin + (width_px - thin) % 2;
}

int half_width_px(int width_px) {
  return std::max(1, (width_px - gap_px(width_px)) / 2);
}

}  // namespace

Camera half_camera(const RunView& view, const std::string& name) {
  return view.camera(name, half_width_px(view.settings().width_px), view.settings().height_px);
}

PixelImage before_and_after(const RunView& view, const Camera& half, const PixelImage& before, const PixelImage& after,
                            const std::vector<std::pair<std::string, std::string>>& values) {
  Camera page = half;
  page.width_px = view.settings().width_px;
  PixelImage image = plain_image(page.width_px, page.height_px, kGap_rgb);
  image.paste(before, 0, 0);
  const int right_px = page.width_px - after.width_px;
  image.paste(after, right_px, 0);
  Labels labels = view.labels(half, std::nullopt);
  labels.title = "Before reaming";
  draw_labels(image, page, labels);
  Labels of_right;
  of_right.title = "After reaming";
  of_right.values = values;
  draw_value_box(image, page, of_right, right_px);
  return image;
}

}  // namespace reamsim

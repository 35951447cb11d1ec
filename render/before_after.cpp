#include "render/before_after.h"

#include <algorithm>
#include <utility>

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

BeforeAfter::BeforeAfter(Studio& studio, const std::string& camera,
                         std::vector<std::pair<std::string, std::string>> values)
    : camera_(studio.camera(camera, half_width_px(studio.settings().width_px), studio.settings().height_px)),
      values_(std::move(values)),
      after_(studio.photograph(camera_, std::nullopt)) {}

PixelImage BeforeAfter::finish(Studio& studio) const {
  Camera page = camera_;
  page.width_px = studio.settings().width_px;
  PixelImage image = plain_image(page.width_px, page.height_px, kGap_rgb);
  image.paste(studio.photograph(camera_, std::nullopt), 0, 0);
  const int right_px = page.width_px - after_.width_px;
  image.paste(after_, right_px, 0);
  Labels labels = studio.labels(camera_, std::nullopt);
  labels.title = "Before reaming";
  draw_labels(image, page, labels);
  Labels of_right;
  of_right.title = "After reaming";
  of_right.values = values_;
  draw_value_box(image, page, of_right, right_px);
  return image;
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/figures.h"

#include <algorithm>

#include "render/pictures/canvas.h"
#include "sim/base/text.h"
#include "sim/scenario/scenario.h"

namespace reamsim {
namespace {

constexpr double kHalfTitle = 27, kHalfHead = 56;  // pixels of a page 1080 high

/// The gap between the halves; it absorbs an odd width.
int gap_px(int width_px) {
  const int thin = std::max(1, width_px / 240);
  return width_px < 3 ? 0 : thin + (width_px - thin) % 2;
}

int half_width_px(const PageLayout& page) {
  return std::max(1, (page.view_width_px - gap_px(page.view_width_px)) / 2);
}

/// Height of the titles above the halves.
int half_head_px(const PageLayout& page) {
  return page.labelled() ? static_cast<int>(std::lround(kHalfHead * page.unit)) : 0;
}

/// Draws the title of a half above it, on a plate.
void draw_half_title(PixelImage& image, const PageLayout& page, const std::string& title, int left_px,
                     const Rgba& plate) {
  if (!page.labelled()) return;
  const double u = page.unit;
  const Canvas canvas(image);
  const TextLine text(canvas, title, kHalfTitle * u, true);
  const double y = 0.5 * (kHalfHead * u - text.height);
  canvas.fill_panel({left_px + 8 * u, y - 3 * u, text.width + 24 * u, text.height + 6 * u}, 6 * u, plate);
  text.draw(left_px + 20 * u, y);
  canvas.finish();
}

constexpr std::size_t kMaxFrames = 16;  // four rows of four fill the page
constexpr std::uint32_t kPage_rgb = 0xf4f6f9;
constexpr double kMargin = 24, kGap = 8, kCaption = 20;  // pixels of a page 1080 high and at least 1440 wide
constexpr int kMinCaptioned_px = 80;                     // captions of lower cells would be illegible

/// The camera of a cell that scaled_middle() makes of a picture.
Camera cell_camera(const SheetGrid& grid, const Camera& picture) {
  Camera out = picture;
  out.width_px = grid.cell_width_px;
  out.height_px = grid.cell_height_px;
  out.mm_per_px *= std::min(static_cast<double>(picture.width_px) / out.width_px,
                            static_cast<double>(picture.height_px) / out.height_px);
  return out;
}

}  // namespace

Camera half_camera(const RunView& view, const std::string& name) {
  const PageLayout page = view.page();
  return view.camera(name, half_width_px(page), page.height_px - half_head_px(page));
}

PixelImage before_and_after(const RunView& view, const Camera& half, const PixelImage& before, const PixelImage& after,
                            const Captions::Values& values, const std::vector<SeenContour>& contours) {
  const PageLayout page = view.page();
  const Background background = view.settings().background;
  const int head_px = half_head_px(page);
  const int right_px = page.view_width_px - after.width_px;
  PixelImage numbered = after;
  if (page.labelled()) draw_contour_numbers(numbered, half, page.unit, contours);
  PixelImage both = blank_page(page.view_width_px, page.height_px, background);
  both.paste(before, 0, head_px);
  both.paste(numbered, right_px, head_px);
  const Rgba plate = background == Background::transparent ? kPlateColor : Rgba{};
  draw_half_title(both, page, "Before reaming", 0, plate);
  draw_half_title(both, page, "After reaming", right_px, plate);
  Labels labels = view.labels(half, std::nullopt);
  labels.values = values;
  return annotated_picture(std::move(both), page, half, labels, background);
}

SheetGrid sheet_grid(int cells, int width_px, int height_px, double least_width) {
  const PageLayout page = page_layout(width_px, height_px);
  const double u = page.labelled() ? page.unit : 0;
  const Box area{kMargin * u, kMargin * u, page.view_width_px - 2 * kMargin * u, height_px - 2 * kMargin * u};
  SheetGrid best{.cells = cells, .area = area, .gap_px = static_cast<int>(kGap * u)};
  const double aspect = static_cast<double>(page.view_width_px) / height_px;  // of the pictures along the run
  for (int columns = 1; columns <= cells; ++columns) {
    const int rows = (cells + columns - 1) / columns;
    const double across = (area.width - (columns - 1) * best.gap_px) / columns;
    const double down = (area.height - (rows - 1) * best.gap_px) / rows;
    const int width = std::max(1, static_cast<int>(std::min(across, aspect * down)));
    const int height = std::max(1, static_cast<int>(std::min(down, width / (least_width * aspect))));
    if (width * height <= best.cell_width_px * best.cell_height_px) continue;
    best = {cells, columns, rows, width, height, area, best.gap_px};
  }
  return best;
}

std::vector<std::int64_t> ContactSheet::frames_on(const RunView& view) {
  return evenly_among(in_contact(view.frames(), view.run().contact()), kMaxFrames);
}

ContactSheet::ContactSheet(const RunView& view, const Camera& camera)
    : view_(view),
      grid_(sheet_grid(static_cast<int>(frames_on(view).size()), view.settings().width_px, view.settings().height_px,
                       camera.used_width)),
      camera_(cell_camera(grid_, camera)),
      page_(plain_image(view.page().view_width_px, view.page().height_px, kPage_rgb)) {}

void ContactSheet::add(PixelImage picture, const ForceRow& row) {
  PixelImage cell = scaled_middle(Canvas(picture).surface(), grid_.cell_width_px, grid_.cell_height_px);
  draw_marks(cell, camera_, picture_unit(cell.width_px, cell.height_px),
             view_.labels(camera_, view_.tool_at(row.frame)));
  if (cell.height_px >= kMinCaptioned_px) {
    const double u = view_.page().unit;
    const Canvas canvas(cell);
    const std::string pass = view_.run().inputs().passes.size() > 1 ? "pass " + std::to_string(row.pass) + " · " : "";
    const TextLine text(canvas, pass + fixed_text(row.time_s, 3) + " s · " + depth_text(row.depth_mm), kCaption * u);
    canvas.fill_panel({8 * u, 8 * u, text.width + 16 * u, text.height + 8 * u}, 5 * u);
    text.draw(16 * u, 12 * u);
    canvas.finish();
  }
  const int column = done_ % grid_.columns, line = done_ / grid_.columns;
  page_.paste(cell, static_cast<int>(grid_.area.x) + column * (grid_.cell_width_px + grid_.gap_px),
              static_cast<int>(grid_.area.y) + line * (grid_.cell_height_px + grid_.gap_px));
  if (done_++ == 0) first_s_ = row.time_s;
  last_s_ = row.time_s;
}

std::string ContactSheet::title() const {
  const std::vector<ForceRow>& rows = view_.run().log().rows;
  const double removed_mm3 = rows.back().removed_mm3;
  const auto first = std::ranges::find_if(rows, [](const ForceRow& row) { return row.removed_mm3 > 0; });
  const auto last = std::ranges::find_if(rows, [&](const ForceRow& row) { return row.removed_mm3 >= removed_mm3; });
  const auto span = [](double from_s, double to_s) {
    const std::string from = fixed_text(from_s, 2), to = fixed_text(to_s, 2);
    return to_s > from_s && from != to ? from + "–" + to + " s" : std::string();
  };
  std::vector<std::string> hidden;
  if (removed_mm3 > 0) {
    hidden.push_back(span(rows.front().time_s, std::min(first_s_, first->time_s)));
    if (view_.run().contact().size() > 1) hidden.emplace_back("between passes");
    hidden.push_back(span(std::max(last_s_, last->time_s), rows.back().time_s));
    std::erase(hidden, "");
  }
  std::string text = hidden.empty() ? "" : "; without contact, not shown: ";
  for (std::size_t i = 0; i < hidden.size(); ++i) {
    text += (i == 0 ? "" : i + 1 < hidden.size() ? ", " : i > 1 ? ", and " : " and ") + hidden[i];
  }
  return "Time and tool depth" + text;
}

PixelImage ContactSheet::finish() {
  Labels labels = view_.labels(camera_, std::nullopt);
  labels.title = title();
  labels.scale_bar_fraction = 0.5 * camera_.width_px / page_.width_px;
  return annotated_picture(std::move(page_), view_.page(), camera_, labels, Background::studio);
}

}  // namespace reamsim

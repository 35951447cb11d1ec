// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/film/film.h"

#include <algorithm>

#include "sim/base/text.h"

namespace reamsim {
namespace {

/// Background of transparent pictures.
constexpr std::uint32_t kBackground_rgb = 0xffffff;
constexpr double kPanelFraction = 0.36;
/// Smaller panels would be illegible.
constexpr int kMinPanel_px = 200;

std::vector<std::pair<std::string, std::string>> film_values(const ForceRow& row) {
  return {{"time", fixed_text(row.time_s, 3) + " s"},
          {"tool depth", depth_text(row.depth_mm)},
          {"removed", fixed_text(row.removed_mm3, 1) + " mm³"}};
}

/// The layout of the bone's part of a film.
PageLayout page_of(const FilmLayout& film) {
  return page_layout(static_cast<int>(film.bone.width), static_cast<int>(film.bone.height));
}

}  // namespace

FilmLayout film_layout(int width_px, int height_px) {
  FilmLayout out{even_px(width_px), even_px(height_px), {}, {}, 1};
  out.bone = {0, 0, static_cast<double>(out.width_px), static_cast<double>(out.height_px)};
  const bool portrait = out.height_px > out.width_px;
  const int panel_px = even_px(static_cast<int>(kPanelFraction * std::max(out.height_px, out.width_px)));
  if (std::min({panel_px, out.width_px, out.height_px}) < kMinPanel_px) return out;
  out.panel = out.bone;
  if (portrait) {
    out.bone.height -= panel_px;
    out.panel.y = out.bone.height;
    out.panel.height = panel_px;
    out.unit = std::min(out.width_px / 1000.0, panel_px / 620.0);
  } else {
    out.bone.width -= panel_px;
    out.panel.x = out.bone.width;
    out.panel.width = panel_px;
    out.unit = std::min(out.height_px / 1080.0, panel_px / 560.0);
  }
  return out;
}

Camera film_camera(const RunView& view, const std::string& name) {
  const PageLayout page = page_of(film_layout(view.settings().width_px, view.settings().height_px));
  return view.camera(name, page.view_width_px, page.height_px);
}

Film::Film(const std::string& path, const RunView& view, const Captions& captions, const Camera& camera)
    : view_(view),
      captions_(captions),
      layout_(film_layout(view.settings().width_px, view.settings().height_px)),
      camera_(camera),
      encoder_(path, view.settings()) {
  if (layout_.panel.width == 0) return;
  panel_ = std::make_unique<ForcePanel>(captions.log(), captions.mean(), static_cast<int>(layout_.panel.width),
                                        static_cast<int>(layout_.panel.height), layout_.unit);
}

void Film::add(PixelImage bone, const ForceRow& row) {
  Labels labels = view_.labels(camera_, view_.tool_at(row.frame));
  labels.values = film_values(row);
  labels.force = captions_.arrow(row);
  PixelImage frame = plain_image(layout_.width_px, layout_.height_px, kBackground_rgb);
  frame.paste(labelled_page(std::move(bone), page_of(layout_), camera_, labels, view_.settings().background), 0, 0);
  if (panel_) frame.paste(panel_->at(row), static_cast<int>(layout_.panel.x), static_cast<int>(layout_.panel.y));
  encoder_.add(frame);
}

}  // namespace reamsim

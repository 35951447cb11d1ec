// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/frame_schedule.h"

#include "render/film/film.h"
#include "render/pictures/composites.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

FrameSchedule::FrameSchedule(const RunView& view, const PictureOptions& options)
    : names(names_of(view.settings().cameras)), stills(options.stills) {
  const RenderSettings& settings = view.settings();
  const PageLayout page = view.page();
  for (const UserCamera& own : settings.user_cameras) names.push_back(own.name);
  for (const std::string& name : names) {
    cameras.push_back(view.camera(name, page.view_width_px, page.height_px));
    if (settings.before_after) halves.push_back(half_camera(view, name));
  }
  if (stills) still_frames = reamsim::still_frames(view.frames(), settings, view.run().contact());
  if (settings.contact_sheet) {
    sheet_frames = ContactSheet::frames_on(view);
    sheet = ContactSheet::cell_camera(view, names.front());
  }
  if (options.film && settings.film != FilmFormat::none) film = film_camera(view, names.front());
  for (int i = 0; i < settings.turntable_pictures; ++i) {
    const double turn = static_cast<double>(i) / settings.turntable_pictures;
    turntable.push_back(make_turntable_camera(view.run().target(), turn, page.view_width_px, page.height_px));
  }
}

int count_pictures(const PictureOptions& options, const std::vector<std::int64_t>& frames, const FrameSpans& contact) {
  const RenderSettings& settings = options.settings;
  const std::size_t cameras = settings.cameras.size() + settings.user_cameras.size();
  std::size_t sum = options.stills ? cameras * (1 + still_frames(frames, settings, contact).size()) : 0;
  if (settings.before_after) sum += cameras;
  if (settings.contact_sheet) ++sum;
  if (options.film && settings.film != FilmFormat::none) sum += frames.size();
  return static_cast<int>(sum) + settings.turntable_pictures;
}

}  // namespace reamsim

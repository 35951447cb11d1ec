// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/pictures/run_view.h"
#include "sim/base/error.h"
#include "sim/scan/segmentation.h"
#include "sim/scene/contact_forecast.h"

// Pictures and meshes of a run that need no OpenGL, and pages of several rendered pictures.

namespace reamsim {

/// Draws DIR/depth_map.csv as DIR/depth_map.png, if there is a map with reamed columns. `depth_max_mm` ends the legend;
/// 0: the greatest depth does. Throws InputError (damaged file), RunError (picture cannot be written).
void write_depth_picture(const RunData& run, double depth_max_mm);

/// Writes DIR/reamed.glb (depth colours up to `depth_max_mm`; 0: as in the pictures) and DIR/reamed.stl: the closed
/// surface of DIR/reamed.vdb, B, mm; or warns that no bone remains. Throws InputError (damaged result), RunError.
void write_meshes(const RunData& run, double depth_max_mm, Diagnostics& report);

/// Writes DIR/segmentation.png, if there are planes: the CT with the outline of the bone, to scale. Throws RunError.
void write_segmentation_picture(const std::string& dir, const Segmentation& segmentation);

/// What a picture of a scenario shows before it is run.
struct RunSetup {
  RunInputs inputs;  ///< without a folder: `dir` is empty
  ContactForecast contact;
  double frame_s = 0.001;
  RenderSettings settings;
};

/// Writes a PNG of bone, reamer and path: at the start, and the predicted bone at the greatest depth en face and in a
/// section; without contact three sides at the smallest distance. Returns Renderer::warning(). Throws RunError.
std::string write_setup_picture(const std::string& path, const RunSetup& setup);

/// Whether a file begins as such a picture does.
bool is_setup_picture(const std::string& path);

/// The camera `name` for one half of a picture of the bone before and after reaming, side by side below their titles.
Camera half_camera(const RunView& view, const std::string& name);

/// Composes such a picture from its halves. `values`, and `contours` that get their numbers, of the right half.
PixelImage before_and_after(const RunView& view, const Camera& half, const PixelImage& before, const PixelImage& after,
                            const Captions::Values& values, const std::vector<SeenContour>& contours);

/// The layout of a contact sheet.
struct SheetGrid {
  int cells = 0, columns = 0, rows = 0;
  int cell_width_px = 0, cell_height_px = 0;
  Box area;  ///< of all cells, with the gaps between them
  int gap_px = 0;
};
/// The layout with the largest cells that leaves room for title, legend and scale. Cells show at least `least_width`, a
/// fraction, of the width of a picture.
SheetGrid sheet_grid(int cells, int width_px, int height_px, double least_width);

/// The run in contact on one page: up to sixteen pictures of one camera, reduced, without what is beside the target if
/// they fill the page better so. The title says what is not shown.
class ContactSheet {
 public:
  /// The frames with a cell, ascending.
  static std::vector<std::int64_t> frames_on(const RunView& view);

  /// `camera`: of the pictures. The page has the settings' size. `view` outlives the sheet.
  ContactSheet(const RunView& view, const Camera& camera);

  /// Adds the next cell: a picture without labels, of the frame of this row of the log.
  void add(PixelImage picture, const ForceRow& row);
  /// Whether it has all cells.
  [[nodiscard]] bool is_full() const { return done_ == grid_.cells; }
  [[nodiscard]] PixelImage finish();

 private:
  [[nodiscard]] std::string title() const;

  const RunView& view_;
  SheetGrid grid_;
  Camera camera_;  ///< of a cell
  PixelImage page_;
  int done_ = 0;
  double first_s_ = 0;  ///< time of the first cell
  double last_s_ = 0;
};

}  // namespace reamsim

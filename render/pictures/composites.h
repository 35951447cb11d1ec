// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "render/pictures/run_view.h"
#include "sim/record/force_log.h"

namespace reamsim {

/// The camera `name` for one half of a picture of the bone before and after reaming, side by side below their titles.
Camera half_camera(const RunView& view, const std::string& name);

/// Composes such a picture from its halves. `values`, and `contours` that get their numbers, of the right half.
PixelImage before_and_after(const RunView& view, const Camera& half, const PixelImage& before, const PixelImage& after,
                            const std::vector<std::pair<std::string, std::string>>& values,
                            const std::vector<SeenContour>& contours);

/// The layout of a contact sheet.
struct SheetGrid {
  int cells = 0, columns = 0, rows = 0;
  int cell_width_px = 0, cell_height_px = 0;
  Box area;  ///< of all cells, with the gaps between them
  int gap_px = 0;
};
/// The layout with the largest cells that leaves room for title, legend and scale.
SheetGrid sheet_grid(int cells, int width_px, int height_px);

/// The run in contact on one page: up to twenty small pictures of one camera. The title says what is not shown.
class ContactSheet {
 public:
  /// The frames with a cell, ascending.
  static std::vector<std::int64_t> frames_on(const RunView& view);
  /// The camera `name` for a cell.
  static Camera cell_camera(const RunView& view, const std::string& name);

  /// `cell`: camera of the cells. The page has the settings' size. `view` outlives the sheet.
  ContactSheet(const RunView& view, const Camera& cell);

  /// Adds the next cell: the frame of this row of the log.
  void add(PixelImage cell, const ForceRow& row);
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

#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "render/pictures/run_view.h"
#include "sim/record/force_log.h"

namespace reamsim {

/// The camera called `name` for one half of a picture with the bone before and after, side by side. The whole has the
/// settings' size.
Camera half_camera(const RunView& view, const std::string& name);

/// Puts such a picture together from its halves. `values`: name and number with unit, one per line, for the right one.
PixelImage before_and_after(const RunView& view, const Camera& half, const PixelImage& before, const PixelImage& after,
                            const std::vector<std::pair<std::string, std::string>>& values);

/// How many columns and rows of cells a sheet has, and how large a cell is.
struct SheetGrid {
  int columns, rows;
  int cell_width_px, cell_height_px;
  Box area;  ///< of all cells, with the gaps between them
  int gap_px;
};
/// The grid for `cells` cells on a page, with room for title, legend and scale. The cells are as large as they can be.
SheetGrid sheet_grid(int cells, int width_px, int height_px);

/// The run on one page: up to twenty small pictures by one camera, each with its time and depth.
class ContactSheet {
 public:
  /// The frames that have a cell, ascending.
  static std::vector<std::int64_t> frames_on(const RunView& view);
  /// The camera called `name`, for a cell of the sheet.
  static Camera cell_camera(const RunView& view, const std::string& name);

  /// Of cells by that camera. The page has the settings' size. `view` outlives the sheet.
  ContactSheet(const RunView& view, const Camera& cell);

  /// The next cell, of the frame at this row of the log.
  void add(PixelImage cell, const ForceRow& row);
  /// The page, with its labels.
  [[nodiscard]] PixelImage finish();

 private:
  const RunView& view_;
  SheetGrid grid_;
  Camera camera_;  ///< of a cell
  PixelImage page_;
  int done_ = 0;
};

}  // namespace reamsim

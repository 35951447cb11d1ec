#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/studio.h"

namespace reamsim {

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
  /// `camera`: its name. The page has the settings' size.
  ContactSheet(const Studio& studio, const std::string& camera);

  /// Takes a cell's picture when this frame is on the sheet.
  void add(Studio& studio, std::int64_t frame);
  /// The page, with its labels.
  [[nodiscard]] PixelImage finish(const Studio& studio);

 private:
  std::vector<std::int64_t> frames_;
  SheetGrid grid_;
  Camera camera_;  ///< of a cell
  PixelImage page_;
  int done_ = 0;
};

}  // namespace reamsim

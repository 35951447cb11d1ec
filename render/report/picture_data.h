#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace reamsim {

/// A picture as the page holds it: a JPEG in base 64.
struct PagePicture {
  std::string name;  ///< of the file it was made from, without folder and ending
  int width_px = 0;
  int height_px = 0;
  std::string jpeg_base64;
};

/// PNG files as JPEGs in base 64, each at most `most_px` wide. When together they are more than `most_bytes`, all are
/// made smaller until they fit, or until they are an eighth as wide.
/// Throws InputError when one cannot be read.
std::vector<PagePicture> page_pictures(const std::vector<std::string>& paths, int most_px, std::size_t most_bytes);

/// At most `most` of `count` items, evenly spread, the first and the last among them; ascending.
std::vector<std::size_t> evenly_chosen(std::size_t count, std::size_t most);

}  // namespace reamsim

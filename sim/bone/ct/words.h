#pragma once

#include <cstdio>
#include <string>

#include "sim/base/geometry.h"

namespace reamsim::ct {

/// printf into a string of at most 255 characters: for numbers in messages, not for paths.
template <typename... Values>
std::string words(const char* format, Values... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

inline std::string point_words(const Vec3& p) {
  return words("(%.1f, %.1f, %.1f)", p.x(), p.y(), p.z());
}

inline std::string box_words(const Aabb& box) {
  return point_words(box.min) + " to " + point_words(box.max) + " mm";
}

}  // namespace reamsim::ct

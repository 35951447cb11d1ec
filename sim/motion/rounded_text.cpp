#include "sim/motion/rounded_text.h"

#include <cstdio>

namespace reamsim {

std::string rounded_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

}  // namespace reamsim

#include "sim/motion/number_text.h"

#include <cstdio>

namespace reamsim {

std::string number_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

}  // namespace reamsim

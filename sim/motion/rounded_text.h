#pragma once

#include <string>

namespace reamsim {

/// A number as a user would write it, six digits at most: "0.25", "1e+07", "nan".
std::string rounded_text(double value);

}  // namespace reamsim

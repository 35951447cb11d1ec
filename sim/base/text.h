#pragma once

#include <string>

namespace reamsim {

/// A number with `decimals`, never "-0.0".
std::string fixed_text(double value, int decimals);

/// The tool depth in pictures: "1.25 mm", or "lifted" above the first contact.
std::string depth_text(double depth_mm);

/// At most six significant digits: "0.25", "1e+07", "nan".
std::string rounded_text(double value);

/// The fewest digits that read back to the same value.
std::string shortest_text(double value);

/// Whole megabytes, 10⁶ bytes, rounded up: "12 MB".
std::string megabytes(std::size_t bytes);

}  // namespace reamsim

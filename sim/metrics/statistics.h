#pragma once

#include <vector>

namespace reamsim {

/// The arithmetic mean; 0 of nothing.
double mean(const std::vector<double>& values);

/// The value below which a share (0…1) of the values lies, linear between neighbours in order (type 7 of Hyndman and
/// Fan 1996, The American Statistician 50, 361–365; numpy's default); 0 of nothing.
double quantile(std::vector<double> values, double fraction);

}  // namespace reamsim

#pragma once

#include <string>
#include <vector>

namespace reamsim {

/// Writes `text` to `script` in the folder `dir` and runs gnuplot on it there. Throws RunError when the script cannot
/// be written, gnuplot is missing or complains, or one of `pictures` (names in `dir`) is not there afterwards.
void run_gnuplot(const std::string& dir, const std::string& script, const std::string& text,
                 const std::vector<std::string>& pictures);

}  // namespace reamsim

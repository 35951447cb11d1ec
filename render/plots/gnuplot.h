#pragma once

#include <string>
#include <vector>

namespace reamsim {

/// `text` as a string of gnuplot: in single quotes, within which gnuplot expands nothing. Double quotes would run what
/// stands between backticks as a command. Control characters become spaces.
std::string gnuplot_string(const std::string& text);

/// Writes `text` to `script` in the folder `dir` and runs gnuplot on it there. Throws RunError when the script cannot
/// be written, gnuplot is missing or complains, or one of `pictures` (names in `dir`) is not there afterwards.
void run_gnuplot(const std::string& dir, const std::string& script, const std::string& text,
                 const std::vector<std::string>& pictures);

}  // namespace reamsim

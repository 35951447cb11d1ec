#pragma once

#include <fstream>
#include <initializer_list>
#include <string>
#include <vector>

namespace reamsim {

/// A CSV file with a header line. Numbers are written with the fewest digits that read back to the same value, so the
/// same run gives the same bytes; NaN is an empty cell.
class CsvLog {
 public:
  /// Throws RunError when the file cannot be made.
  CsvLog(const std::string& path, const std::string& header);
  void row(std::initializer_list<double> values);
  /// Throws RunError when not all could be written.
  void close();

 private:
  void check() const;

  std::string path_;
  std::ofstream out_;
};

}  // namespace reamsim

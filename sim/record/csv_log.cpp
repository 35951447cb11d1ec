#include "sim/record/csv_log.h"

#include <charconv>
#include <cmath>

#include "sim/base/error.h"

namespace reamsim {

CsvLog::CsvLog(const std::string& path, const std::string& header) : path_(path), out_(path, std::ios::binary) {
  out_ << header << '\n';
  check();
}

void CsvLog::row(std::initializer_list<double> values) {
  std::string line;
  char digits[32];
  bool first = true;
  for (const double value : values) {
    if (!first) line += ',';
    first = false;
    if (std::isnan(value)) continue;
    // −0 and 0 are the same number to a reader.
    const auto end = std::to_chars(digits, digits + sizeof digits, value == 0 ? 0.0 : value).ptr;
    line.append(digits, end);
  }
  out_ << line << '\n';
  check();
}

void CsvLog::close() {
  out_.close();
  check();
}

void CsvLog::check() const {
  if (!out_) throw RunError(path_ + ": cannot be written; is the disk full or the folder read-only?");
}

}  // namespace reamsim

#include "sim/record/csv_log.h"

#include <cmath>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

CsvLog::CsvLog(const std::string& path, const std::string& header) : path_(path), out_(path, std::ios::binary) {
  out_ << header << '\n';
  check();
}

void CsvLog::row(std::initializer_list<double> values) {
  std::string line;
  bool first = true;
  for (const double value : values) {
    if (!first) line += ',';
    first = false;
    if (std::isnan(value)) continue;
    // −0 and 0 are the same number to a reader.
    line += shortest_text(value == 0 ? 0.0 : value);
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

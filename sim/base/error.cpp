#include "sim/base/error.h"

namespace reamsim {

std::string SourceLocation::text() const {
  std::string out = file;
  if (line > 0) out += ":" + std::to_string(line);
  if (line > 0 && column > 0) out += ":" + std::to_string(column);
  return out;
}

namespace {

std::string compose(const SourceLocation& where, const std::string& key, const std::string& found,
                    const std::string& expected) {
  std::string out = where.text();
  if (!key.empty()) out += (out.empty() ? "" : ": ") + key;
  if (!found.empty()) out += (out.empty() ? "" : ": ") + found;
  if (!expected.empty()) out += "; " + expected;
  return out;
}

}  // namespace

InputError::InputError(const SourceLocation& where, const std::string& key, const std::string& found,
                       const std::string& expected)
    : std::runtime_error(compose(where, key, found, expected)) {}

}  // namespace reamsim

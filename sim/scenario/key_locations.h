#pragma once

#include <map>
#include <string>

#include "sim/base/error.h"

namespace reamsim {

/// Where each key of a scenario stands, by path ("motion.keyframes.0.time_s"); a key that is absent stands where its
/// section does.
class KeyLocations {
 public:
  void set(const std::string& path, const SourceLocation& where, bool given);
  [[nodiscard]] SourceLocation of(const std::string& path) const;
  /// Whether the file (or --set) has the key.
  [[nodiscard]] bool given(const std::string& path) const;
  /// The same mistakes with the place of their key, where they name a key and no place: what is found out only when
  /// the data are there.
  [[nodiscard]] InputError located(const InputError& error) const;

 private:
  struct Place {
    SourceLocation where;
    bool given = false;
  };
  std::map<std::string, Place> places_;
};

}  // namespace reamsim

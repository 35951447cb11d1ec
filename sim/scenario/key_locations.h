// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <string>

#include "sim/base/error.h"

namespace reamsim {

/// The place of each key in the scenario file, by path ("motion.keyframes.0.time_s"). A missing key has the place of
/// its section.
class KeyLocations {
 public:
  void set(const std::string& path, const SourceLocation& where, bool given);
  [[nodiscard]] SourceLocation of(const std::string& path) const;
  /// Whether the file (or --set) has the key.
  [[nodiscard]] bool given(const std::string& path) const;
  /// Adds the place of the key to those mistakes that name a key and no place. Mistakes that are found only once the
  /// data are loaded need it.
  [[nodiscard]] InputError located(const InputError& error) const;

 private:
  struct Place {
    SourceLocation where;
    bool given = false;
  };
  std::map<std::string, Place> places_;
};

}  // namespace reamsim

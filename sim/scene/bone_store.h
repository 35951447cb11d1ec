// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <utility>
#include <vector>

#include "sim/bone/bone.h"

namespace reamsim {

/// Bones that were loaded before, on disk: in XDG_CACHE_HOME/reamsim/bones, else HOME/.cache/reamsim/bones, readable by
/// this user alone. A bone is found by the bytes of its files, by every setting of the bone, and by the build of this
/// program. Its file is encrypted with a key made of these, so that only who has the scan can read it, and names no
/// patient. The environment variable REAMSIM_CACHE=off turns it off.
class BoneStore {
 public:
  static constexpr std::uintmax_t kMostBytes = 2'000'000'000;      ///< of all files; the least recently used ones go
  static constexpr std::uintmax_t kMostBytesOfBone = 100'000'000;  ///< larger bones are not kept

  /// `folder`: empty: none is kept. `most_bytes`: of all files.
  explicit BoneStore(std::filesystem::path folder = usual_folder(false), std::uintmax_t most_bytes = kMostBytes)
      : folder_(std::move(folder)), most_bytes_(most_bytes) {}
  /// Empty where it is turned off or the user has no home.
  static std::filesystem::path usual_folder(bool even_if_off = false);

  /// The bone that `load` returns, with what it reports; from the disk where it is there, undamaged. Where it cannot be
  /// kept, nothing is said. Throws what `load` throws, with `report` of the time before.
  Bone find_or_load(const BoneSettings& settings, Diagnostics& report,
                    const std::function<Bone(Diagnostics& report)>& load) const;

  /// Number and bytes of its files.
  [[nodiscard]] std::pair<int, std::uintmax_t> size() const;
  /// Removes its files.
  void clear() const { remove_beyond(0); }

 private:
  struct StoredFile {
    std::filesystem::file_time_type used;
    std::uintmax_t bytes;
    std::filesystem::path path;
  };
  [[nodiscard]] std::vector<StoredFile> files() const;
  void remove_beyond(std::uintmax_t most_bytes) const;

  std::filesystem::path folder_;
  std::uintmax_t most_bytes_;
};

}  // namespace reamsim

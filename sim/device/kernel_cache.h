// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace reamsim::cl {

/// A folder for compiled kernels. PoCL keeps them in POCL_CACHE_DIR, else in XDG_CACHE_HOME/pocl/kcache, else in
/// HOME/.cache/pocl/kcache, and has no device where it cannot write there. In that case, and where none of these
/// variables is set, POCL_CACHE_DIR is set to a folder of this user in TMPDIR or /tmp, which later runs find again.
/// Create it before the first call of OpenCL and before other threads.
class KernelCache {
 public:
  /// Throws InputError where there is no writable folder at all.
  KernelCache();
  ~KernelCache();
  KernelCache(const KernelCache&) = delete;
  KernelCache& operator=(const KernelCache&) = delete;

  /// Why the usual folder is not used, and which is instead; "": it is used.
  [[nodiscard]] const std::string& note() const { return note_; }

 private:
  std::string temporary_;  ///< removed at the end; "" where the folder is kept
  std::string note_;
};

}  // namespace reamsim::cl

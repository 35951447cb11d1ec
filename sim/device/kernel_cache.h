// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace reamsim::cl {

/// A folder for compiled kernels. PoCL keeps them in POCL_CACHE_DIR, else in XDG_CACHE_HOME/pocl/kcache, else in
/// HOME/.cache/pocl/kcache, and has no device where it cannot write there. In that case POCL_CACHE_DIR is set to a
/// temporary folder as long as this object lives. Create it before the first call of OpenCL and before other threads.
class KernelCache {
 public:
  /// Throws InputError where there is no writable folder at all.
  KernelCache();
  ~KernelCache();
  KernelCache(const KernelCache&) = delete;
  KernelCache& operator=(const KernelCache&) = delete;

  /// Names the folder that cannot be written, and its variable; "": the usual folder is used.
  [[nodiscard]] const std::string& warning() const { return warning_; }

 private:
  std::string temporary_;
  std::string warning_;
};

}  // namespace reamsim::cl

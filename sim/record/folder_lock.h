// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/error.h"

namespace reamsim {

/// Another process has reserved a results folder.
class FolderInUse : public InputError {
 public:
  using InputError::InputError;
};

/// Reserves a results folder for this process while this object exists, so that two runs never write into one folder.
/// The lock is the file DIR.lock, which names its holder and disappears with this object. After a crash the system
/// releases it; the file that stays then does not matter.
class FolderLock {
 public:
  /// Throws FolderInUse (the message says by which process), or InputError: the file cannot be created, or is not a
  /// lock. On file systems without locks it only creates the file.
  explicit FolderLock(const std::string& dir);
  ~FolderLock();
  /// Releases the lock early.
  void release();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  void describe_holder() const;

  std::string path_;
  int descriptor_ = -1;
};

}  // namespace reamsim

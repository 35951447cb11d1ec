// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <iostream>
#include <sstream>
#include <string>

namespace reamsim::ct {

/// Suppresses the output of ITK, GDCM, MetaIO and NIfTI during its lifetime. These libraries print warnings about
/// damaged files, where a user should see only the message of the exception. Not for concurrent use.
class QuietLibraries {
 public:
  QuietLibraries();
  ~QuietLibraries();
  QuietLibraries(const QuietLibraries&) = delete;
  QuietLibraries& operator=(const QuietLibraries&) = delete;

  /// Whether MetaIO or GDCM printed that voxels are missing. They report it in no other way.
  [[nodiscard]] bool reports_missing_voxels() const;

 private:
  std::ostringstream captured_;
  std::streambuf* cerr_;
  std::streambuf* cout_;
  int stderr_ = -1;  ///< copy of the file descriptor of stderr
};

}  // namespace reamsim::ct

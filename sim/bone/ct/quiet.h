#pragma once

#include <iostream>
#include <memory>
#include <sstream>
#include <string>

namespace reamsim::ct {

/// While it lives, ITK, GDCM, MetaIO and NIfTI print nothing. They write warnings about damaged files straight to the
/// standard streams, where a user must find one line that says what is wrong: the exception's. Not for concurrent use.
class QuietLibraries {
 public:
  QuietLibraries();
  ~QuietLibraries();
  QuietLibraries(const QuietLibraries&) = delete;
  QuietLibraries& operator=(const QuietLibraries&) = delete;

  /// What they would have printed.
  [[nodiscard]] std::string output() const { return swallowed_.str(); }

 private:
  std::ostringstream swallowed_;
  std::streambuf* cerr_;
  std::streambuf* cout_;
  int stderr_ = -1;  ///< the file descriptor that stderr had
};

}  // namespace reamsim::ct

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <string>

namespace reamsim::test {

/// How work that may crash ended, and what it took.
struct Verdict {
  int signal = 0;         ///< that ended the process; 0: none
  bool accepted = false;  ///< no error
  std::string message;    ///< of the InputError
  std::string failure;    ///< of another exception, or "exited"
  double seconds = 0;
  double peak_mb = 0;  ///< of the process and of those that it started, MB = 10⁶ bytes
};

/// Does `work` in a process of its own, which is killed after a minute and may hold 6 GB of address space.
Verdict supervised(const std::function<void()>& work);

}  // namespace reamsim::test

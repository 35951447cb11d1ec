// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace reamsim::reference {

/// Threads that do the same work together, the caller's among them. They wait a moment with open eyes before they
/// sleep, because the next pass of a frame follows at once.
class Workers {
 public:
  /// `count`: threads with the caller's, at least 1.
  explicit Workers(unsigned count);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Runs `work` on every thread and returns when all have.
  void run(const std::function<void()>& work);

 private:
  void serve();

  const std::function<void()>* work_ = nullptr;  // nullptr: leave
  std::atomic<unsigned> round_{0};
  std::atomic<unsigned> busy_{0};
  std::vector<std::thread> threads_;
};

}  // namespace reamsim::reference

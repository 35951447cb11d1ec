// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/run_table.h"

#include <random>

namespace reamsim {

const char* name_of(RunState state) {
  static const char* const names[] = {"missing", "interrupted", "failed", "done"};  // in the order of RunState
  return names[static_cast<std::size_t>(state)];
}

std::vector<bool> runs_of_table(std::size_t all, std::size_t most) {
  std::vector<bool> taken(all, all <= most);
  // Every k-th run would miss levels of the parameters that change fastest. Selection sampling (Knuth, The Art of
  // Computer Programming 2, 3.4.2, algorithm S), by integers alone.
  std::mt19937_64 random(1);
  std::size_t wanted = all <= most ? 0 : most;
  for (std::size_t i = 0; i < all && wanted > 0; ++i) {
    if (random() % (all - i) >= wanted) continue;
    taken[i] = true;
    --wanted;
  }
  return taken;
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/bench/reference/targets.h"

#include <string>

#include "sim/base/error.h"

namespace reamsim::reference {

const char* name_of(Target target) {
  return target == Target::avx512 ? "AVX-512" : target == Target::avx2 ? "AVX2" : "plain";
}

std::vector<Target> usable_targets() {
  std::vector<Target> out{Target::plain};
#ifdef REAMSIM_REFERENCE_X86
  const bool avx2 = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
  const bool avx512 = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
                      __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0;
  if (avx2) out.push_back(Target::avx2);
  if (avx2 && avx512) out.push_back(Target::avx512);
#endif
  return out;
}

void check_compiled(Target target) {
#ifdef REAMSIM_REFERENCE_X86
  const bool compiled = true;
#else
  const bool compiled = target == Target::plain;
#endif
  if (!compiled) throw RunError(std::string(name_of(target)) + " is not compiled here");
}

}  // namespace reamsim::reference

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

namespace reamsim::reference {

/// Instruction sets that the passes are compiled for.
enum class Target { plain, avx2, avx512 };
const char* name_of(Target target);
/// Those that this processor has, the fastest last.
std::vector<Target> usable_targets();
/// Throws RunError for one that is not compiled here.
void check_compiled(Target target);

}  // namespace reamsim::reference

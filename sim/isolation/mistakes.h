// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/error.h"
#include "sim/isolation/child_result.h"

namespace reamsim {

/// Writes the mistakes of an error, in the child.
void put_mistakes(ResultWriter& out, const InputError& error);

/// Throws the error that put_mistakes() wrote, in the parent.
[[noreturn]] void throw_mistakes(ResultReader& in);

}  // namespace reamsim

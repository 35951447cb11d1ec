// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>

namespace reamsim::test {

// The state of the fault library, which the intercepted calls ask.

enum class FaultKind { none, write, rename, allocation };

/// Counts a call and says whether it must fail.
/// `write_half`: set where a write may store half of its bytes first, as a disk does that becomes full.
bool must_fail(FaultKind kind, const char* call, const char* path, bool* write_half = nullptr);

/// Whether faults of this kind are injected at all, now, in this process.
bool injects(FaultKind kind);

/// Whether a path is one that may fail.
bool is_watched(const char* path);

/// Whether an allocation of this size may fail.
bool is_large(std::size_t bytes);

/// The path of an open file, in a buffer of the thread; "" if it has none.
const char* path_of(int descriptor);

/// The error code of a failed call.
int fault_error();

/// Whether renameat2() has no flags, as on some file systems.
bool refuses_exchange();

/// The call of this name that the library hides.
void* next_symbol(const char* name);

}  // namespace reamsim::test

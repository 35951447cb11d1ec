// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace reamsim {

/// Returns memory that was freed to the system. Call it after a stage with much temporary memory: the C library would
/// keep it, and the next stage would add to the peak.
void return_free_memory();

/// The limit of the address space of this process (`ulimit -v`), bytes; none: unlimited.
std::optional<std::uint64_t> address_space_limit();

/// The address space that this process has reserved, bytes; 0 where the system does not say.
std::uint64_t address_space_in_use();

/// "the address space is limited to 300 MB (ulimit -v)"; "" where it is not.
std::string address_space_note();

}  // namespace reamsim

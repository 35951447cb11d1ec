#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace reamsim {

/// Whether `work` comes to an end without an exception when a child process does it first, with bounded memory
/// (`memory_bytes` beyond what this process has) and time (`seconds`). For libraries that damaged input can crash or
/// send into endless loops: the child's fate harms nobody, and what `work` changes is lost with it. `work` must start
/// no threads. True as well where no child can be made.
bool succeeds_in_child(const std::function<void()>& work, std::uint64_t memory_bytes, int seconds);

}  // namespace reamsim

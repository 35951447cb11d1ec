#pragma once

#include <cstddef>
#include <functional>

namespace reamsim {

/// Work on the items `begin`…`end` − 1.
using RangeBody = std::function<void(std::size_t begin, std::size_t end)>;

/// Splits the items 0…count − 1 into ranges and runs `body` on all of them with the host's threads; returns when the
/// last one is done. The only way in which this project hands work to oneTBB: under the thread sanitizer, which cannot
/// look into Debian's oneTBB, plain threads do it instead, and oneTBB has none.
/// @param count how many items there are
/// @param grain items that are not worth splitting further: a range has at least half as many, where there are enough
/// @param body called from several threads at once, in no order
/// @throws what `body` throws; if several do, one of them
void parallel_ranges(std::size_t count, std::size_t grain, const RangeBody& body);

/// Calls body(i) for every item 0…count − 1, in the way of parallel_ranges().
template <typename ItemBody>
void parallel_items(std::size_t count, const ItemBody& body) {
  parallel_ranges(count, 1, [&body](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

}  // namespace reamsim

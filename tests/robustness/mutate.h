#pragma once

#include <random>
#include <string>

namespace reamsim::test {

using Random = std::mt19937_64;

/// Damages a file in one to three ways: bytes, numbers, lines of a header, length, blocks.
std::string mutated(std::string bytes, Random& random);

}  // namespace reamsim::test

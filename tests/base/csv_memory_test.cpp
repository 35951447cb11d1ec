// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Every allocation of a writer of CSV fails once. This program's operator new does that.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <string>

#include "sim/base/csv.h"
#include "sim/base/file.h"

namespace {

thread_local long allocations_left = -1;  // -1: none fails

}  // namespace

// Not inlined: GCC would take free() for another allocator's than new.
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  if (allocations_left == 0) {
    allocations_left = -1;
    throw std::bad_alloc();
  }
  if (allocations_left > 0) --allocations_left;
  if (void* const memory = std::malloc(bytes == 0 ? 1 : bytes)) return memory;
  throw std::bad_alloc();
}

[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}

[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace reamsim {
namespace {

/// Writes rows of which the n-th allocation fails, if there are as many. Returns whether it failed.
bool write_with_failure(const std::string& path, long n) {
  CsvWriter log(path, "a,b,c");
  // Longer than a string holds without memory of its own.
  constexpr std::array row{-1.0000000000000002e-100, 2.0000000000000004e-100, -3.0000000000000004e-100};
  allocations_left = n;
  try {
    for (int i = 0; i < 20; ++i) log.row(row);
  } catch (const std::bad_alloc&) {
    return true;
  }
  allocations_left = -1;
  return false;
}

TEST(CsvMemory, RowsAreWholeWhereMemoryIsExhausted) {
  const std::string path = testing::TempDir() + "exhausted.csv";
  long failures = 0;
  while (write_with_failure(path, failures)) {
    ++failures;
    const std::string text = read_file(path, "");
    ASSERT_TRUE(text.ends_with("\n")) << "allocation " << failures << "\n" << text;
  }
  EXPECT_GT(failures, 20);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace reamsim

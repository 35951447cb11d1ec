// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/value_file.h"

namespace reamsim {

// What a child process hands back: numbers, texts and arrays, one after the other in memory that it shares with its
// parent. The parent reads them in the same order, and trusts none of them.

/// A plain value: the same bytes in child and parent.
template <class T>
concept PlainValue = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>;

/// A file, and the scenario key that names it, for messages.
struct ForeignFile {
  std::string path;
  std::string key;

  /// The mistake of this file.
  [[nodiscard]] InputError error(const std::string& found, const std::string& expected) const {
    return {{path}, key, found, expected};
  }

  static auto fields(auto& self) { return std::tie(self.path, self.key); }
};

/// How the work of a child ended.
enum class ChildOutcome : std::uint32_t { died, done, wrong_input, failed, out_of_memory, result_too_large };

/// Memory that child processes share with this one. Its pages are taken from the system when they are written.
class SharedMemory {
 public:
  struct Handle {
    int id = -1;
    std::uint64_t capacity = 0;
  };

  /// At most `result_bytes` of result; less where the address space is limited. Throws RunError.
  explicit SharedMemory(std::uint64_t result_bytes);
  /// That of the parent, in a child. Throws RunError.
  explicit SharedMemory(const Handle& handle);
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  /// What lies before the result.
  struct Head {
    static constexpr std::size_t kPathBytes = 8192;
    ChildOutcome outcome = ChildOutcome::died;
    std::atomic<std::uint64_t> bytes = 0;       ///< of the result so far
    std::atomic<std::uint64_t> files_read = 0;  ///< files that the child has begun to read
    char path[kPathBytes] = {};                 ///< the last of them; "" = the first file
  };

  [[nodiscard]] Handle handle() const { return {id_, capacity_}; }
  [[nodiscard]] Head& head() const { return *static_cast<Head*>(memory_); }
  [[nodiscard]] std::byte* result() const { return static_cast<std::byte*>(memory_) + kHeadBytes; }
  [[nodiscard]] std::uint64_t capacity() const { return capacity_; }

 private:
  static constexpr std::size_t kHeadBytes = 16384;

  int id_ = -1;
  void* memory_ = nullptr;
  std::uint64_t capacity_ = 0;
};

class ResultTooLarge {};

/// Writes a result, in the child, and before that the arguments, in the parent.
class ResultWriter : public ValueOutput<ResultWriter> {
 public:
  explicit ResultWriter(SharedMemory& memory) : memory_(memory) {}

  void copy(const void* first, std::size_t count) { std::memcpy(take(count, 1), first, count); }
  using ValueOutput::items_of;
  template <PlainValue T>
  void items_of(const std::vector<T>& values) {
    T* place = array<T>(values.size());
    if (!values.empty()) std::memcpy(place, values.data(), values.size() * sizeof(T));
  }
  /// An array of `count` values for the caller to fill.
  template <PlainValue T>
  T* array(std::size_t count) {
    put(std::uint64_t{count});
    if (count > memory_.capacity() / sizeof(T)) throw ResultTooLarge();
    return reinterpret_cast<T*>(take(count * sizeof(T), kAlignment));
  }

  /// Says which file is read from now on. The limit of time counts anew, and an error names this file.
  void begin_file(const std::string& path);
  void clear() { memory_.head().bytes = 0; }

  static constexpr std::size_t kAlignment = 16;

 private:
  std::byte* take(std::uint64_t bytes, std::size_t alignment);

  SharedMemory& memory_;
};

/// Reads a result, in the parent, and before that the arguments, in the child. Throws InputError, with the file, where
/// the result ends too early.
class ResultReader : public ValueInput<ResultReader> {
 public:
  ResultReader(std::shared_ptr<const SharedMemory> memory, ForeignFile file);
  explicit ResultReader(const std::vector<std::byte>& bytes) : result_(bytes.data()), bytes_(bytes.size()) {}

  const void* next(std::uint64_t bytes, std::uint64_t alignment = 1);
  [[nodiscard]] std::size_t bytes_left() const { return bytes_; }  ///< at most
  std::string text() { return take<std::string>(); }
  std::vector<std::string> texts() { return take<std::vector<std::string>>(); }
  /// Calls `use` with the first and the end of each block of an array. Its pages return to the system, so that the
  /// array does not exist twice.
  template <PlainValue T, class Use>
  void for_each_block(std::uint64_t count, const Use& use) {
    if (count > bytes_ / sizeof(T)) fail();
    const auto* values = static_cast<const T*>(next(count * sizeof(T), ResultWriter::kAlignment));
    constexpr std::uint64_t kBlock = (std::uint64_t{4} << 20) / sizeof(T);
    for (std::uint64_t first = 0; first < count; first += kBlock) {
      const std::uint64_t end = std::min(count, first + kBlock);
      use(values + first, values + end);
      give_back(reinterpret_cast<const std::byte*>(values + first), (end - first) * sizeof(T));
    }
  }
  using ValueInput::items_of;
  template <PlainValue T>
  void items_of(std::vector<T>& out) {
    const auto count = take<std::uint64_t>();
    out.clear();
    out.reserve(std::min(count, bytes_ / sizeof(T)));
    for_each_block<T>(count, [&](const T* first, const T* last) { out.insert(out.end(), first, last); });
  }
  /// An array that has to have `count` values.
  template <PlainValue T>
  std::vector<T> array_of(std::size_t count) {
    auto out = take<std::vector<T>>();
    if (out.size() != count) fail();
    return out;
  }
  /// Calls `use` with each value of an array.
  template <PlainValue T, class Use>
  void for_each_in_array(const Use& use) {
    for_each_block<T>(take<std::uint64_t>(), [&](const T* first, const T* last) { std::for_each(first, last, use); });
  }
  [[noreturn]] void fail() const;

 private:
  static void give_back(const std::byte* first, std::uint64_t bytes);

  std::shared_ptr<const SharedMemory> memory_;  ///< that holds the result
  const std::byte* result_;
  std::uint64_t bytes_;
  std::uint64_t place_ = 0;
  ForeignFile file_;
};

}  // namespace reamsim

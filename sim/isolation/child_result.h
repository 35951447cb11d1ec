// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"

namespace reamsim {

// What a child process hands back: numbers, texts and arrays, one after the other in memory that it shares with its
// parent. The parent reads them in the same order, and trusts none of them.

/// A plain value: the same bytes in child and parent.
template <class T>
concept PlainValue = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>;

/// A struct whose static fields() ties its members. Where it has is_valid(), the reader refuses what is not.
template <class T>
concept HasFields = requires(T& value) {
  T::fields(value);
};

/// A vector of values that are not plain.
template <class T>
concept HasElements = requires {
  typename T::value_type;
}
&&!PlainValue<typename T::value_type>;

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
  [[nodiscard]] std::byte* result() const;
  [[nodiscard]] std::uint64_t capacity() const { return capacity_; }

 private:
  int id_ = -1;
  void* memory_ = nullptr;
  std::uint64_t capacity_ = 0;
};

class ResultTooLarge {};

/// Writes a result, in the child, and before that the arguments, in the parent.
class ResultWriter {
 public:
  explicit ResultWriter(SharedMemory& memory) : memory_(memory) {}

  template <PlainValue T>
  requires(!HasFields<T>) void put(const T& value) { std::memcpy(take(sizeof value, 1), &value, sizeof value); }
  void put(const std::string& text);
  template <HasFields T>
  void put(const T& value) {
    std::apply([this](const auto&... field) { (put(field), ...); }, T::fields(value));
  }
  template <class Number, int kRows, int kColumns>
  void put(const Eigen::Matrix<Number, kRows, kColumns>& matrix) {
    for (const Number value : matrix.reshaped()) put(value);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  void put(const std::map<std::string, std::string>& texts) {
    put(std::uint64_t{texts.size()});
    for (const auto& [name, value] : texts) {
      put(name);
      put(value);
    }
  }
  template <HasElements T>
  void put(const T& values) {
    put(std::uint64_t{values.size()});
    for (const auto& value : values) put(value);
  }
  template <PlainValue T>
  void put(const std::vector<T>& values) {
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
class ResultReader {
 public:
  ResultReader(const SharedMemory& memory, ForeignFile file);
  explicit ResultReader(const std::vector<std::byte>& bytes) : result_(bytes.data()), bytes_(bytes.size()) {}

  template <PlainValue T>
  T get() {
    std::array<std::byte, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), take(sizeof(T), 1), sizeof(T));
    return std::bit_cast<T>(bytes);
  }
  std::string text();
  std::vector<std::string> texts() { return take<std::vector<std::string>>(); }
  /// Calls `use` with the first and the end of each block of an array. Its pages return to the system, so that the
  /// array does not exist twice.
  template <PlainValue T, class Use>
  void for_each_block(std::uint64_t count, const Use& use) {
    if (count > bytes_ / sizeof(T)) fail();
    const auto* values = reinterpret_cast<const T*>(take(count * sizeof(T), ResultWriter::kAlignment));
    constexpr std::uint64_t kBlock = (std::uint64_t{4} << 20) / sizeof(T);
    for (std::uint64_t first = 0; first < count; first += kBlock) {
      const std::uint64_t next = std::min(count, first + kBlock);
      use(values + first, values + next);
      give_back(reinterpret_cast<const std::byte*>(values + first), (next - first) * sizeof(T));
    }
  }
  template <PlainValue T>
  std::vector<T> array() {
    const auto count = get<std::uint64_t>();
    std::vector<T> out;
    out.reserve(std::min(count, bytes_ / sizeof(T)));
    for_each_block<T>(count, [&](const T* first, const T* last) { out.insert(out.end(), first, last); });
    return out;
  }
  /// An array that has to have `count` values.
  template <PlainValue T>
  std::vector<T> array_of(std::size_t count) {
    std::vector<T> out = array<T>();
    if (out.size() != count) fail();
    return out;
  }
  /// Calls `use` with each value of an array.
  template <PlainValue T, class Use>
  void for_each_in_array(const Use& use) {
    for_each_block<T>(get<std::uint64_t>(), [&](const T* first, const T* last) { std::for_each(first, last, use); });
  }
  /// The next value by its type.
  template <class T>
  T take() {
    T out{};
    read(out);
    return out;
  }
  template <PlainValue T>
  requires(!HasFields<T>) void read(T& out) { out = get<T>(); }
  template <PlainValue T>
  void read(std::vector<T>& out) {
    out = array<T>();
  }
  void read(bool& out) { out = get<unsigned char>() != 0; }
  void read(std::string& out) { out = text(); }
  template <HasFields T>
  void read(T& out) {
    std::apply([this](auto&... field) { (read(field), ...); }, T::fields(out));
    if constexpr (requires { out.is_valid(); }) {
      if (!out.is_valid()) fail();
    }
  }
  template <class Number, int kRows, int kColumns>
  void read(Eigen::Matrix<Number, kRows, kColumns>& out) {
    for (Number& value : out.reshaped()) value = get<Number>();
  }
  template <class T>
  void read(std::optional<T>& out) {
    if (take<bool>()) out = take<T>();
  }
  void read(std::map<std::string, std::string>& out) {
    for (auto left = get<std::uint64_t>(); left > 0; --left) {
      std::string name = text();
      out[std::move(name)] = text();
    }
  }
  template <HasElements T>
  void read(T& out) {
    for (auto left = get<std::uint64_t>(); left > 0; --left) out.push_back(take<typename T::value_type>());
  }
  [[noreturn]] void fail() const;

 private:
  const std::byte* take(std::uint64_t bytes, std::size_t alignment);
  static void give_back(const std::byte* first, std::uint64_t bytes);

  const std::byte* result_;
  std::uint64_t bytes_;
  std::uint64_t place_ = 0;
  ForeignFile file_;
};

}  // namespace reamsim

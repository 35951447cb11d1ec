// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

// Values as bytes: numbers as the processor has them, each text and list after its length. In files of checkpoints and
// states a line before them names the format, and a CRC-32 ends them.
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "sim/base/checksum.h"
#include "sim/base/file.h"
#include "sim/base/geometry.h"

namespace reamsim {

/// The order of the parts of values, the same where they are written and where they are read. `Bytes` is a ValueOutput
/// or a ValueInput.
template <class Bytes>
class ValueVisitor {
 public:
  template <class Value>
  void operator()(Value& v) {
    using Plain = std::remove_const_t<Value>;
    Bytes& bytes = self();
    if constexpr (requires { Plain::fields(v); }) {
      std::apply([this](auto&... field) { ((*this)(field), ...); }, Plain::fields(v));
      bytes.check(v);
    } else if constexpr (requires { v.reshaped(); }) {  // a matrix
      for (auto& item : v.reshaped()) (*this)(item);
    } else if constexpr (requires { v.has_value(); }) {
      bytes.presence_of(v);
      if (v) (*this)(*v);
    } else if constexpr (requires { typename Value::allocator_type; }) {  // a text or a vector
      bytes.items_of(v);
    } else if constexpr (std::is_trivially_copyable_v<Plain>) {
      static_assert(!std::is_pointer_v<Plain>);
      bytes.copy(&v, sizeof v);
    } else {
      (*this)(v.first);  // a pair
      (*this)(v.second);
    }
  }

 protected:
  Bytes& self() { return static_cast<Bytes&>(*this); }
};

/// Writes values. `Bytes` has copy(), which takes bytes.
template <class Bytes>
class ValueOutput : public ValueVisitor<Bytes> {
 public:
  /// A value that has just been made.
  void put(const auto& value) { (*this)(value); }
  void items_of(const std::string& text) {
    put(text.size());
    this->self().copy(text.data(), text.size());
  }
  void items_of(const auto& list) {
    put(list.size());
    for (const auto& item : list) put(item);
  }
  void presence_of(const auto& value) { put(value.has_value()); }
  void check(const auto& /*value*/) {}
};

/// Reads values that may be damaged, in the order in which they were written. `Bytes` has next(), which returns the
/// next bytes, as many as asked for, or calls fail(), which throws.
template <class Bytes>
class ValueInput : public ValueVisitor<Bytes> {
 public:
  /// The next value by its type.
  template <class Value>
  Value take() {
    Value out{};
    (*this)(out);
    return out;
  }
  void copy(void* first, std::size_t count) { std::memcpy(first, this->self().next(count), count); }
  void copy(bool* value, std::size_t /*count*/) {
    const auto byte = take<std::uint8_t>();
    if (byte > 1) this->self().fail();
    *value = byte == 1;
  }
  void items_of(std::string& text) {
    const auto length = take<std::size_t>();
    text.assign(static_cast<const char*>(this->self().next(length)), length);
  }
  void items_of(auto& list) {
    const auto length = take<std::size_t>();
    list.clear();
    if constexpr (requires { list.reserve(length); }) {
      list.reserve(std::min(length, this->self().bytes_left() / sizeof(list.front())));
    }
    for (std::size_t i = 0; i < length; ++i) (*this)(list.emplace_back());
  }
  void presence_of(auto& value) {
    if (take<bool>()) value.emplace();
  }
  /// A struct with is_valid() has to be.
  void check(const auto& value) {
    if constexpr (requires { value.is_valid(); }) {
      if (!value.is_valid()) this->self().fail();
    }
  }
};

/// A file that is cut off, changed or of another format.
struct DamagedValues : std::runtime_error {
  DamagedValues() : std::runtime_error("damaged") {}
};

/// Appends values to the text of a file.
class ValueWriter : public ValueOutput<ValueWriter> {
 public:
  explicit ValueWriter(std::string_view magic) : text_(magic) {}
  void copy(const void* first, std::size_t count) { text_.append(static_cast<const char*>(first), count); }
  /// The text of the file. Called once, after the last value.
  const std::string& finish() {
    put(crc_of(text_));
    return text_;
  }

 private:
  std::string text_;
};

/// Reads them again. Throws DamagedValues.
class ValueReader : public ValueInput<ValueReader> {
 public:
  explicit ValueReader(std::string_view rest) : rest_(rest) {}
  [[nodiscard]] std::size_t bytes_left() const { return rest_.size(); }
  const void* next(std::size_t count) {
    if (count > rest_.size()) fail();
    const char* const first = rest_.data();
    rest_.remove_prefix(count);
    return first;
  }
  [[noreturn]] static void fail() { throw DamagedValues(); }

 private:
  std::string_view rest_;
};

/// The content of a file; nullopt where it cannot be read.
inline std::optional<std::string> read_whole_file(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return std::nullopt;
  return read_file_start(path, size);
}

/// The values between the first line, `magic`, and the checksum. Throws DamagedValues.
inline std::string_view values_of(std::string_view text, std::string_view magic) {
  constexpr std::size_t kSum = sizeof(std::uint32_t);
  if (!text.starts_with(magic) || text.size() < magic.size() + kSum) throw DamagedValues();
  const std::string_view body = text.substr(0, text.size() - kSum);
  std::uint32_t sum = 0;
  std::memcpy(&sum, body.data() + body.size(), kSum);
  if (sum != crc_of(body)) throw DamagedValues();
  return body.substr(magic.size());
}

}  // namespace reamsim

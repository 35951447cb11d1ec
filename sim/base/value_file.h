// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

// Files of values, for checkpoints and states: a line that names the format, numbers as the processor has them, each
// text and list after its length, a CRC-32 at the end.
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "sim/base/file.h"
#include "sim/base/geometry.h"

namespace reamsim {

/// A file that is cut off, changed or of another format.
struct DamagedValues : std::runtime_error {
  DamagedValues() : std::runtime_error("damaged") {}
};

inline std::uint32_t crc_of(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// The order of the parts of values, the same in ValueWriter and ValueReader, which are `File`.
template <class File>
class ValueVisitor {
 public:
  template <class Value>
  void operator()(Value& v) {
    using Plain = std::remove_const_t<Value>;
    File& file = static_cast<File&>(*this);
    if constexpr (std::is_same_v<Plain, std::string>) {
      file.length_of(v);
      file.bytes(v.data(), v.size());
    } else if constexpr (requires { Plain::fields(v); }) {
      std::apply([this](auto&... field) { ((*this)(field), ...); }, Plain::fields(v));
    } else if constexpr (requires { v.reshaped(); }) {  // a matrix
      for (auto& item : v.reshaped()) (*this)(item);
    } else if constexpr (std::is_trivially_copyable_v<Plain>) {
      file.bytes(&v, sizeof v);
    } else if constexpr (requires { v.has_value(); }) {
      file.presence_of(v);
      if (v) (*this)(*v);
    } else if constexpr (requires { typename Value::allocator_type; }) {  // a vector
      file.length_of(v);
      for (auto& item : v) (*this)(item);
    } else {
      (*this)(v.first);  // a pair
      (*this)(v.second);
    }
  }
};

/// Appends values to the text of a file.
class ValueWriter : public ValueVisitor<ValueWriter> {
 public:
  explicit ValueWriter(std::string_view magic) : text_(magic) {}
  void bytes(const void* first, std::size_t count) { text_.append(static_cast<const char*>(first), count); }
  /// A value that has just been made.
  void put(const auto& value) { (*this)(value); }
  void length_of(const auto& list) { put(list.size()); }
  void presence_of(const auto& value) { put(value.has_value()); }
  /// The text of the file. Called once, after the last value.
  const std::string& finish() {
    put(crc_of(text_));
    return text_;
  }

 private:
  std::string text_;
};

/// Reads them again, in the same order.
class ValueReader : public ValueVisitor<ValueReader> {
 public:
  explicit ValueReader(std::string_view rest) : rest_(rest) {}
  void bytes(void* first, std::size_t count) {
    if (count > rest_.size()) throw DamagedValues();
    std::memcpy(first, rest_.data(), count);
    rest_.remove_prefix(count);
  }
  void bytes(bool* value, std::size_t) {
    std::uint8_t byte = 0;
    (*this)(byte);
    if (byte > 1) throw DamagedValues();
    *value = byte == 1;
  }
  /// Of a text or a list, each of whose items has a byte or more.
  void length_of(auto& list) {
    std::size_t length = 0;
    (*this)(length);
    if (length > rest_.size()) throw DamagedValues();
    list.resize(length);
  }
  void presence_of(auto& value) {
    bool has = false;
    (*this)(has);
    if (has) value.emplace();
  }

 private:
  std::string_view rest_;
};

/// Visits where a simulation stands, in the order of checkpoints and states.
template <class Visit, class Step>
void visit_step(Visit& visit, Step& step) {
  visit(step.frame);
  visit(step.energy.work_mj);
  visit(step.energy.floor_mj);
  visit(step.energy.cut_mj);
  visit(step.energy.first_contact_mm);
  visit(step.touched);
  visit(step.warned_of_no_spin);
}

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

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
#include <type_traits>
#include <utility>
#include <vector>

#include "sim/base/file.h"
#include "sim/base/geometry.h"
#include "sim/record/summary.h"

namespace reamsim {

/// A file that is cut off, changed or of another format.
struct DamagedValues : std::runtime_error {
  DamagedValues() : std::runtime_error("damaged") {}
};

inline std::uint32_t crc_of(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// Appends values to the text of a file.
class ValueWriter {
 public:
  explicit ValueWriter(std::string_view magic) : text_(magic) {}

  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void operator()(const std::string& value) {
    (*this)(value.size());
    text_ += value;
  }
  void operator()(const Vec3i& v) {
    for (const int i : v) (*this)(i);
  }
  void operator()(const std::optional<Vec3>& v) {
    (*this)(v.has_value());
    if (!v) return;
    for (const double d : *v) (*this)(d);
  }
  template <class First, class Second>
  void operator()(const std::pair<First, Second>& pair) {
    (*this)(pair.first);
    (*this)(pair.second);
  }
  template <class T>
  void operator()(const std::vector<T>& list) {
    (*this)(list.size());
    for (const T& item : list) (*this)(item);
  }
  void operator()(const InputSum& input) {
    for (const std::string* part : {&input.role, &input.path, &input.sha256}) (*this)(*part);
  }

  /// The text of the file. Called once, after the last value.
  const std::string& finish() {
    (*this)(crc_of(text_));
    return text_;
  }

 private:
  std::string text_;
};

/// Reads them again, in the same order.
class ValueReader {
 public:
  explicit ValueReader(std::string_view rest) : rest_(rest) {}

  template <class T>
  void operator()(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
  }
  void operator()(bool& value) {
    std::uint8_t byte = 0;
    (*this)(byte);
    if (byte > 1) throw DamagedValues();
    value = byte == 1;
  }
  void operator()(std::string& value) { value = take(length()); }
  void operator()(Vec3i& v) {
    for (int& i : v) (*this)(i);
  }
  void operator()(std::optional<Vec3>& v) {
    bool has = false;
    (*this)(has);
    if (!has) return;
    v.emplace();
    for (double& d : *v) (*this)(d);
  }
  template <class First, class Second>
  void operator()(std::pair<First, Second>& pair) {
    (*this)(pair.first);
    (*this)(pair.second);
  }
  template <class T>
  void operator()(std::vector<T>& list) {
    list.resize(length());
    for (T& item : list) (*this)(item);
  }
  void operator()(InputSum& input) {
    for (std::string* part : {&input.role, &input.path, &input.sha256}) (*this)(*part);
  }

 private:
  std::string_view take(std::size_t bytes) {
    if (bytes > rest_.size()) throw DamagedValues();
    const std::string_view out = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return out;
  }
  /// The length of a text or a list, each of whose items has a byte or more.
  std::size_t length() {
    std::size_t out = 0;
    (*this)(out);
    if (out > rest_.size()) throw DamagedValues();
    return out;
  }

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

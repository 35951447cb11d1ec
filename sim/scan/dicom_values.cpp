// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom_values.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace reamsim::ct {

namespace {

/// A binary number, in the byte order of this machine.
template <class Number>
std::string binary_text(const std::string& bytes) {
  Number out{};
  if (bytes.size() < sizeof out) return "";
  std::memcpy(&out, bytes.data(), sizeof out);
  return fmt::format("{}", out);
}

}  // namespace

std::string plain_text(std::string bytes) {
  for (char& c : bytes) c = c == '\0' ? ' ' : (c < 0x20 || c > 0x7e) ? '?' : c;
  const std::size_t first = bytes.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  return bytes.substr(first, bytes.find_last_not_of(' ') - first + 1);
}

std::vector<double> numbers_in(const std::string& list) {
  std::vector<double> out;
  for (std::size_t at = 0; at < list.size();) {
    const std::size_t end = std::min(list.find('\\', at), list.size());
    const std::string item = list.substr(at, end - at);
    char* rest = nullptr;
    const double number = std::strtod(item.c_str(), &rest);
    if (rest == item.c_str() || !std::isfinite(number)) return {};
    out.push_back(number);
    at = end + 1;
  }
  return out;
}

std::string DicomValues::bytes(const DicomTag& tag) const {
  if (!has(tag)) return "";
  const gdcm::ByteValue* value = data_->GetDataElement(gdcm::Tag(tag.group, tag.element)).GetByteValue();
  return value == nullptr ? "" : std::string(value->GetPointer(), value->GetLength());
}

std::string DicomValues::text(const DicomTag& tag) const {
  return plain_text(bytes(tag));
}

std::vector<double> DicomValues::numbers(const DicomTag& tag) const {
  return numbers_in(text(tag));
}

double DicomValues::number(const DicomTag& tag, double otherwise) const {
  const std::vector<double> all = numbers(tag);
  return all.empty() ? otherwise : all[0];
}

int DicomValues::integer(const DicomTag& tag, int otherwise) const {
  const double value = number(tag, otherwise);
  return std::abs(value) > 1e9 ? otherwise : static_cast<int>(value);
}

int DicomValues::short_integer(const DicomTag& tag) const {
  const std::string raw = bytes(tag);
  std::uint16_t out = 0;
  if (raw.size() >= sizeof out) std::memcpy(&out, raw.data(), sizeof out);
  return out;
}

std::string DicomValues::text_of(const DicomTag& tag, DicomType type) const {
  switch (type) {
    case DicomType::us:
      return binary_text<std::uint16_t>(bytes(tag));
    case DicomType::ul:
      return binary_text<std::uint32_t>(bytes(tag));
    case DicomType::fd:
      return binary_text<double>(bytes(tag));
    case DicomType::text:
      break;
  }
  return text(tag);
}

std::vector<DicomValues> DicomValues::items(const DicomTag& tag) const {
  std::vector<DicomValues> out;
  if (!has(tag)) return out;
  const gdcm::SmartPointer<gdcm::SequenceOfItems> sequence =
      data_->GetDataElement(gdcm::Tag(tag.group, tag.element)).GetValueAsSQ();
  if (sequence == nullptr) return out;
  for (std::size_t n = 1; n <= sequence->GetNumberOfItems(); ++n) {
    out.push_back(DicomValues(sequence->GetItem(n).GetNestedDataSet(), sequence));
  }
  return out;
}

}  // namespace reamsim::ct

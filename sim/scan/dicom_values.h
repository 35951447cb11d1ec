// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gdcmDataSet.h>
#include <gdcmSequenceOfItems.h>
#include <string>
#include <utility>
#include <vector>

namespace reamsim::ct {

// Reading with GDCM, for child processes. Private to sim/scan.

/// The values of a data set. What is missing is empty or 0.
class DicomValues {
 public:
  explicit DicomValues(const gdcm::DataSet& data, gdcm::SmartPointer<gdcm::SequenceOfItems> owner = {})
      : owner_(std::move(owner)), data_(&data) {}

  [[nodiscard]] bool has(const gdcm::Tag& tag) const { return data_->FindDataElement(tag); }
  /// The bytes in the file; nullptr without any, as for a sequence or compressed pixels.
  [[nodiscard]] const gdcm::ByteValue* raw(const gdcm::Tag& tag) const;
  [[nodiscard]] std::string bytes(const gdcm::Tag& tag) const;
  /// Without padding; other characters than printable ASCII become "?".
  [[nodiscard]] std::string text(const gdcm::Tag& tag) const;
  /// The numbers of a text "a\b\c"; empty if one of them is invalid.
  [[nodiscard]] std::vector<double> numbers(const gdcm::Tag& tag) const;
  /// The first number of a text.
  [[nodiscard]] double number(const gdcm::Tag& tag, double otherwise) const;
  [[nodiscard]] int integer(const gdcm::Tag& tag, int otherwise) const;
  /// A 16-bit number, in the byte order of this machine.
  [[nodiscard]] int short_integer(const gdcm::Tag& tag) const;
  /// Any value as a text; `vr`: its type.
  [[nodiscard]] std::string text_of(const gdcm::Tag& tag, const gdcm::VR& vr) const;
  /// The data sets of a sequence.
  [[nodiscard]] std::vector<DicomValues> items(const gdcm::Tag& tag) const;

 private:
  gdcm::SmartPointer<gdcm::SequenceOfItems> owner_;  ///< a sequence of unknown VR is parsed into a new one
  const gdcm::DataSet* data_;
};

/// An element that may tell volumes of one series apart. Tag and VR are those of GDCM's dictionary.
struct SeparatingTag {
  std::string keyword;
  gdcm::Tag tag{};
  gdcm::VR vr{};
};

/// Those known, the one that says most about the reason first.
const std::vector<SeparatingTag>& separating_tags();

/// Adds the values that a data set has, by keyword; they replace earlier ones.
void add_tags(const DicomValues& values, std::vector<std::pair<std::string, std::string>>& tags);

// Transfer syntaxes: how a DICOM file and its pixels are coded.

/// The transfer syntax UID in the meta information of a file, also one that GDCM does not know; "" without one.
std::string syntax_in_file(const std::string& path);

/// "JPEG 2000"; "" for one that is not compressed, or unknown.
std::string name_of_syntax(const std::string& uid);

/// Whether GDCM can decode it. "" is taken as supported: files without meta information are implicit little endian.
bool is_supported_syntax(const std::string& uid);

/// Whether a compression loses values.
enum class Loss { none, possible, certain };
Loss loss_of_syntax(const std::string& uid);

/// What to do about files in a syntax that cannot be decoded.
std::string how_to_decode(const std::string& name_and_uid);

}  // namespace reamsim::ct

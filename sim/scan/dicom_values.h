// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gdcmDataSet.h>
#include <gdcmSequenceOfItems.h>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace reamsim::ct {

// Reading with GDCM, for child processes. Private to sim/scan.

/// Group and element.
struct DicomTag {
  std::uint16_t group = 0;
  std::uint16_t element = 0;
};

/// The binary numbers of DICOM. Text includes the numbers DS and IS.
enum class DicomType { text, us, ul, fd };

/// The values of a data set. What is missing is empty or 0.
class DicomValues {
 public:
  explicit DicomValues(const gdcm::DataSet& data) : data_(&data) {}

  [[nodiscard]] bool has(const DicomTag& tag) const {
    return data_->FindDataElement(gdcm::Tag(tag.group, tag.element));
  }
  [[nodiscard]] std::string bytes(const DicomTag& tag) const;
  /// Without padding; other characters than printable ASCII become "?".
  [[nodiscard]] std::string text(const DicomTag& tag) const;
  /// The numbers of a text "a\b\c"; empty if one of them is invalid.
  [[nodiscard]] std::vector<double> numbers(const DicomTag& tag) const;
  /// The first number of a text.
  [[nodiscard]] double number(const DicomTag& tag, double otherwise) const;
  [[nodiscard]] int integer(const DicomTag& tag, int otherwise) const;
  /// A 16-bit number, in the byte order of this machine.
  [[nodiscard]] int short_integer(const DicomTag& tag) const;
  /// Any value as a text.
  [[nodiscard]] std::string text_of(const DicomTag& tag, DicomType type) const;
  /// The data sets of a sequence.
  [[nodiscard]] std::vector<DicomValues> items(const DicomTag& tag) const;

 private:
  explicit DicomValues(const gdcm::DataSet& data, gdcm::SmartPointer<gdcm::SequenceOfItems> owner)
      : owner_(std::move(owner)), data_(&data) {}

  gdcm::SmartPointer<gdcm::SequenceOfItems> owner_;  ///< a sequence of unknown VR is parsed into a new one
  const gdcm::DataSet* data_;
};

/// As DicomValues gives them.
std::string plain_text(std::string bytes);
std::vector<double> numbers_in(const std::string& list);

}  // namespace reamsim::ct

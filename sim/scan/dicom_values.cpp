// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom_values.h"

#include <fmt/core.h>
#include <gdcmDicts.h>
#include <gdcmGlobal.h>
#include <gdcmTransferSyntax.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include "sim/base/file.h"
#include "sim/base/text.h"

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

std::string plain_text(std::string bytes) {
  for (char& c : bytes) c = c == '\0' ? ' ' : (c < 0x20 || c > 0x7e) ? '?' : c;
  return std::string(without_blanks(bytes, " "));
}

/// Of separating_tags(). InstanceNumber and SOPInstanceUID are of multi-frame files; those of slices all differ.
constexpr std::string_view kKeywords =
    "AcquisitionNumber FrameAcquisitionNumber TemporalPositionIdentifier TemporalPositionIndex "
    "NominalPercentageOfCardiacPhase TriggerTime NominalCardiacTriggerDelayTime TemporalPositionTimeOffset "
    "EchoNumbers EchoTime EffectiveEchoTime ConvolutionKernel FilterType ReconstructionAlgorithm ImageType FrameType "
    "KVP ReferencedSegmentNumber StackID SliceThickness ReconstructionDiameter ContrastBolusAgent SeriesNumber "
    "SeriesDescription StudyInstanceUID FrameOfReferenceUID IrradiationEventUID AcquisitionDateTime "
    "FrameAcquisitionDateTime FrameReferenceDateTime AcquisitionTime ContentTime SeriesTime AcquisitionDate "
    "ContentDate InstanceNumber SOPInstanceUID";

struct Syntax {
  std::string_view uid;
  const char* name;
  Loss loss = Loss::none;
};

constexpr Syntax kCompressed[] = {{"1.2.840.10008.1.2.1.99", "deflated"},
                                  {"1.2.840.10008.1.2.4.50", "JPEG baseline", Loss::certain},
                                  {"1.2.840.10008.1.2.4.51", "JPEG extended", Loss::certain},
                                  {"1.2.840.10008.1.2.4.52", "JPEG extended", Loss::certain},
                                  {"1.2.840.10008.1.2.4.53", "JPEG spectral selection", Loss::certain},
                                  {"1.2.840.10008.1.2.4.55", "JPEG full progression", Loss::certain},
                                  {"1.2.840.10008.1.2.4.57", "JPEG lossless"},
                                  {"1.2.840.10008.1.2.4.70", "JPEG lossless"},
                                  {"1.2.840.10008.1.2.4.80", "JPEG-LS lossless"},
                                  {"1.2.840.10008.1.2.4.81", "JPEG-LS near-lossless", Loss::certain},
                                  {"1.2.840.10008.1.2.4.90", "JPEG 2000 lossless"},
                                  {"1.2.840.10008.1.2.4.91", "JPEG 2000", Loss::possible},
                                  {"1.2.840.10008.1.2.4.92", "JPEG 2000 part 2 lossless"},
                                  {"1.2.840.10008.1.2.4.93", "JPEG 2000 part 2", Loss::possible},
                                  {"1.2.840.10008.1.2.4.94", "JPIP"},
                                  {"1.2.840.10008.1.2.4.95", "JPIP"},
                                  {"1.2.840.10008.1.2.5", "RLE"},
                                  {"1.2.840.10008.1.2.8.1", "deflated frames"}};

/// Families of UIDs that GDCM does not know.
constexpr Syntax kFamilies[] = {{"1.2.840.10008.1.2.4.10", "video (MPEG)"},
                                {"1.2.840.10008.1.2.4.11", "JPEG XL"},
                                {"1.2.840.10008.1.2.4.20", "High-Throughput JPEG 2000, HTJ2K"},
                                {"1.2.840.10008.1.2.7.", "video (SMPTE)"}};

std::uint16_t uint16_at(const std::string& bytes, std::size_t at) {
  return static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[at]) | static_cast<unsigned char>(bytes[at + 1])
                                                                                << 8);
}

}  // namespace

const gdcm::ByteValue* DicomValues::raw(const gdcm::Tag& tag) const {
  return has(tag) ? data_->GetDataElement(tag).GetByteValue() : nullptr;
}

std::string DicomValues::bytes(const gdcm::Tag& tag) const {
  const gdcm::ByteValue* value = raw(tag);
  return value == nullptr ? "" : std::string(value->GetPointer(), value->GetLength());
}

std::string DicomValues::text(const gdcm::Tag& tag) const {
  return plain_text(bytes(tag));
}

std::vector<double> DicomValues::numbers(const gdcm::Tag& tag) const {
  std::string list = text(tag);
  if (list.ends_with('\\')) list.pop_back();
  std::vector<double> out;
  for (const std::string& item : split(list, '\\')) {
    char* rest = nullptr;
    const double number = std::strtod(item.c_str(), &rest);
    if (rest == item.c_str() || !std::isfinite(number)) return {};
    out.push_back(number);
  }
  return out;
}

double DicomValues::number(const gdcm::Tag& tag, double otherwise) const {
  const std::vector<double> all = numbers(tag);
  return all.empty() ? otherwise : all[0];
}

int DicomValues::integer(const gdcm::Tag& tag, int otherwise) const {
  const double value = number(tag, otherwise);
  return std::abs(value) > 1e9 ? otherwise : static_cast<int>(value);
}

int DicomValues::short_integer(const gdcm::Tag& tag) const {
  const std::string raw = bytes(tag);
  std::uint16_t out = 0;
  if (raw.size() >= sizeof out) std::memcpy(&out, raw.data(), sizeof out);
  return out;
}

std::string DicomValues::text_of(const gdcm::Tag& tag, const gdcm::VR& vr) const {
  if (vr == gdcm::VR::US) return binary_text<std::uint16_t>(bytes(tag));
  if (vr == gdcm::VR::UL) return binary_text<std::uint32_t>(bytes(tag));
  // Some writers take FD for NominalPercentageOfCardiacPhase.
  if (vr == gdcm::VR::FL && bytes(tag).size() != sizeof(double)) return binary_text<float>(bytes(tag));
  return vr == gdcm::VR::FL || vr == gdcm::VR::FD ? binary_text<double>(bytes(tag)) : text(tag);
}

std::vector<DicomValues> DicomValues::items(const gdcm::Tag& tag) const {
  std::vector<DicomValues> out;
  if (!has(tag)) return out;
  const gdcm::SmartPointer<gdcm::SequenceOfItems> sequence = data_->GetDataElement(tag).GetValueAsSQ();
  if (sequence == nullptr) return out;
  for (std::size_t n = 1; n <= sequence->GetNumberOfItems(); ++n) {
    out.push_back(DicomValues(sequence->GetItem(n).GetNestedDataSet(), sequence));
  }
  return out;
}

const std::vector<SeparatingTag>& separating_tags() {
  static const std::vector<SeparatingTag> kTags = [] {  // once, because the dictionary is searched from its begin
    const gdcm::Dict& dictionary = gdcm::Global::GetInstance().GetDicts().GetPublicDict();
    std::vector<SeparatingTag> out;
    for (const std::string& keyword : split(kKeywords, ' ')) {
      SeparatingTag& tag = out.emplace_back(SeparatingTag{keyword});
      tag.vr = dictionary.GetDictEntryByKeyword(keyword.c_str(), tag.tag).GetVR();
      if (tag.tag == gdcm::Tag(0xffff, 0xffff)) throw std::logic_error(keyword + " is not in GDCM's dictionary");
    }
    return out;
  }();
  return kTags;
}

void add_tags(const DicomValues& values, std::vector<std::pair<std::string, std::string>>& tags) {
  for (const SeparatingTag& tag : separating_tags()) {
    const std::string value = values.text_of(tag.tag, tag.vr);
    if (value.empty()) continue;
    const auto found = std::ranges::find(tags, tag.keyword, &std::pair<std::string, std::string>::first);
    (found == tags.end() ? tags.emplace_back(tag.keyword, "") : *found).second = value;
  }
}

std::string syntax_in_file(const std::string& path) {
  constexpr std::size_t kPreamble = 128, kMagic = 4, kMost = 4096;
  const std::string start = read_file_start(path, kMost);
  if (start.size() < kPreamble + kMagic || start.compare(kPreamble, kMagic, "DICM") != 0) return "";
  // The meta information is explicit little endian whatever follows.
  for (std::size_t at = kPreamble + kMagic; at + 12 <= start.size() && uint16_at(start, at) == 2;) {
    const std::string vr = start.substr(at + 4, 2);
    const bool is_long = vr == "OB" || vr == "UN" || vr == "UT" || vr == "SQ" || vr == "OW";
    const std::size_t length =
        is_long ? uint16_at(start, at + 8) + (std::size_t{uint16_at(start, at + 10)} << 16) : uint16_at(start, at + 6);
    const std::size_t value = at + (is_long ? 12 : 8);
    if (uint16_at(start, at + 2) == 0x10 && value <= start.size()) return plain_text(start.substr(value, length));
    at = value + length;
  }
  return "";
}

std::string name_of_syntax(const std::string& uid) {
  const auto found = std::ranges::find(kCompressed, uid, &Syntax::uid);
  if (found != std::end(kCompressed)) return found->name;
  const auto family = std::ranges::find_if(kFamilies, [&](const Syntax& s) { return uid.starts_with(s.uid); });
  return family == std::end(kFamilies) ? "" : family->name;
}

bool is_supported_syntax(const std::string& uid) {
  using Known = gdcm::TransferSyntax;
  static constexpr std::array kUnsupported{Known::TS_END,
                                           Known::MPEG2MainProfile,
                                           Known::MPEG2MainProfileHighLevel,
                                           Known::MPEG4AVCH264HighProfileLevel4_1,
                                           Known::MPEG4AVCH264BDcompatibleHighProfileLevel4_1,
                                           Known::JPIPReferenced};
  return uid.empty() || std::ranges::find(kUnsupported, Known::GetTSType(uid.c_str())) == kUnsupported.end();
}

Loss loss_of_syntax(const std::string& uid) {
  const auto found = std::ranges::find(kCompressed, uid, &Syntax::uid);
  return found == std::end(kCompressed) ? Loss::none : found->loss;
}

std::string how_to_decode(const std::string& name_and_uid) {
  const std::string plain = "export it from the archive as Explicit VR Little Endian";
  if (name_and_uid.find("HTJ2K") == std::string::npos) return plain;
  return "decompress its files with pydicom and pylibjpeg-openjpeg (dcmread, decompress, save_as), or " + plain;
}

}  // namespace reamsim::ct

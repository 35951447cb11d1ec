// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom_syntax.h"

#include <gdcmTransferSyntax.h>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <set>

#include "sim/base/file.h"
#include "sim/scan/dicom_values.h"

namespace reamsim::ct {

namespace {

struct Syntax {
  const char* uid;
  const char* name;
};

constexpr Syntax kCompressed[] = {{"1.2.840.10008.1.2.1.99", "deflated"},
                                  {"1.2.840.10008.1.2.4.50", "JPEG baseline"},
                                  {"1.2.840.10008.1.2.4.51", "JPEG extended"},
                                  {"1.2.840.10008.1.2.4.52", "JPEG extended"},
                                  {"1.2.840.10008.1.2.4.53", "JPEG spectral selection"},
                                  {"1.2.840.10008.1.2.4.55", "JPEG full progression"},
                                  {"1.2.840.10008.1.2.4.57", "JPEG lossless"},
                                  {"1.2.840.10008.1.2.4.70", "JPEG lossless"},
                                  {"1.2.840.10008.1.2.4.80", "JPEG-LS lossless"},
                                  {"1.2.840.10008.1.2.4.81", "JPEG-LS near-lossless"},
                                  {"1.2.840.10008.1.2.4.90", "JPEG 2000 lossless"},
                                  {"1.2.840.10008.1.2.4.91", "JPEG 2000"},
                                  {"1.2.840.10008.1.2.4.92", "JPEG 2000 part 2 lossless"},
                                  {"1.2.840.10008.1.2.4.93", "JPEG 2000 part 2"},
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
  const auto found = std::ranges::find(kCompressed, uid, [](const Syntax& s) { return std::string(s.uid); });
  if (found != std::end(kCompressed)) return found->name;
  const auto family = std::ranges::find_if(kFamilies, [&](const Syntax& s) { return uid.starts_with(s.uid); });
  return family == std::end(kFamilies) ? "" : family->name;
}

bool is_supported_syntax(const std::string& uid) {
  if (uid.empty()) return true;
  switch (gdcm::TransferSyntax::GetTSType(uid.c_str())) {
    case gdcm::TransferSyntax::TS_END:
    case gdcm::TransferSyntax::MPEG2MainProfile:
    case gdcm::TransferSyntax::MPEG2MainProfileHighLevel:
    case gdcm::TransferSyntax::MPEG4AVCH264HighProfileLevel4_1:
    case gdcm::TransferSyntax::MPEG4AVCH264BDcompatibleHighProfileLevel4_1:
    case gdcm::TransferSyntax::JPIPReferenced:
      return false;
    default:
      return true;
  }
}

bool is_lossy_syntax(const std::string& uid) {
  static const std::set<std::string> kLossy{"1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51",
                                            "1.2.840.10008.1.2.4.52", "1.2.840.10008.1.2.4.53",
                                            "1.2.840.10008.1.2.4.55", "1.2.840.10008.1.2.4.81"};
  return kLossy.contains(uid);
}

bool may_be_lossy_syntax(const std::string& uid) {
  return uid == "1.2.840.10008.1.2.4.91" || uid == "1.2.840.10008.1.2.4.93";
}

std::string how_to_decode(const std::string& name_and_uid) {
  const std::string plain = "export it from the archive as Explicit VR Little Endian";
  if (name_and_uid.find("HTJ2K") == std::string::npos) return plain;
  return "decompress its files with pydicom and pylibjpeg-openjpeg (dcmread, decompress, save_as), or " + plain;
}

}  // namespace reamsim::ct

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "dicom_bytes.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace reamsim::test {

namespace {

std::string little_endian(std::size_t n, int bytes) {
  std::string out;
  for (int b = 0; b < bytes; ++b) out.push_back(static_cast<char>(n >> (8 * b) & 255));
  return out;
}

std::string series_elements(const std::string& uid) {
  return element(0x20, 0xd, "UI", "1.2.3") + element(0x20, 0xe, "UI", uid);
}

/// The elements from (0028,0002) to (0028,0103).
std::string pixel_elements(const TestImage& image, std::size_t frames, unsigned bits) {
  return element(0x28, 2, "US", us(1)) + element(0x28, 4, "CS", "MONOCHROME2") +
         element(0x28, 8, "IS", std::to_string(frames)) +
         element(0x28, 0x10, "US", us(static_cast<unsigned>(image.dims.y()))) +
         element(0x28, 0x11, "US", us(static_cast<unsigned>(image.dims.x()))) + element(0x28, 0x100, "US", us(bits)) +
         element(0x28, 0x101, "US", us(bits)) + element(0x28, 0x102, "US", us(bits - 1)) +
         element(0x28, 0x103, "US", us(0));
}

std::string position_group(const TestImage& image, int k) {
  const Vec3 p = image.point_mm(0, 0, k);
  return sequence(0x20, 0x9113, {element(0x20, 0x32, "DS", numbers_text({p.x(), p.y(), p.z()}))});
}

std::string orientation_group(const TestImage& image) {
  const auto& d = image.direction;
  return sequence(0x20, 0x9116,
                  {element(0x20, 0x37, "DS", numbers_text({d(0, 0), d(1, 0), d(2, 0), d(0, 1), d(1, 1), d(2, 1)}, 9))});
}

std::string measures_group(const TestImage& image) {
  const Vec3& s = image.spacing_mm;
  return sequence(
      0x28, 0x9110,
      {element(0x18, 0x50, "DS", numbers_text({s.z()})) + element(0x28, 0x30, "DS", numbers_text({s.y(), s.x()}))});
}

std::string rescale_group(int intercept) {
  return sequence(0x28, 0x9145,
                  {element(0x28, 0x1052, "DS", std::to_string(intercept)) + element(0x28, 0x1053, "DS", "1")});
}

std::size_t pixels_of(const TestImage& image) {
  return static_cast<std::size_t>(image.dims.x()) * static_cast<std::size_t>(image.dims.y());
}

}  // namespace

std::string element(unsigned group, unsigned number, const std::string& vr, std::string value) {
  if (value.size() % 2 != 0) value.push_back(vr == "UI" || vr == "OB" ? '\0' : ' ');
  const bool is_long = vr == "OB" || vr == "OW" || vr == "SQ";
  return little_endian(group, 2) + little_endian(number, 2) + vr +
         (is_long ? little_endian(0, 2) + little_endian(value.size(), 4) : little_endian(value.size(), 2)) + value;
}

std::string us(unsigned value) {
  return little_endian(value, 2);
}

std::string ul(unsigned value) {
  return little_endian(value, 4);
}

std::string fd(double value) {
  std::string out(sizeof value, '\0');
  std::memcpy(out.data(), &value, sizeof value);
  return out;
}

std::string sequence(unsigned group, unsigned number, const std::vector<std::string>& items) {
  std::string content;
  for (const std::string& item : items) {
    content += little_endian(0xfffe, 2) + little_endian(0xe000, 2) + little_endian(item.size(), 4) + item;
  }
  return element(group, number, "SQ", content);
}

std::string numbers_text(const std::vector<double>& values, int decimals) {
  std::string out;
  for (const double value : values) out += (out.empty() ? "" : "\\") + fmt::format("{:.{}f}", value, decimals);
  return out;
}

std::string dicom_file(const std::string& sop_class, const std::string& instance, const std::string& elements,
                       const std::string& transfer_syntax) {
  const std::string meta =
      element(2, 2, "UI", sop_class) + element(2, 3, "UI", instance) + element(2, 0x10, "UI", transfer_syntax);
  return std::string(128, '\0') + "DICM" + element(2, 0, "UL", ul(static_cast<unsigned>(meta.size()))) + meta +
         elements;
}

void write_slices(const TestImage& image, const std::string& folder, const SliceFiles& how) {
  static int files = 0;
  std::filesystem::create_directories(folder);
  for (int k = 0; k < image.dims.z(); ++k) {
    const std::string instance = "1.2.3.9." + std::to_string(++files);
    const int number = how.first_instance + k;
    const Vec3 p = image.point_mm(0, 0, k);
    const auto& d = image.direction;
    std::string pixels;
    for (std::size_t n = 0; n < pixels_of(image); ++n) {
      pixels += us(static_cast<unsigned>(std::lround(image.value[static_cast<std::size_t>(k) * pixels_of(image) + n])));
    }
    DicomElements out = how.more;
    const std::string storage = "1.2.840.10008.5.1.4.1.1.2";
    const auto put = [&](unsigned tag, const std::string& vr, const std::string& value) {
      std::string bytes = element(tag >> 16, tag & 0xffff, vr, value);
      if (how.ge_private) {  // implicit VR: tag, length, value
        bytes = bytes.substr(0, 4) + ul(static_cast<unsigned>(value.size() + value.size() % 2)) +
                bytes.substr(bytes.size() - value.size() - value.size() % 2);
      }
      out.try_emplace(tag, std::move(bytes));
    };
    if (how.ge_private) {
      for (std::size_t i = 0; i + 1 < pixels.size(); i += 2) std::swap(pixels[i], pixels[i + 1]);
    }
    put(0x00080016, "UI", storage);
    put(0x00080018, "UI", instance);
    put(0x00080060, "CS", "CT");
    put(0x0020000d, "UI", "1.2.3");
    put(0x0020000e, "UI", how.series);
    put(0x00200013, "IS", std::to_string(number));
    put(0x00200032, "DS", numbers_text({p.x(), p.y(), p.z()}, how.decimals));
    put(0x00200037, "DS", numbers_text({d(0, 0), d(1, 0), d(2, 0), d(0, 1), d(1, 1), d(2, 1)}, 9));
    put(0x00280002, "US", us(1));
    put(0x00280004, "CS", "MONOCHROME2");
    put(0x00280010, "US", us(static_cast<unsigned>(image.dims.y())));
    put(0x00280011, "US", us(static_cast<unsigned>(image.dims.x())));
    put(0x00280030, "DS", numbers_text({image.spacing_mm.y(), image.spacing_mm.x()}));
    put(0x00280100, "US", us(16));
    put(0x00280101, "US", us(16));
    put(0x00280102, "US", us(15));
    put(0x00280103, "US", us(1));
    put(0x00281052, "DS", "0");
    put(0x00281053, "DS", "1");
    put(0x7fe00010, "OW", pixels);
    std::string elements;
    for (const auto& [tag, bytes] : out) elements += bytes;
    std::ofstream(folder + fmt::format("/IM{:04d}", number), std::ios::binary)
        << dicom_file(storage, instance, elements, how.ge_private ? "1.2.840.113619.5.2" : "1.2.840.10008.1.2.1");
  }
}

std::string enhanced_ct(const std::vector<TestImage>& volumes, const EnhancedCt& how) {
  const TestImage& first = volumes.front();
  std::vector<std::string> groups;
  std::string pixels;
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    for (int n = 0; n < first.dims.z(); ++n) {
      const int k = how.reversed ? first.dims.z() - 1 - n : n;
      const int intercept = how.rescale_per_frame ? -1024 - k : -1024;
      std::string group;
      if (!how.frame_content.empty()) group += sequence(0x20, 0x9111, {how.frame_content[v]});
      group += position_group(volumes[v], k);
      if (how.orientation_per_frame) group += orientation_group(first);
      if (how.rescale_per_frame) group += rescale_group(intercept);
      groups.push_back(group);
      for (std::size_t p = 0; p < pixels_of(first); ++p) {
        const double value = volumes[v].value[static_cast<std::size_t>(k) * pixels_of(first) + p];
        pixels += us(static_cast<unsigned>(std::lround(value) - intercept));
      }
    }
  }
  std::string shared;
  if (!how.orientation_per_frame) shared += orientation_group(first);
  shared += measures_group(first);
  if (!how.rescale_per_frame) shared += rescale_group(-1024);
  const std::string body = element(8, 0x16, "UI", how.sop_class) + element(8, 0x18, "UI", how.instance) +
                           element(8, 0x60, "CS", "CT") + series_elements("1.2.3.4") +
                           element(0x20, 0x13, "IS", std::to_string(how.instance_number)) +
                           pixel_elements(first, groups.size(), 16) + sequence(0x5200, 0x9229, {shared}) +
                           sequence(0x5200, 0x9230, groups) + element(0x7fe0, 0x10, "OW", pixels);
  return dicom_file(how.sop_class, how.instance, body);
}

namespace {

std::string code_item(const std::string& meaning) {
  return element(8, 0x100, "SH", "1") + element(8, 0x102, "SH", "SCT") + element(8, 0x104, "LO", meaning);
}

std::string segment_item(const TestSegment& segment) {
  std::string type = code_item("Bone");
  if (!segment.side.empty()) type += sequence(0x62, 0x11, {code_item(segment.side)});
  return element(0x62, 4, "US", us(static_cast<unsigned>(segment.number))) + element(0x62, 5, "LO", segment.label) +
         element(0x62, 8, "CS", "AUTOMATIC") + sequence(0x62, 0xf, {type});
}

/// Appends a frame's pixels to the bits or bytes of all frames.
class SegPixels {
 public:
  explicit SegPixels(unsigned bits_of_pixel) : bits_of_pixel_(bits_of_pixel) {}
  void add(unsigned value) {
    if (bits_of_pixel_ > 1) {
      bytes_ += little_endian(value, static_cast<int>(bits_of_pixel_ / 8));
      return;
    }
    if (bits_ % 8 == 0) bytes_.push_back('\0');
    if (value != 0) bytes_.back() = static_cast<char>(bytes_.back() | 1 << (bits_ % 8));
    ++bits_;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  unsigned bits_of_pixel_;
  std::size_t bits_ = 0;
  std::string bytes_;
};

}  // namespace

std::string dicom_seg(const std::vector<TestSegment>& segments, const std::string& type, unsigned bits) {
  if (bits == 0) bits = type == "BINARY" ? 1 : 8;
  const TestImage& first = segments.front().mask;
  const bool label_map = type == "LABELMAP";
  const std::string sop_class = label_map ? "1.2.840.10008.5.1.4.1.1.66.7" : "1.2.840.10008.5.1.4.1.1.66.4";
  std::vector<std::string> groups;
  SegPixels pixels(bits);
  for (std::size_t s = 0; s < (label_map ? 1 : segments.size()); ++s) {
    for (int k = 0; k < first.dims.z(); ++k) {
      const auto at = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(k) * pixels_of(first));
      const auto begin = segments[s].mask.value.begin() + at;
      const auto end = begin + static_cast<std::ptrdiff_t>(pixels_of(first));
      if (!label_map && std::all_of(begin, end, [](double v) { return v <= 0; })) continue;
      groups.push_back(position_group(first, k));
      if (!label_map) {
        groups.back() += sequence(0x62, 0xa, {element(0x62, 0xb, "US", us(static_cast<unsigned>(segments[s].number)))});
      }
      for (std::ptrdiff_t p = 0; p < end - begin; ++p) {
        unsigned value = begin[p] > 0 ? (type == "FRACTIONAL" ? 255 : 1) : 0;
        for (const TestSegment& segment : segments) {
          if (label_map && segment.mask.value[static_cast<std::size_t>(at + p)] > 0) {
            value = static_cast<unsigned>(segment.number);
          }
        }
        pixels.add(value);
      }
    }
  }
  std::vector<std::string> items;
  for (const TestSegment& segment : segments) items.push_back(segment_item(segment));
  std::string body = element(8, 5, "CS", "ISO_IR 192") + element(8, 0x16, "UI", sop_class) +
                     element(8, 0x18, "UI", "1.2.3.7") + element(8, 0x60, "CS", "SEG") + series_elements("1.2.3.8") +
                     pixel_elements(first, groups.size(), bits) + element(0x62, 1, "CS", type) +
                     sequence(0x62, 2, items);
  if (type == "FRACTIONAL") body += element(0x62, 0xe, "US", us(255)) + element(0x62, 0x10, "CS", "PROBABILITY");
  body += sequence(0x5200, 0x9229, {orientation_group(first) + measures_group(first)}) +
          sequence(0x5200, 0x9230, groups) + element(0x7fe0, 0x10, bits > 8 ? "OW" : "OB", pixels.bytes());
  return dicom_file(sop_class, "1.2.3.7", body);
}

}  // namespace reamsim::test

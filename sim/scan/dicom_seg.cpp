// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <gdcmBitmap.h>
#include <gdcmException.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <algorithm>

#include "sim/base/text.h"
#include "sim/isolation/read_in_child.h"
#include "sim/scan/aligned_image.h"
#include "sim/scan/dicom.h"
#include "sim/scan/dicom_values.h"
#include "sim/scan/image_io.h"

namespace reamsim::ct {

namespace {

const gdcm::Tag kPixels(0x7fe0, 0x0010);

bool is_segmentation(const DicomHeader& header) {
  return header.modality == "SEG" || header.sop_class == "1.2.840.10008.5.1.4.1.1.66.4" ||
         header.sop_class == "1.2.840.10008.5.1.4.1.1.66.7";
}

/// A text of any character set as UTF-8; other sets than UTF-8 and Latin-1 lose their special characters.
std::string utf8_text(const DicomValues& values, const gdcm::Tag& tag, const std::string& set) {
  std::string raw = values.bytes(tag);
  raw.erase(std::find(raw.begin(), raw.end(), '\0'), raw.end());
  if (set == "ISO_IR 192" && is_printable(raw)) return raw.substr(0, raw.find_last_not_of(' ') + 1);
  if (set != "ISO_IR 100") return values.text(tag);
  std::string out;
  for (const char c : raw) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      out += c;
    } else {
      out += static_cast<char>(0xc0 | byte >> 6);
      out += static_cast<char>(0x80 | (byte & 0x3f));
    }
  }
  return out.substr(0, out.find_last_not_of(' ') + 1);
}

/// Columns and rows that a codestream of JPEG, JPEG-LS or JPEG 2000 states; nullopt for others.
std::optional<Eigen::Vector2i> stated_size(std::string_view bytes) {
  const auto number = [&](std::size_t at, std::size_t length) {
    std::uint32_t out = 0;
    for (std::size_t i = at; i < at + length; ++i) out = out << 8 | (i < bytes.size() ? std::uint8_t(bytes[i]) : 0U);
    return out;
  };
  const auto size = [](std::uint32_t columns, std::uint32_t rows) {
    return Eigen::Vector2i(static_cast<int>(columns), static_cast<int>(rows));
  };
  if (number(0, 4) == 0xff4fff51) {  // SOC and SIZ: extent of the reference grid, and offset of the image in it
    return size(number(8, 4) - number(16, 4), number(12, 4) - number(20, 4));
  }
  if (number(0, 2) != 0xffd8) return std::nullopt;
  for (std::size_t at = 2; at < bytes.size(); at += 2 + number(at + 2, 2)) {  // segments up to the start of a frame
    const std::uint32_t marker = number(at, 2);
    const bool is_frame =
        marker >= 0xffc0 && marker <= 0xffcf && marker != 0xffc4 && marker != 0xffc8 && marker != 0xffcc;
    if (is_frame || marker == 0xfff7) return size(number(at + 7, 2), number(at + 5, 2));
    if (marker < 0xff00) break;
  }
  return std::nullopt;
}

/// A segmentation in memory, for child processes.
class SegFile {
 public:
  explicit SegFile(const ForeignFile& file) : file_(file) {
    const QuietLibraries quiet;
    gdcm::Trace::WarningOn();  // GDCM reports missing pixels in no other way
    frames_ = read_dicom_header(file.path).images;
    reader_.SetFileName(file.path.c_str());
    if (frames_.empty() || !reader_.Read() || quiet.reports_missing_voxels())
      throw bad_seg(file, "the segmentation is truncated or damaged");
    const DicomValues values(reader_.GetFile().GetDataSet());
    facts_.pixel_type = values.text({0x0062, 0x0001});  // BINARY, FRACTIONAL or LABELMAP
    facts_.bytes_per_voxel = sizeof(float);
    read_segments(values);
    SegPlanes planes = seg_planes(frames_, file);
    facts_.geometry = planes.geometry;
    plane_ = std::move(planes.plane_of_frame);
    open_pixels(values);
    if (quiet.reports_missing_voxels()) throw unreadable(file_);
  }

  [[nodiscard]] const ImageFacts& facts() const { return facts_; }

  /// Puts segments that do not overlap into one layer; their values are their numbers.
  void assign_layers() {
    if (is_label_map()) return;
    std::vector<std::vector<bool>> taken;
    for (NamedSegment& segment : facts_.segments) {
      std::vector<std::size_t> voxels;
      for_each_voxel_of(segment.label.value, [&](std::size_t voxel) { voxels.push_back(voxel); });
      const auto is_free = [&](const std::vector<bool>& layer) {
        return std::ranges::none_of(voxels, [&](std::size_t voxel) { return layer[voxel]; });
      };
      auto layer = std::ranges::find_if(taken, is_free);
      if (layer == taken.end()) {
        taken.emplace_back(static_cast<std::size_t>(facts_.geometry.size()));
        layer = taken.end() - 1;
      }
      for (const std::size_t voxel : voxels) (*layer)[voxel] = true;
      segment.label.layer = static_cast<int>(layer - taken.begin());
    }
    facts_.layers = std::max(1, static_cast<int>(taken.size()));
  }

  /// Writes the numbers of these segments in a box.
  void fill(const std::vector<double>& numbers, const IndexBox& box, float* out) const {
    std::fill_n(out, box.voxels(), 0.0F);
    const Lattice lattice{.dims = facts_.geometry.dims};
    const auto put = [&](std::size_t voxel, float value) {
      const Vec3i at = lattice.voxel_at(voxel) - box.start;
      if (contains_cell(box.size, at)) out[index_in(box.size, at)] = value;
    };
    if (is_label_map()) return for_each_pixel([](const DicomHeader&) { return true; }, put);
    for (const double number : numbers) {
      for_each_voxel_of(number, [&](std::size_t voxel) { put(voxel, static_cast<float>(number)); });
    }
  }

 private:
  [[nodiscard]] bool is_label_map() const { return facts_.pixel_type == "LABELMAP"; }

  void read_segments(const DicomValues& values) {
    const std::string set = values.text({0x0008, 0x0005});
    const gdcm::Tag code_meaning(0x0008, 0x0104);
    std::map<std::string, int> uses;
    std::vector<std::string> sides;  // of each segment
    const std::vector<DicomValues> items = values.items({0x0062, 0x0002});
    if (items.empty()) throw bad_seg(file_, "the segmentation has no segments");
    for (const DicomValues& item : items) {
      const int number = item.short_integer({0x0062, 0x0004});
      if (number == 0 && is_label_map()) continue;  // the background
      const std::vector<DicomValues> type = item.items({0x0062, 0x000f});
      std::string name = utf8_text(item, {0x0062, 0x0005}, set);
      if (name.empty()) name = utf8_text(item, {0x0062, 0x0006}, set);
      if (name.empty() && !type.empty()) name = utf8_text(type.front(), code_meaning, set);
      const std::vector<DicomValues> side = type.empty() ? type : type.front().items({0x0062, 0x0011});
      sides.push_back(side.empty() ? std::to_string(number) : utf8_text(side.front(), code_meaning, set));
      ++uses[name];
      facts_.segments.push_back({std::move(name), {0, double(number)}});
    }
    // dcmqi writes "Scapula" twice, and the side as a modifier of the type.
    for (std::size_t n = 0; n < sides.size(); ++n) {
      std::string& name = facts_.segments[n].name;
      if (uses[name] >= 2) name += " (" + sides[n] + ")";
    }
  }

  void open_pixels(const DicomValues& values) {
    const gdcm::ByteValue* plain = values.raw(kPixels);
    bits_ = values.short_integer({0x0028, 0x0100});
    if ((bits_ != 1 && bits_ != 8 && bits_ != 16) || values.short_integer({0x0028, 0x0002}) > 1) {
      throw bad_seg(file_, fmt::format("pixels of {} bits, or of several values", bits_));
    }
    const std::size_t bits = static_cast<std::size_t>(bits_) * pixels_of_frame() * frames_.size();
    if (plain != nullptr && plain->GetLength() < (bits + 7) / 8) throw bad_seg(file_, "the segmentation is truncated");
    if (facts_.pixel_type == "FRACTIONAL") least_ = std::max(1.0, 0.5 * values.short_integer({0x0062, 0x000e}));
    pixels_ = plain == nullptr ? nullptr : plain->GetPointer();
    if (plain == nullptr) decode();
  }

  /// GDCM trusts the header: a frame of another size would be read askew.
  void check_sizes(const gdcm::SequenceOfFragments* fragments) const {
    for (std::size_t i = 0; fragments != nullptr && i < fragments->GetNumberOfFragments(); ++i) {
      const gdcm::ByteValue* bytes = fragments->GetFragment(static_cast<unsigned>(i)).GetByteValue();
      if (bytes == nullptr) continue;
      const auto size = stated_size({bytes->GetPointer(), bytes->GetLength()});
      if (!size || *size == facts_.geometry.dims.head<2>()) continue;
      throw bad_seg(file_, fmt::format("a frame is compressed with {}x{} pixels, and the header says {}x{}", size->x(),
                                       size->y(), facts_.geometry.dims.x(), facts_.geometry.dims.y()));
    }
  }

  /// GDCM's image reader is not used: it knows no label maps and no compressed single bits.
  void decode() {
    bits_ = std::max(bits_, 8);  // of a compressed single bit
    decoded_.resize(pixels_of_frame() * frames_.size() * static_cast<std::size_t>(bits_ / 8));
    const auto size = Vec3i(frames_.front().columns, frames_.front().rows, int(frames_.size())).cast<unsigned>().eval();
    gdcm::Bitmap image;
    image.SetNumberOfDimensions(frames_.size() > 1 ? 3 : 2);
    image.SetDimensions(size.data());
    image.SetPixelFormat(bits_ == 8 ? gdcm::PixelFormat::UINT8 : gdcm::PixelFormat::UINT16);
    image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
    image.SetTransferSyntax(reader_.GetFile().GetHeader().GetDataSetTransferSyntax());
    const gdcm::DataElement& pixels = reader_.GetFile().GetDataSet().GetDataElement(kPixels);
    check_sizes(pixels.GetSequenceOfFragments());
    image.SetDataElement(pixels);
    try {
      if (!image.GetBuffer(decoded_.data())) throw unreadable(file_);
    } catch (const gdcm::Exception&) {
      throw unreadable(file_);
    }
    pixels_ = decoded_.data();
  }

  [[nodiscard]] std::size_t pixels_of_frame() const {
    return static_cast<std::size_t>(facts_.geometry.dims.x()) * static_cast<std::size_t>(facts_.geometry.dims.y());
  }

  /// The value of the n-th pixel of all frames, which follow one another without padding.
  [[nodiscard]] int value(std::size_t n) const {
    const auto byte = [this](std::size_t at) { return int{static_cast<unsigned char>(pixels_[at])}; };
    if (bits_ == 1) return byte(n / 8) >> (n % 8) & 1;
    return bits_ == 8 ? byte(n) : byte(2 * n) | byte(2 * n + 1) << 8;
  }

  /// Calls visit(voxel, value) for all pixels of least_ and above in the frames that `wanted` accepts.
  template <class Wanted, class Visit>
  void for_each_pixel(const Wanted& wanted, const Visit& visit) const {
    const std::size_t pixels = pixels_of_frame();
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      if (!wanted(frames_[f])) continue;
      for (std::size_t p = 0; p < pixels; ++p) {
        const int found = value(f * pixels + p);
        if (found >= least_) visit(static_cast<std::size_t>(plane_[f]) * pixels + p, static_cast<float>(found));
      }
    }
  }

  template <class Visit>
  void for_each_voxel_of(double number, const Visit& visit) const {
    const std::string wanted = std::to_string(static_cast<int>(number));
    const auto is_wanted = [&](const DicomHeader& frame) { return frame.tag("ReferencedSegmentNumber") == wanted; };
    for_each_pixel(is_wanted, [&](std::size_t voxel, float) { visit(voxel); });
  }

  ForeignFile file_;
  gdcm::Reader reader_;
  ImageFacts facts_;
  std::vector<DicomHeader> frames_;
  std::vector<int> plane_;  ///< of each frame
  double least_ = 1;        ///< value from which a pixel belongs to a fractional segment
  int bits_ = 1;            ///< of a pixel: 1, 8, 16
  const char* pixels_ = nullptr;
  std::vector<char> decoded_;  ///< empty: pixels_ are those of reader_
};

void put_seg(ResultWriter& out, const ForeignFile& file) {
  SegFile seg(file);
  seg.assign_layers();
  out.put(seg.facts());
}

void put_seg_layer(ResultWriter& out, const ForeignFile& file, const std::vector<double>& numbers, const Vec3i& dims,
                   const IndexBox& box) {
  const SegFile seg(file);
  if (seg.facts().geometry.dims != dims) throw file.error("the file has changed while it was read", "start again");
  seg.fill(numbers, box, out.array<float>(static_cast<std::size_t>(box.voxels())));
}

/// The segmentation in a file of `pixels` pixels in all frames.
ScanSource seg_source(const ForeignFile& file, double pixels, Diagnostics& report) {
  constexpr double kBytesPerPixel = 16;  // of the coded and decoded frames, and of the voxels of a segment
  const ReadLimits limits =
      ReadLimits().with(bytes_of_file(file.path), static_cast<std::uint64_t>(kBytesPerPixel * pixels) + (1U << 28));
  const auto facts = read_in_child<put_seg>(file, limits, file).take<ImageFacts>();
  if (facts.pixel_type == "FRACTIONAL") {
    report.warn(file.path + ": a fractional segmentation; voxels of at least half of the maximum belong to a segment");
  }
  const auto read = [file, limits, facts](const IndexBox& box, int layer) {
    std::vector<double> numbers;
    for (const NamedSegment& segment : facts.segments) {
      if (segment.label.layer == layer) numbers.push_back(segment.label.value);
    }
    const auto voxels = static_cast<std::size_t>(box.voxels());
    ReadLimits most = limits;
    most.result_bytes += voxels * sizeof(float);
    ResultReader result = read_in_child<put_seg_layer>(file, most, file, numbers, facts.geometry.dims, box);
    return Scan{part_of(facts.geometry, box), result.array_of<float>(voxels)};
  };
  return {.geometry = facts.geometry,
          .description = fmt::format("DICOM SEG, {} segments", facts.segments.size()),
          .layers = facts.layers,
          .segments = facts.segments,
          .read = read};
}

[[noreturn]] void refuse_no_seg(const DicomFile& found, const ForeignFile& file) {
  const std::string expected = "give a DICOM SEG, or save the segmentation as NRRD (3D Slicer)";
  if (found.kind == DicomKind::unsupported) {
    throw file.error("coded as " + found.note + ", which GDCM cannot decode", how_to_decode(found.note));
  }
  if (found.kind == DicomKind::no_image && found.note == "RTSTRUCT") {
    throw file.error("a DICOM RT structure set: contours, not voxels", "convert it to DICOM SEG or NRRD (3D Slicer)");
  }
  if (found.kind == DicomKind::damaged || found.kind == DicomKind::other) {
    throw file.error("a truncated or damaged DICOM file", expected);
  }
  const std::string modality = found.images.empty() ? found.note : found.images.front().modality;
  throw file.error("a DICOM file of modality " + modality + ", not a segmentation (SEG)", expected);
}

}  // namespace

ScanSource open_dicom_seg(const ForeignFile& given, Diagnostics& report) {
  const std::vector<std::string> files = files_below(given.path);
  const std::vector<DicomFile> read = read_dicom_headers(files, given);
  std::vector<std::size_t> found;
  for (std::size_t n = 0; n < files.size(); ++n) {
    if (!read[n].images.empty() && is_segmentation(read[n].images.front())) found.push_back(n);
  }
  if (found.empty()) {
    const auto coded = std::ranges::find(read, DicomKind::unsupported, &DicomFile::kind);
    const auto n = coded == read.end() ? 0 : static_cast<std::size_t>(coded - read.begin());
    if (files.size() == 1 || coded != read.end()) refuse_no_seg(read[n], {files[n], given.key});
    throw given.error("no DICOM segmentation (SEG) in this folder",
                      "give a label map: NRRD, NIfTI, MetaImage or DICOM SEG");
  }
  if (found.size() > 1) {
    std::string list;
    for (const std::size_t n : found) list += (list.empty() ? "" : ", ") + files[n];
    throw given.error(fmt::format("{} DICOM segmentations in this folder", found.size()),
                      "give the file of one: " + list);
  }
  const ForeignFile file{files[found.front()], given.key};
  const DicomHeader& header = read[found.front()].images.front();
  const double pixels = double{1} * header.rows * header.columns * std::max(header.frames, 1);
  check_fits_in_memory(pixels, 1, file);
  return seg_source(file, pixels, report);
}

}  // namespace reamsim::ct

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/isolation/read_in_child.h"
#include "sim/scan/aligned_image.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/dicom_stack.h"
#include "sim/scan/dicom_values.h"
#include "sim/scan/image_io.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

namespace {

constexpr DicomTag kCharacterSet{0x0008, 0x0005};
constexpr DicomTag kCodeMeaning{0x0008, 0x0104};
constexpr DicomTag kSegBits{0x0028, 0x0100};
constexpr DicomTag kSegmentationType{0x0062, 0x0001};
constexpr DicomTag kSegments{0x0062, 0x0002};
constexpr DicomTag kSegmentNumber{0x0062, 0x0004};
constexpr DicomTag kSegmentLabel{0x0062, 0x0005};
constexpr DicomTag kSegmentDescription{0x0062, 0x0006};
constexpr DicomTag kMaximumFraction{0x0062, 0x000e};
constexpr DicomTag kPropertyType{0x0062, 0x000f};
constexpr DicomTag kTypeModifier{0x0062, 0x0011};
constexpr DicomTag kSegPixels{0x7fe0, 0x0010};

bool is_segmentation(const DicomHeader& header) {
  return header.modality == "SEG" || header.sop_class == "1.2.840.10008.5.1.4.1.1.66.4" ||
         header.sop_class == "1.2.840.10008.5.1.4.1.1.66.7";
}

/// A text of any character set as UTF-8; other sets than UTF-8 and Latin-1 lose their special characters.
std::string utf8_text(const DicomValues& values, const DicomTag& tag, const std::string& set) {
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

struct SegFacts {
  ScanGeometry geometry;
  std::string type;
  int layers = 1;
  std::vector<NamedSegment> segments;  ///< their values are their numbers

  static auto fields(auto& self) { return std::tie(self.geometry, self.type, self.layers, self.segments); }
};

/// A segmentation in memory, for child processes.
class SegFile {
 public:
  SegFile(const std::string& path, const std::string& key) : path_(path), key_(key) {
    const QuietLibraries quiet;
    gdcm::Trace::WarningOn();  // GDCM reports missing pixels in no other way
    DicomFile file = read_dicom_header(path);
    frames_ = std::move(file.images);
    reader_.SetFileName(path.c_str());
    if (frames_.empty() || !reader_.Read() || quiet.reports_missing_voxels())
      throw bad_seg(path, key, "the segmentation is truncated or damaged");
    const DicomValues values(reader_.GetFile().GetDataSet());
    facts_.type = values.text(kSegmentationType);
    read_segments(values);
    SegPlanes planes = seg_planes(frames_, path, key);
    facts_.geometry = planes.geometry;
    plane_ = std::move(planes.plane_of_frame);
    open_pixels(values);
  }

  [[nodiscard]] const SegFacts& facts() const { return facts_; }

  /// Puts segments that do not overlap into one layer.
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
      if ((at.array() >= 0).all() && (at.array() < box.size.array()).all()) out[index_in(box.size, at)] = value;
    };
    if (is_label_map()) return for_each_pixel([](const DicomHeader&) { return true; }, put);
    for (const double number : numbers) {
      for_each_voxel_of(number, [&](std::size_t voxel) { put(voxel, static_cast<float>(number)); });
    }
  }

 private:
  [[nodiscard]] bool is_label_map() const { return facts_.type == "LABELMAP"; }

  void read_segments(const DicomValues& values) {
    const std::string set = values.text(kCharacterSet);
    std::map<std::string, int> uses;
    std::vector<std::string> sides;  // of each segment
    const std::vector<DicomValues> items = values.items(kSegments);
    if (items.empty()) throw bad_seg(path_, key_, "the segmentation has no segments");
    for (const DicomValues& item : items) {
      const int number = item.short_integer(kSegmentNumber);
      if (number == 0 && is_label_map()) continue;  // the background
      const std::vector<DicomValues> type = item.items(kPropertyType);
      std::string name = utf8_text(item, kSegmentLabel, set);
      if (name.empty()) name = utf8_text(item, kSegmentDescription, set);
      if (name.empty() && !type.empty()) name = utf8_text(type.front(), kCodeMeaning, set);
      const std::vector<DicomValues> side = type.empty() ? type : type.front().items(kTypeModifier);
      sides.push_back(side.empty() ? std::to_string(number) : utf8_text(side.front(), kCodeMeaning, set));
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
    const Vec3i& dims = facts_.geometry.dims;
    if (values.short_integer(kSegBits) != 1) {
      decoded_ = std::make_unique<DicomFrames>(path_, key_);
      const Vec3i& found = decoded_->dims();
      if (found.x() != dims.x() || found.y() != dims.y() || found.z() < static_cast<int>(frames_.size())) {
        throw bad_seg(path_, key_, "the segmentation is truncated or damaged");
      }
      if (facts_.type == "FRACTIONAL") least_ = 0.5 * std::max(1, values.short_integer(kMaximumFraction));
      return;
    }
    packed_ = values.raw(kSegPixels);
    if (packed_ == nullptr) {
      const std::string syntax = syntax_in_file(path_);
      throw bad_seg(path_, key_,
                    "single bits compressed as " + name_of_syntax(syntax) + " (" + syntax + ") are not read");
    }
    const double pixels = double{1} * dims.x() * dims.y() * static_cast<double>(frames_.size());
    if (8.0 * packed_->GetLength() < pixels) throw bad_seg(path_, key_, "the segmentation is truncated");
  }

  /// Calls visit(voxel, value) for all pixels above 0 of the frames that `wanted` accepts.
  template <class Wanted, class Visit>
  void for_each_pixel(const Wanted& wanted, const Visit& visit) const {
    const Vec3i slice(facts_.geometry.dims.x(), facts_.geometry.dims.y(), 1);
    const auto pixels = static_cast<std::size_t>(slice.x()) * static_cast<std::size_t>(slice.y());
    std::vector<float> values(decoded_ ? pixels : 0);
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      if (!wanted(frames_[f])) continue;
      const std::size_t first = static_cast<std::size_t>(plane_[f]) * pixels;
      if (decoded_) {
        decoded_->copy(static_cast<int>(f), {Vec3i::Zero(), slice}, 1, 0, values.data());
        for (std::size_t p = 0; p < pixels; ++p) {
          if (values[p] > 0 && double{values[p]} >= least_) visit(first + p, values[p]);
        }
        continue;
      }
      const auto* bytes = reinterpret_cast<const unsigned char*>(packed_->GetPointer());
      for (std::size_t p = 0; p < pixels; ++p) {  // frames follow one another without padding
        const std::size_t bit = f * pixels + p;
        if ((bytes[bit / 8] >> (bit % 8) & 1) != 0) visit(first + p, 1.0F);
      }
    }
  }

  template <class Visit>
  void for_each_voxel_of(double number, const Visit& visit) const {
    const std::string wanted = std::to_string(static_cast<int>(number));
    const auto is_wanted = [&](const DicomHeader& frame) { return frame.tag("ReferencedSegmentNumber") == wanted; };
    for_each_pixel(is_wanted, [&](std::size_t voxel, float) { visit(voxel); });
  }

  std::string path_;
  std::string key_;
  gdcm::Reader reader_;
  SegFacts facts_;
  std::vector<DicomHeader> frames_;
  std::vector<int> plane_;                   ///< of each frame
  double least_ = 0;                         ///< value from which a pixel belongs to a fractional segment
  std::unique_ptr<DicomFrames> decoded_;     ///< pixels of whole bytes
  const gdcm::ByteValue* packed_ = nullptr;  ///< single bits
};

void put_seg(ResultWriter& out, const std::string& path, const std::string& key) {
  SegFile seg(path, key);
  seg.assign_layers();
  out.put(seg.facts());
}

void put_seg_layer(ResultWriter& out, const std::string& path, const std::string& key,
                   const std::vector<double>& numbers, const Vec3i& dims, const IndexBox& box) {
  const SegFile seg(path, key);
  if (seg.facts().geometry.dims != dims) {
    throw InputError({path}, key, "the file has changed while it was read", "start again");
  }
  seg.fill(numbers, box, out.array<float>(static_cast<std::size_t>(box.voxels())));
}

class SegSource : public LabelSource {
 public:
  SegSource(const std::string& path, const std::string& key, double pixels, Diagnostics& report)
      : path_(path), key_(key), pixels_(pixels) {
    ChildResult result = read_in_child<put_seg>({path, key}, limits(), path, key);
    facts_ = result.reader().take<SegFacts>();
    if (facts_.type == "FRACTIONAL") {
      report.warn(path + ": a fractional segmentation; voxels of at least half of the maximum belong to a segment");
    }
  }

  [[nodiscard]] const ScanGeometry& geometry() const override { return facts_.geometry; }
  [[nodiscard]] std::string description() const override {
    return fmt::format("DICOM SEG, {} segments", facts_.segments.size());
  }
  [[nodiscard]] Scan read(const IndexBox& box) const override { return read_layer(box, 0); }
  [[nodiscard]] int layers() const override { return facts_.layers; }
  [[nodiscard]] bool has_whole_numbers() const override { return true; }

  [[nodiscard]] Scan read_layer(const IndexBox& box, int layer) const override {
    std::vector<double> numbers;
    for (const NamedSegment& segment : facts_.segments) {
      if (segment.label.layer == layer) numbers.push_back(segment.label.value);
    }
    const auto voxels = static_cast<std::size_t>(box.voxels());
    ReadLimits most = limits();
    most.result_bytes += voxels * sizeof(float);
    const Vec3i& dims = facts_.geometry.dims;
    ChildResult result = read_in_child<put_seg_layer>({path_, key_}, most, path_, key_, numbers, dims, box);
    Scan out{part_of(facts_.geometry, box), result.reader().array<float>()};
    if (out.value.size() != voxels) result.reader().fail();
    return out;
  }

  [[nodiscard]] const std::vector<NamedSegment>& segments() const override { return facts_.segments; }

 private:
  [[nodiscard]] ReadLimits limits() const {
    constexpr double kBytesPerPixel = 16;  // of the coded and decoded frames, and of the voxels of a segment
    return ReadLimits().with(bytes_of_file(path_), static_cast<std::uint64_t>(kBytesPerPixel * pixels_) + (1U << 28));
  }

  std::string path_;
  std::string key_;
  double pixels_;  ///< of all frames
  SegFacts facts_;
};

[[noreturn]] void refuse_no_seg(const DicomFile& file, const std::string& path, const std::string& key) {
  const std::string expected = "give a DICOM SEG, or save the segmentation as NRRD (3D Slicer)";
  if (file.kind == DicomKind::unsupported) {
    throw InputError({path}, key, "coded as " + file.note + ", which GDCM cannot decode", how_to_decode(file.note));
  }
  if (file.kind == DicomKind::no_image && file.note == "RTSTRUCT") {
    throw InputError({path}, key, "a DICOM RT structure set: contours, not voxels",
                     "convert it to DICOM SEG or NRRD (3D Slicer)");
  }
  const std::string modality = file.images.empty() ? file.note : file.images.front().modality;
  if (file.kind == DicomKind::damaged || file.kind == DicomKind::other) {
    throw InputError({path}, key, "a truncated or damaged DICOM file", expected);
  }
  throw InputError({path}, key, "a DICOM file of modality " + modality + ", not a segmentation (SEG)", expected);
}

}  // namespace

std::unique_ptr<LabelSource> open_dicom_seg(const std::string& path, const std::string& key, Diagnostics& report) {
  const std::vector<std::string> files = files_below(path);
  const std::vector<DicomFile> read = read_dicom_headers(files, path, key);
  std::vector<std::size_t> found;
  for (std::size_t n = 0; n < files.size(); ++n) {
    if (!read[n].images.empty() && is_segmentation(read[n].images.front())) found.push_back(n);
  }
  if (found.empty() && files.size() == 1) refuse_no_seg(read.front(), files.front(), key);
  if (found.empty()) {
    throw InputError({path}, key, "no DICOM segmentation (SEG) in this folder",
                     "give a label map: NRRD, NIfTI, MetaImage or DICOM SEG");
  }
  if (found.size() > 1) {
    std::string list;
    for (const std::size_t n : found) list += (list.empty() ? "" : ", ") + files[n];
    throw InputError({path}, key, fmt::format("{} DICOM segmentations in this folder", found.size()),
                     "give the file of one: " + list);
  }
  const DicomHeader& header = read[found.front()].images.front();
  const double pixels = double{1} * header.rows * header.columns * std::max(header.frames, 1);
  check_fits_in_memory(pixels, 1, files[found.front()], key);
  return std::make_unique<SegSource>(files[found.front()], key, pixels, report);
}

}  // namespace reamsim::ct

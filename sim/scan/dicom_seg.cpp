// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/isolation/read_in_child.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/dicom_frames.h"
#include "sim/scan/dicom_header.h"
#include "sim/scan/dicom_seg_planes.h"
#include "sim/scan/dicom_syntax.h"
#include "sim/scan/dicom_values.h"
#include "sim/scan/image_io.h"
#include "sim/scan/scan.h"
#include "sim/scan/scan_transfer.h"
#include "sim/scan/segment.h"

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

struct SegSegment {
  int number = 0;
  std::string name;
  int layer = 0;
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
    type_ = values.text(kSegmentationType);
    read_segments(values);
    SegPlanes planes = seg_planes(frames_, path, key);
    geometry_ = planes.geometry;
    plane_ = std::move(planes.plane_of_frame);
    open_pixels(values);
  }

  [[nodiscard]] const ScanGeometry& geometry() const { return geometry_; }
  [[nodiscard]] bool is_label_map() const { return type_ == "LABELMAP"; }
  [[nodiscard]] const std::string& type() const { return type_; }
  [[nodiscard]] const std::vector<SegSegment>& segments() const { return segments_; }

  /// Puts segments that do not overlap into one layer. Returns the number of layers.
  int assign_layers() {
    if (is_label_map()) return 1;
    std::vector<std::vector<bool>> taken;
    const auto pixels = static_cast<std::size_t>(geometry_.dims.x()) * static_cast<std::size_t>(geometry_.dims.y());
    for (SegSegment& segment : segments_) {
      std::vector<std::size_t> voxels;
      for_each_voxel_of(segment.number,
                        [&](std::size_t plane, std::size_t pixel) { voxels.push_back(plane * pixels + pixel); });
      const auto is_free = [&](const std::vector<bool>& layer) {
        return std::ranges::none_of(voxels, [&](std::size_t voxel) { return layer[voxel]; });
      };
      auto layer = std::ranges::find_if(taken, is_free);
      if (layer == taken.end()) {
        taken.emplace_back(static_cast<std::size_t>(geometry_.size()));
        layer = taken.end() - 1;
      }
      for (const std::size_t voxel : voxels) (*layer)[voxel] = true;
      segment.layer = static_cast<int>(layer - taken.begin());
    }
    return std::max(1, static_cast<int>(taken.size()));
  }

  /// Writes the numbers of these segments in a box.
  void fill(const std::vector<int>& numbers, const IndexBox& box, float* out) const {
    std::fill_n(out, box.voxels(), 0.0F);
    const auto columns = static_cast<std::size_t>(geometry_.dims.x());
    const auto put = [&](std::size_t plane, std::size_t pixel, float value) {
      const Vec3i at =
          Vec3i(static_cast<int>(pixel % columns), static_cast<int>(pixel / columns), static_cast<int>(plane)) -
          box.start;
      if ((at.array() >= 0).all() && (at.array() < box.size.array()).all()) out[index_in(box.size, at)] = value;
    };
    if (is_label_map()) {
      for_each_pixel([](const DicomHeader&) { return true; }, put);
      return;
    }
    for (const int number : numbers) {
      for_each_voxel_of(number,
                        [&](std::size_t plane, std::size_t pixel) { put(plane, pixel, static_cast<float>(number)); });
    }
  }

 private:
  void read_segments(const DicomValues& values) {
    const std::string set = values.text(kCharacterSet);
    std::map<std::string, int> uses;
    const std::vector<DicomValues> items = values.items(kSegments);
    if (items.empty()) throw bad_seg(path_, key_, "the segmentation has no segments");
    for (const DicomValues& item : items) {
      SegSegment out{item.short_integer(kSegmentNumber), utf8_text(item, kSegmentLabel, set), 0};
      if (out.number == 0 && is_label_map()) continue;  // the background
      if (out.name.empty()) out.name = utf8_text(item, kSegmentDescription, set);
      const std::vector<DicomValues> type = item.items(kPropertyType);
      if (out.name.empty() && !type.empty()) out.name = utf8_text(type.front(), kCodeMeaning, set);
      ++uses[out.name];
      segments_.push_back(std::move(out));
    }
    // dcmqi writes "Scapula" twice, and the side as a modifier of the type.
    std::size_t n = 0;
    for (const DicomValues& item : items) {
      if (n >= segments_.size() || item.short_integer(kSegmentNumber) != segments_[n].number) continue;
      SegSegment& segment = segments_[n++];
      if (uses[segment.name] < 2) continue;
      const std::vector<DicomValues> type = item.items(kPropertyType);
      const std::vector<DicomValues> side = type.empty() ? type : type.front().items(kTypeModifier);
      const std::string more =
          side.empty() ? std::to_string(segment.number) : utf8_text(side.front(), kCodeMeaning, set);
      segment.name += " (" + more + ")";
    }
  }

  void open_pixels(const DicomValues& values) {
    bits_ = values.short_integer(kSegBits);
    const auto pixels =
        static_cast<double>(geometry_.dims.x()) * geometry_.dims.y() * static_cast<double>(frames_.size());
    if (bits_ != 1) {
      decoded_ = std::make_unique<DicomFrames>(path_, key_);
      const Vec3i& dims = decoded_->dims();
      if (dims.x() != geometry_.dims.x() || dims.y() != geometry_.dims.y() ||
          dims.z() < static_cast<int>(frames_.size())) {
        throw bad_seg(path_, key_, "the segmentation is truncated or damaged");
      }
      if (type_ == "FRACTIONAL") least_ = 0.5 * std::max(1, values.short_integer(kMaximumFraction));
      return;
    }
    const std::string syntax = syntax_in_file(path_);
    const gdcm::DataSet& data = reader_.GetFile().GetDataSet();
    const gdcm::Tag tag(kSegPixels.group, kSegPixels.element);
    const gdcm::ByteValue* value = data.FindDataElement(tag) ? data.GetDataElement(tag).GetByteValue() : nullptr;
    if (value == nullptr) {
      throw bad_seg(path_, key_,
                    "single bits compressed as " + name_of_syntax(syntax) + " (" + syntax + ") are not read");
    }
    if (8.0 * value->GetLength() < pixels) throw bad_seg(path_, key_, "the segmentation is truncated");
    packed_ = value;
  }

  /// Calls visit(plane, pixel, value) for all pixels above 0 of the frames that `wanted` accepts.
  template <class Wanted, class Visit>
  void for_each_pixel(const Wanted& wanted, const Visit& visit) const {
    const Vec3i slice(geometry_.dims.x(), geometry_.dims.y(), 1);
    const auto pixels = static_cast<std::size_t>(slice.x()) * static_cast<std::size_t>(slice.y());
    std::vector<float> values(decoded_ ? pixels : 0);
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      if (!wanted(frames_[f])) continue;
      const auto plane = static_cast<std::size_t>(plane_[f]);
      if (decoded_) {
        decoded_->copy(static_cast<int>(f), {Vec3i::Zero(), slice}, 1, 0, values.data());
        for (std::size_t p = 0; p < pixels; ++p) {
          if (values[p] > 0 && double{values[p]} >= least_) visit(plane, p, values[p]);
        }
        continue;
      }
      const auto* bytes = reinterpret_cast<const unsigned char*>(packed_->GetPointer());
      for (std::size_t p = 0; p < pixels; ++p) {  // frames follow one another without padding
        const std::size_t bit = f * pixels + p;
        if ((bytes[bit / 8] >> (bit % 8) & 1) != 0) visit(plane, p, 1.0F);
      }
    }
  }

  template <class Visit>
  void for_each_voxel_of(int number, const Visit& visit) const {
    const std::string wanted = std::to_string(number);
    const auto is_wanted = [&](const DicomHeader& frame) {
      const auto found = frame.tags.find("ReferencedSegmentNumber");
      return found != frame.tags.end() && found->second == wanted;
    };
    for_each_pixel(is_wanted, [&](std::size_t plane, std::size_t pixel, float) { visit(plane, pixel); });
  }

  std::string path_;
  std::string key_;
  gdcm::Reader reader_;
  std::string type_;
  std::vector<DicomHeader> frames_;
  std::vector<int> plane_;  ///< of each frame
  std::vector<SegSegment> segments_;
  ScanGeometry geometry_;
  int bits_ = 1;
  double least_ = 0;                         ///< value from which a pixel belongs to a fractional segment
  std::unique_ptr<DicomFrames> decoded_;     ///< pixels of whole bytes
  const gdcm::ByteValue* packed_ = nullptr;  ///< single bits
};

void put_seg(ResultWriter& out, const std::string& path, const std::string& key) {
  SegFile seg(path, key);
  const int layers = seg.assign_layers();
  put_geometry(out, seg.geometry());
  out.put(seg.type());
  out.put(layers);
  out.put(std::uint64_t{seg.segments().size()});
  for (const SegSegment& segment : seg.segments()) {
    out.put(segment.number);
    out.put(segment.name);
    out.put(segment.layer);
  }
}

void put_seg_layer(ResultWriter& out, const std::string& path, const std::string& key, const std::vector<int>& numbers,
                   const PlainBox& whole, const PlainBox& part) {
  const SegFile seg(path, key);
  if (seg.geometry().dims != whole.get().size) {
    throw InputError({path}, key, "the file has changed while it was read", "start again");
  }
  const IndexBox box = part.get();
  seg.fill(numbers, box, out.array<float>(static_cast<std::size_t>(box.voxels())));
}

class SegSource : public LabelSource {
 public:
  SegSource(const std::string& path, const std::string& key, double pixels, Diagnostics& report)
      : path_(path), key_(key), pixels_(pixels) {
    ChildResult result = read_in_child<put_seg>({path, key}, limits(), path, key);
    ResultReader& in = result.reader();
    geometry_ = take_geometry(in);
    type_ = in.text();
    layers_ = in.get<int>();
    for (auto left = in.get<std::uint64_t>(); left > 0; --left) {
      SegSegment segment;
      segment.number = in.get<int>();
      segment.name = in.text();
      segment.layer = in.get<int>();
      segments_.push_back(std::move(segment));
    }
    if (type_ == "FRACTIONAL") {
      report.warn(path + ": a fractional segmentation; voxels of at least half of the maximum belong to a segment");
    }
  }

  [[nodiscard]] const ScanGeometry& geometry() const override { return geometry_; }
  [[nodiscard]] std::string description() const override {
    return fmt::format("DICOM SEG, {} segments", segments_.size());
  }
  [[nodiscard]] Scan read(const IndexBox& box) const override { return read_layer(box, 0); }
  [[nodiscard]] int layers() const override { return layers_; }
  [[nodiscard]] bool has_whole_numbers() const override { return true; }

  [[nodiscard]] Scan read_layer(const IndexBox& box, int layer) const override {
    std::vector<int> numbers;
    for (const SegSegment& segment : segments_) {
      if (segment.layer == layer) numbers.push_back(segment.number);
    }
    const auto voxels = static_cast<std::size_t>(box.voxels());
    ReadLimits most = limits();
    most.result_bytes += voxels * sizeof(float);
    const PlainBox whole({Vec3i::Zero(), geometry_.dims});
    ChildResult result = read_in_child<put_seg_layer>({path_, key_}, most, path_, key_, numbers, whole, PlainBox(box));
    Scan out{part_of(geometry_, box), result.reader().array<float>()};
    if (out.value.size() != voxels) result.reader().fail();
    return out;
  }

  /// As the header of a .seg.nrrd says it.
  [[nodiscard]] std::map<std::string, std::string> metadata() const override {
    std::map<std::string, std::string> out;
    for (std::size_t n = 0; n < segments_.size(); ++n) {
      const std::string prefix = "Segment" + std::to_string(n) + "_";
      out[prefix + "Name"] = segments_[n].name;
      out[prefix + "Layer"] = std::to_string(segments_[n].layer);
      out[prefix + "LabelValue"] = std::to_string(segments_[n].number);
    }
    return out;
  }

 private:
  [[nodiscard]] ReadLimits limits() const {
    constexpr double kBytesPerPixel = 16;  // of the coded and decoded frames, and of the voxels of a segment
    return ReadLimits().with(bytes_of_file(path_), static_cast<std::uint64_t>(kBytesPerPixel * pixels_) + (1U << 28));
  }

  std::string path_;
  std::string key_;
  double pixels_;  ///< of all frames
  ScanGeometry geometry_;
  std::string type_;
  int layers_ = 1;
  std::vector<SegSegment> segments_;
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

std::vector<std::string> files_in(const std::string& path) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(path)) return {path};
  std::vector<std::string> out;
  for (const auto& entry : fs::recursive_directory_iterator(path, fs::directory_options::skip_permission_denied)) {
    std::error_code ignored;
    if (entry.is_regular_file(ignored)) out.push_back(entry.path().string());
  }
  std::ranges::sort(out);
  return out;
}

}  // namespace

std::unique_ptr<LabelSource> open_dicom_seg(const std::string& path, const std::string& key, Diagnostics& report) {
  const std::vector<std::string> files = files_in(path);
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

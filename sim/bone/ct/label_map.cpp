#include "sim/bone/ct/label_map.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "sim/base/error.h"
#include "sim/bone/ct/scan.h"
#include "sim/bone/ct/words.h"

namespace reamsim::ct {

namespace {

constexpr const char* kLabelPathKey = "bone.ct.label_map.path";
/// Contact of the label with the end of the map, bone beyond it, from which on the bone counts as cut off.
constexpr double kCutOff_mm2 = 5;
constexpr std::size_t kMostValues = 20;

/// What the voxels of one layer are: wanted, another label, or none.
class LayerClasses {
 public:
  LayerClasses(const std::vector<LabelValue>& labels, int layer) {
    for (const LabelValue& label : labels) {
      if (label.layer == layer) wanted_.insert(static_cast<float>(label.value));
    }
  }

  [[nodiscard]] bool any() const { return !wanted_.empty(); }
  [[nodiscard]] bool is_wanted(float value) const { return value != 0 && wanted_.contains(value); }

  void note(float value) {
    if (value == last_) return;
    last_ = value;
    if (value != 0) seen_.insert(value);
  }
  [[nodiscard]] const std::set<float>& seen() const { return seen_; }

 private:
  std::set<float> wanted_;
  std::set<float> seen_;
  float last_ = 0;
};

/// The voxels of `labels` that a part of the image can meet; empty where it meets none.
IndexBox part_that_meets(const ScanGeometry& labels, const ScanGeometry& image) {
  const Mat3 index_from_mm = labels.step_mm.inverse();
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 at;
    for (int axis = 0; axis < 3; ++axis) at[axis] = ((corner >> axis) & 1) ? image.dims[axis] - 1 : 0;
    const Vec3 index = index_from_mm * (image.point_mm(at) - labels.origin_mm);
    low = low.cwiseMin(index);
    high = high.cwiseMax(index);
  }
  IndexBox out;
  for (int axis = 0; axis < 3; ++axis) {
    // A voxel more on either side, for the rounding of halfway points and to see past the label's border.
    const double from = std::clamp(std::floor(low[axis]) - 1, 0.0, static_cast<double>(labels.dims[axis]));
    const double to = std::clamp(std::ceil(high[axis]) + 1, -1.0, labels.dims[axis] - 1.0);
    out.start[axis] = static_cast<int>(from);
    out.size[axis] = static_cast<int>(to - from) + 1;
  }
  return out;
}

InputError does_not_meet(const std::string& path, const ScanGeometry& labels, const ScanGeometry& image,
                         const ScanGeometry& part) {
  std::string found = "the label map does not overlap the image: it spans " + box_words(labels.bounds_mm()) +
                      ", the image spans " + box_words(image.bounds_mm());
  if (part.dims != image.dims) found += ", cropped to " + box_words(part.bounds_mm());
  return {{path},
          kLabelPathKey,
          found + " (LPS)",
          "expected a map of the same scan; check its origin and axes (RAS or LPS)"};
}

/// Bone that goes on in the image where the map ends.
struct CutOff {
  double contact_mm2 = 0;
  double bone_mm2 = 0;
};

bool is_bone_at(const AlignedImage& hu, const Vec3& point_mm, double threshold_hu) {
  const Vec3i voxel = hu.lattice.voxel_of(point_mm);
  if (!hu.lattice.contains(voxel)) return false;
  return static_cast<double>(hu.value[hu.lattice.index(voxel.x(), voxel.y(), voxel.z())]) >= threshold_hu;
}

/// Adds what the label's voxels on one end of the map, along one axis, have beyond them.
void add_end(const ScanGeometry& labels, const Scan& part, const IndexBox& box, const LayerClasses& classes, int axis,
             bool upper, const AlignedImage& hu, double threshold_hu, CutOff& cut) {
  const int level = upper ? labels.dims[axis] - 1 : 0;
  if (level < box.start[axis] || level >= box.start[axis] + box.size[axis]) return;
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  const double area = labels.step_mm.col(u).cross(labels.step_mm.col(v)).norm();
  const Vec3i& size = part.geometry.dims;
  for (int b = 0; b < size[v]; ++b) {
    for (int a = 0; a < size[u]; ++a) {
      Vec3i c;
      c[axis] = level - box.start[axis];
      c[u] = a;
      c[v] = b;
      const auto at =
          static_cast<std::size_t>(c.x() + std::int64_t{size.x()} * (c.y() + std::int64_t{size.y()} * c.z()));
      if (!classes.is_wanted(part.value[at])) continue;
      Vec3 beyond = (c + box.start).cast<double>();
      beyond[axis] += upper ? 1 : -1;
      const Vec3 point = labels.point_mm(beyond);
      if (!hu.lattice.contains(hu.lattice.voxel_of(point))) continue;
      cut.contact_mm2 += area;
      if (is_bone_at(hu, point, threshold_hu)) cut.bone_mm2 += area;
    }
  }
}

void report_cut_off(const CutOff& cut, const std::string& path, double threshold_hu, Report& report) {
  if (cut.contact_mm2 == 0) return;
  const std::string text =
      path + fmt::format(
                 ": the label touches the border of the map over {:.0f} mm2 inside the image, with "
                 "{:.0f} mm2 at or above {:.0f} HU beyond it",
                 cut.contact_mm2, cut.bone_mm2, threshold_hu);
  if (cut.bone_mm2 >= kCutOff_mm2) {
    report.warn(text + "; the map truncates the bone there");
  } else {
    report.note(text);
  }
}

class LabelReader {
 public:
  LabelReader(const CtSettings& settings, const ScanGeometry& image, const IndexBox& box, const AlignedImage& hu,
              Report& report)
      : settings_(settings),
        map_(*settings.label_map),
        image_(image),
        part_(part_of(image, box)),
        hu_(hu),
        report_(report),
        source_(open_labels(map_.path, kLabelPathKey)) {}

  LabelImages read() {
    const std::vector<LabelValue> labels = wanted();
    const IndexBox box = part_that_meets(source_->geometry(), part_);
    if (box.empty()) throw does_not_meet(map_.path, source_->geometry(), image_, part_);
    const std::size_t voxels = static_cast<std::size_t>(part_.size());
    share_.assign(voxels, 0);
    if (map_.refine_mm > 0) other_.assign(voxels, 0);
    for (int layer = 0; layer < source_->layers(); ++layer) {
      LayerClasses classes(labels, layer);
      if (classes.any()) add_layer(box, layer, classes);
    }
    if (inside_ == 0) throw does_not_meet(map_.path, source_->geometry(), image_, part_);
    if (wanted_voxels_ == 0) fail_without_label();
    report_cut_off(cut_, map_.path, settings_.threshold_hu, report_);
    const Crop crop{settings_.crop_min_mm, settings_.crop_max_mm};
    LabelImages out{align_to_lps({part_, std::move(share_)}, crop, 0), {}};
    if (!other_.empty()) out.other = align_to_lps({part_, std::move(other_)}, crop, 0);
    return out;
  }

 private:
  [[nodiscard]] std::vector<LabelValue> wanted() const {
    std::vector<NamedSegment> segments = segments_of_nrrd(source_->metadata(), source_->layers());
    if (segments.empty()) segments = segments_of_nifti(map_.path);
    report_.note("label map " + map_.path + ": " + source_->description() + shape());
    return find_labels(map_.label, segments, source_->layers(), map_.path);
  }

  [[nodiscard]] std::string shape() const {
    const ScanGeometry& g = source_->geometry();
    const Vec3 s = g.spacing_mm();
    std::string out = fmt::format(", {}x{}x{} voxels of {:.4g}x{:.4g}x{:.4g} mm, ", g.dims.x(), g.dims.y(), g.dims.z(),
                                  s.x(), s.y(), s.z());
    if (source_->layers() > 1) out += std::to_string(source_->layers()) + " layers, ";
    return out + box_words(g.bounds_mm());
  }

  void add_layer(const IndexBox& box, int layer, LayerClasses& classes) {
    const Scan labels = source_->read_layer(box, layer);
    check_whole(labels, box);
    const NearestVoxel nearest(source_->geometry(), part_);
    std::size_t at = 0;
    for (int k = 0; k < part_.dims.z(); ++k) {
      for (int j = 0; j < part_.dims.y(); ++j) {
        for (int i = 0; i < part_.dims.x(); ++i, ++at) {
          const Vec3i c = nearest(i, j, k) - box.start;
          if ((c.array() < 0).any() || (c.array() >= box.size.array()).any()) continue;
          ++inside_;
          const float value = labels.value[static_cast<std::size_t>(
              c.x() + std::int64_t{box.size.x()} * (c.y() + std::int64_t{box.size.y()} * c.z()))];
          classes.note(value);
          if (classes.is_wanted(value)) {
            share_[at] = 1;
            ++wanted_voxels_;
          } else if (value != 0 && !other_.empty()) {
            other_[at] = 1;
          }
        }
      }
    }
    seen_.insert(classes.seen().begin(), classes.seen().end());
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool upper : {false, true}) {
        add_end(source_->geometry(), labels, box, classes, axis, upper, hu_, settings_.threshold_hu, cut_);
      }
    }
  }

  /// Labels are whole numbers; many programs write them as floating-point numbers all the same.
  void check_whole(const Scan& labels, const IndexBox& box) const {
    if (source_->has_whole_numbers()) return;
    for (std::size_t at = 0; at < labels.value.size(); ++at) {
      const float value = labels.value[at];
      if (std::isfinite(value) && value == std::floor(value)) continue;
      const auto n = static_cast<std::int64_t>(at);
      const Vec3i c =
          box.start + Vec3i(static_cast<int>(n % box.size.x()), static_cast<int>(n / box.size.x() % box.size.y()),
                            static_cast<int>(n / box.size.x() / box.size.y()));
      throw InputError({map_.path}, kLabelPathKey,
                       fmt::format("the value {:g} at voxel ({}, {}, {}) is not a label", static_cast<double>(value),
                                   c.x(), c.y(), c.z()),
                       "expected whole numbers; threshold a probability map and save it as integers");
    }
  }

  [[noreturn]] void fail_without_label() const {
    std::string values;
    std::size_t count = 0;
    for (const float value : seen_) {
      if (++count > kMostValues) break;
      values += (values.empty() ? "" : ", ") + fmt::format("{:.0f}", static_cast<double>(value));
    }
    if (count > kMostValues) values += ", ...";
    throw InputError(
        {map_.path}, "bone.ct.label_map.label", "no voxel in the crop has label " + words_of_labels(map_.label),
        values.empty() ? "the map has no label there; move the crop" : "the map holds " + values + " there");
  }

  const CtSettings& settings_;
  const LabelMapSettings& map_;
  const ScanGeometry& image_;
  ScanGeometry part_;
  const AlignedImage& hu_;
  Report& report_;
  std::unique_ptr<LabelSource> source_;
  std::vector<float> share_;
  std::vector<float> other_;
  std::set<float> seen_;
  std::int64_t inside_ = 0;
  std::int64_t wanted_voxels_ = 0;
  CutOff cut_;
};

}  // namespace

NearestVoxel::NearestVoxel(const ScanGeometry& labels, const ScanGeometry& image) {
  const Mat3 index_from_mm = labels.step_mm.inverse();
  step_ = index_from_mm * image.step_mm;
  first_ = index_from_mm * (image.origin_mm - labels.origin_mm);
  last_ = labels.dims.cast<double>() - Vec3::Ones();
  for (int axis = 0; axis < 3; ++axis) {
    int along = 0;
    labels.step_mm.col(axis).cwiseAbs().maxCoeff(&along);
    forward_[axis] = labels.step_mm(along, axis) > 0;
  }
}

LabelImages read_labels(const CtSettings& settings, const ScanGeometry& image, const IndexBox& box,
                        const AlignedImage& hu, Report& report) {
  return LabelReader(settings, image, box, hu, report).read();
}

}  // namespace reamsim::ct

#include "sim/bone/ct/ct_import.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <stdexcept>

#include "sim/base/error.h"
#include "sim/bone/ct/aligned_image.h"
#include "sim/bone/ct/boundary_density.h"
#include "sim/bone/ct/morphology.h"
#include "sim/bone/ct/scan.h"
#include "sim/bone/ct/segment.h"
#include "sim/bone/ct/voxelize.h"
#include "sim/bone/ct/words.h"

namespace reamsim {

namespace {

constexpr const char* kPathKey = "bone.ct.path";
constexpr const char* kLabelKey = "bone.ct.label_map.path";
/// Labels and image must lie in the same place within this share of a voxel.
constexpr double kSamePlace_voxels = 0.02;

std::string shape_text(const ct::ScanGeometry& g) {
  const Vec3 spacing = g.spacing_mm();
  return ct::words("%dx%dx%d voxels of %.4gx%.4gx%.4g mm", g.dims.x(), g.dims.y(), g.dims.z(), spacing.x(), spacing.y(),
                   spacing.z());
}

void note_image(const ct::ScanSource& source, const std::string& path, Report& report) {
  report.note("image " + path + ": " + source.description() + ", " + shape_text(source.geometry()) + ", " +
              (ct::is_axis_aligned(source.geometry()) ? "axes along LPS" : "oblique, resampled to LPS axes") + ", " +
              ct::box_words(source.geometry().bounds_mm()));
  if (source.is_unsigned()) {
    report.warn(path +
                ": unsigned pixels hold no negative HU; if the values are not HU, threshold and density are wrong");
  }
}

/// Puts the least value where a voxel holds no number (padding outside the field of view is often NaN); returns it.
float replace_non_finite(std::vector<float>& values, const std::string& path, const char* key, Report& report) {
  float least = std::numeric_limits<float>::infinity();
  for (const float value : values) {
    if (std::isfinite(value)) least = std::min(least, value);
  }
  if (!std::isfinite(least)) throw InputError({path}, key, "no voxel in the crop is a finite number", "expected HU");
  const auto strange = [](float value) { return !std::isfinite(value); };
  const auto count = std::count_if(values.begin(), values.end(), strange);
  if (count == 0) return least;
  std::replace_if(values.begin(), values.end(), strange, least);
  report.warn(path + ct::words(": %lld voxels are NaN or infinite; taken as %.0f, the least value",
                               static_cast<long long>(count), static_cast<double>(least)));
  return least;
}

/// The voxels in the crop, at LPS axes. What an oblique image does not cover gets `outside`, or its least value.
ct::AlignedImage read_cropped(const ct::ScanSource& source, const CtSettings& settings, const std::string& path,
                              const char* key, std::optional<float> outside, Report& report) {
  const ct::Crop crop{settings.crop_min_mm, settings.crop_max_mm};
  const ct::IndexBox box = ct::voxels_in_crop(source.geometry(), crop);
  if (box.empty()) {
    throw InputError({path}, "bone.ct.crop_min_mm, bone.ct.crop_max_mm", "no voxel of the image lies in the crop",
                     "the image spans " + ct::box_words(source.geometry().bounds_mm()) + " (LPS)");
  }
  ct::check_fits_in_memory(static_cast<double>(box.voxels()), 2 * sizeof(float), path, key);
  ct::Scan scan = source.read(box);
  const float least = replace_non_finite(scan.value, path, key, report);
  return ct::align_to_lps(std::move(scan), crop, outside.value_or(least));
}

void note_crop(const ct::AlignedImage& image, const ct::ScanSource& source, Report& report) {
  if (image.lattice.size() >= source.geometry().size()) return;
  const Vec3i& dims = image.lattice.dims;
  report.note(ct::words("crop: %dx%dx%d voxels, ", dims.x(), dims.y(), dims.z()) +
              ct::box_words(image.lattice.bounds_mm()));
}

void filter(ct::AlignedImage& image, const CtSettings& settings, Report& report) {
  if (settings.filter == "median") {
    ct::median_filter(image, settings.median_radius_voxels);
    report.note("median filter, radius " + std::to_string(settings.median_radius_voxels) + " voxels");
  } else if (settings.filter == "curvature_anisotropic") {
    ct::curvature_anisotropic_filter(image, settings.anisotropic_iterations, settings.anisotropic_conductance);
    report.note(ct::words("curvature anisotropic diffusion, %d iterations, conductance %g",
                          settings.anisotropic_iterations, settings.anisotropic_conductance));
  } else if (settings.filter != "none") {
    throw InputError({}, "bone.ct.filter", "'" + settings.filter + "'",
                     "expected none, median or curvature_anisotropic");
  }
}

void check_same_place(const ct::ScanGeometry& image, const ct::ScanGeometry& labels, const std::string& path) {
  const Vec3 last = (image.dims - Vec3i::Ones()).cast<double>();
  const double tolerance = kSamePlace_voxels * image.spacing_mm().minCoeff();
  double apart = (image.point_mm(Vec3::Zero()) - labels.point_mm(Vec3::Zero())).norm();
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 index = last.cwiseProduct(Vec3::Unit(axis));
    apart = std::max(apart, (image.point_mm(index) - labels.point_mm(index)).norm());
  }
  if (image.dims == labels.dims && apart <= tolerance) return;
  throw InputError(
      {path}, kLabelKey,
      "the label map has " + shape_text(labels) + " from " +
          ct::words("(%.2f, %.2f, %.2f)", labels.origin_mm.x(), labels.origin_mm.y(), labels.origin_mm.z()),
      "it must match the image: " + shape_text(image) + " from " +
          ct::words("(%.2f, %.2f, %.2f), same axes", image.origin_mm.x(), image.origin_mm.y(), image.origin_mm.z()));
}

/// A label map as an image of shares: 1 in voxels with the label, 0 in the others. Made before anything interpolates,
/// because between labels 1 and 3 lies no label 2.
class ShareOfLabel : public ct::ScanSource {
 public:
  ShareOfLabel(const ct::ScanSource& labels, const ct::ScanGeometry& image, int label)
      : labels_(labels), image_(image), label_(static_cast<float>(label)) {}

  /// The image's own geometry: both become the same lattice, whatever the rounding in the headers.
  [[nodiscard]] const ct::ScanGeometry& geometry() const override { return image_; }
  [[nodiscard]] std::string description() const override { return labels_.description(); }
  [[nodiscard]] bool is_unsigned() const override { return labels_.is_unsigned(); }

  [[nodiscard]] ct::Scan read(const ct::IndexBox& box) const override {
    ct::Scan scan = labels_.read(box);
    scan.geometry = ct::part_of(image_, box);
    for (float& value : scan.value) value = value == label_ ? 1 : 0;
    return scan;
  }

 private:
  const ct::ScanSource& labels_;
  const ct::ScanGeometry& image_;
  float label_;
};

/// 1 where the label map has the label, 0 elsewhere, on the lattice of the image.
ct::AlignedImage read_label(const CtSettings& settings, const ct::ScanGeometry& image, Report& report) {
  const std::string& path = settings.label_map->path;
  const auto source = ct::open_scan(path, kLabelKey, report);
  check_same_place(image, source->geometry(), path);
  const ShareOfLabel share(*source, image, settings.label_map->label);
  report.note("label map " + path + ": " + source->description());
  return read_cropped(share, settings, path, kLabelKey, 0.0F, report);
}

void note_trabecular(const ct::BoneField& bone, double threshold_hu, Report& report) {
  report.note(ct::words("inside kept: %lld of %lld bone voxels (%.1f %%) are below %.0f HU",
                        static_cast<long long>(bone.inside_below), static_cast<long long>(bone.voxels),
                        100.0 * static_cast<double>(bone.inside_below) / static_cast<double>(bone.voxels),
                        threshold_hu));
}

void note_boundary(const ct::BoundaryDensity& boundary, Report& report) {
  report.note(ct::words(
      "partial volume: the density of %lld boundary voxels comes from the bone below them; in %.1f %% of "
      "them the cortex is thinner than the scan resolves, and the density is a lower bound (noise %.0f HU)",
      static_cast<long long>(boundary.boundary_voxels), 100 * boundary.unresolved_fraction(), boundary.noise_hu));
}

}  // namespace

Voxmap voxmap_from_scan(const ct::ScanSource& source, const BoneSettings& settings, Report& report) {
  const CtSettings& ct_settings = settings.ct;
  ct::AlignedImage hu = read_cropped(source, ct_settings, ct_settings.path, kPathKey, std::nullopt, report);
  note_crop(hu, source, report);
  filter(hu, ct_settings, report);
  const ct::BoneField bone =
      ct_settings.label_map
          ? ct::segment_by_label(read_label(ct_settings, source.geometry(), report), hu, ct_settings, report)
          : ct::segment_by_threshold(hu, ct_settings, report);
  note_trabecular(bone, ct_settings.threshold_hu, report);
  note_boundary(
      ct::correct_boundary(hu, bone, ct_settings.psf_mm, ct::resampling_reach(hu.lattice, settings.voxel_mm)), report);
  return ct::voxelize(hu, bone, settings, report);
}

Voxmap voxmap_from_ct(const BoneSettings& settings, Report& report) {
  const CtSettings& ct_settings = settings.ct;
  try {
    const auto source = ct::open_scan(ct_settings.path, kPathKey, report);
    note_image(*source, ct_settings.path, report);
    return voxmap_from_scan(*source, settings, report);
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw InputError({ct_settings.path}, kPathKey, "the image and its voxmap take more memory than this machine has",
                     "crop it, or use larger voxels");
  } catch (const std::exception&) {  // whatever ITK throws inside a filter
    throw InputError({ct_settings.path}, kPathKey,
                     "the image cannot be processed; its size, spacing or axes are absurd",
                     "check the file, or crop it");
  }
}

}  // namespace reamsim

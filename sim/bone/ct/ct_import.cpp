#include "sim/bone/ct/ct_import.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <new>
#include <stdexcept>

#include "sim/base/error.h"
#include "sim/bone/ct/aligned_image.h"
#include "sim/bone/ct/morphology.h"
#include "sim/bone/ct/resample.h"
#include "sim/bone/ct/scan.h"
#include "sim/bone/ct/segment.h"

namespace reamsim {

namespace {

constexpr const char* kPathKey = "bone.ct.path";
constexpr const char* kLabelKey = "bone.ct.label_map.path";
/// Air round the bone, so that a surface can be drawn and a tool's path starts outside.
constexpr int kMarginVoxels = 4;
/// Labels and image must lie in the same place within this share of a voxel.
constexpr double kSamePlace_voxels = 0.02;

template <typename... Values>
std::string text(const char* format, Values... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

std::string box_text(const Aabb& box) {
  return text("(%.1f, %.1f, %.1f) to (%.1f, %.1f, %.1f) mm", box.min.x(), box.min.y(), box.min.z(), box.max.x(),
              box.max.y(), box.max.z());
}

std::string shape_text(const ct::ScanGeometry& g) {
  const Vec3 spacing = g.spacing_mm();
  return text("%dx%dx%d voxels of %.4gx%.4gx%.4g mm", g.dims.x(), g.dims.y(), g.dims.z(), spacing.x(), spacing.y(),
              spacing.z());
}

void note_image(const ct::ScanSource& source, const std::string& path, Report& report) {
  report.note("image " + path + ": " + source.description() + ", " + shape_text(source.geometry()) + ", " +
              (ct::is_axis_aligned(source.geometry()) ? "axes along LPS" : "oblique, resampled to LPS axes") + ", " +
              box_text(source.geometry().bounds_mm()));
  if (source.is_unsigned()) {
    report.warn(path +
                ": unsigned pixels hold no negative HU; if the values are not HU, threshold and density are wrong");
  }
}

/// The voxels in the crop, at LPS axes. `outside` fills what an oblique image does not cover; without it, the least
/// value.
ct::AlignedImage read_cropped(const ct::ScanSource& source, const CtSettings& settings, const std::string& path,
                              const char* key, bool is_label, Report& report) {
  const ct::Crop crop{settings.crop_min_mm, settings.crop_max_mm};
  const ct::IndexBox box = ct::voxels_in_crop(source.geometry(), crop);
  if (box.empty()) {
    throw InputError({path}, "bone.ct.crop_min_mm, bone.ct.crop_max_mm", "no voxel of the image lies in the crop",
                     "the image spans " + box_text(source.geometry().bounds_mm()) + " (LPS)");
  }
  ct::check_fits_in_memory(box.size.cast<double>().prod(), 2 * sizeof(float), path, key);
  ct::Scan scan = source.read(box);
  float least = std::numeric_limits<float>::infinity();
  for (const float value : scan.value) {
    if (std::isfinite(value)) least = std::min(least, value);
  }
  if (!std::isfinite(least)) throw InputError({path}, key, "no voxel in the crop is a finite number", "expected HU");
  std::int64_t strange = 0;
  for (float& value : scan.value) {
    if (std::isfinite(value)) continue;
    value = least;
    ++strange;
  }
  if (strange > 0) {
    report.warn(path + ": " + std::to_string(strange) + " voxels are NaN or infinite; taken as " +
                text("%.0f", static_cast<double>(least)) + ", the least value");
  }
  const bool cropped = box.size != source.geometry().dims;
  ct::AlignedImage image = ct::align_to_lps(std::move(scan), crop, is_label ? 0 : least);
  if (cropped && !is_label) {
    report.note(
        text("crop: %dx%dx%d voxels, ", image.lattice.dims.x(), image.lattice.dims.y(), image.lattice.dims.z()) +
        box_text(image.lattice.bounds_mm()));
  }
  return image;
}

void filter(ct::AlignedImage& image, const CtSettings& settings, Report& report) {
  if (settings.filter == "median") {
    ct::median_filter(image, settings.median_radius_voxels);
    report.note("median filter, radius " + std::to_string(settings.median_radius_voxels) + " voxels");
  } else if (settings.filter == "curvature_anisotropic") {
    ct::curvature_anisotropic_filter(image, settings.anisotropic_iterations, settings.anisotropic_conductance);
    report.note(text("curvature anisotropic diffusion, %d iterations, conductance %g", settings.anisotropic_iterations,
                     settings.anisotropic_conductance));
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
          text("(%.2f, %.2f, %.2f)", labels.origin_mm.x(), labels.origin_mm.y(), labels.origin_mm.z()),
      "it must match the image: " + shape_text(image) + " from " +
          text("(%.2f, %.2f, %.2f), same axes", image.origin_mm.x(), image.origin_mm.y(), image.origin_mm.z()));
}

/// 1 where the label map has the label, 0 elsewhere, on the lattice of the image.
ct::AlignedImage read_label(const CtSettings& settings, const ct::ScanGeometry& image, Report& report) {
  const std::string& path = settings.label_map->path;
  const auto source = ct::open_scan(path, kLabelKey, report);
  check_same_place(image, source->geometry(), path);
  // Labels are turned into shares before anything interpolates: between labels 1 and 3 lies no label 2.
  class ShareOfLabel : public ct::ScanSource {
   public:
    ShareOfLabel(const ct::ScanSource& source, const ct::ScanGeometry& image, int label)
        : source_(source), image_(image), label_(static_cast<float>(label)) {}
    [[nodiscard]] const ct::ScanGeometry& geometry() const override { return image_; }
    [[nodiscard]] std::string description() const override { return source_.description(); }
    [[nodiscard]] bool is_unsigned() const override { return false; }
    [[nodiscard]] ct::Scan read(const ct::IndexBox& box) const override {
      ct::Scan scan = source_.read(box);
      scan.geometry.step_mm = image_.step_mm;
      scan.geometry.origin_mm = image_.point_mm(box.start.cast<double>());
      for (float& value : scan.value) value = value == label_ ? 1 : 0;
      return scan;
    }

   private:
    const ct::ScanSource& source_;
    const ct::ScanGeometry& image_;
    float label_;
  };
  const ShareOfLabel share(*source, image, settings.label_map->label);
  report.note("label map " + path + ": " + source->description());
  return read_cropped(share, settings, path, kLabelKey, true, report);
}

struct GradeStatistics {
  std::int64_t voxels = 0;
  double least_hu = std::numeric_limits<double>::infinity();
  double most_hu = -std::numeric_limits<double>::infinity();
  double sum_hu = 0;
};

Voxmap build_voxmap(const ct::AlignedImage& hu, const ct::BoneField& bone, const BoneSettings& settings,
                    Report& report) {
  // Between image voxels the field can be above 0 as far as the next voxel, two where a cut passes.
  const VoxelGrid grid = ct::grid_round(hu.lattice, bone.min - Vec3i::Constant(2), bone.max + Vec3i::Constant(2),
                                        settings.voxel_mm, kMarginVoxels);
  ct::check_fits_in_memory(grid.dims.cast<double>().prod(), sizeof(std::uint8_t), settings.ct.path, "bone.voxel_mm");
  Voxmap voxmap(grid);
  voxmap.mapping = {settings.density.ash_slope_g_cm3_per_hu, settings.density.ash_offset_g_cm3,
                    settings.density.ash_fraction};
  voxmap.frame = "LPS";
  ct::SliceResampler resampled(hu, grid);
  const ct::InsideTest in_bone(bone.field, grid);
  // What a cut takes is taken exactly; a label map knows no cuts.
  const CtSettings& cuts = settings.ct;
  GradeStatistics stats;
  const Aabb image = hu.lattice.bounds_mm();
  for (int k = 0; k < grid.dims.z(); ++k) {
    const std::vector<double>& slice = resampled.slice(k);
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        if (!in_bone(i, j, k)) continue;
        const Vec3 center = grid.center_mm(i, j, k);
        if ((center.array() < image.min.array()).any() || (center.array() > image.max.array()).any()) continue;
        if (!cuts.label_map && ct::is_cut_away(cuts, center)) continue;
        const double value = slice[static_cast<std::size_t>(i + std::int64_t{grid.dims.x()} * j)];
        voxmap.grade[static_cast<std::size_t>(grid.index(i, j, k))] =
            DensityMapping::grade_from_density(voxmap.mapping.density_from_hu(value));
        ++stats.voxels;
        stats.sum_hu += value;
        stats.least_hu = std::min(stats.least_hu, value);
        stats.most_hu = std::max(stats.most_hu, value);
      }
    }
  }
  if (stats.voxels == 0) {
    throw InputError({settings.ct.path}, "bone.voxel_mm",
                     text("voxels of %g mm leave nothing of the bone", settings.voxel_mm), "use smaller voxels");
  }
  report.note(text("voxmap: %dx%dx%d voxels of %g mm; bone %lld voxels, %.0f mm3; HU %.0f to %.0f, mean %.0f",
                   grid.dims.x(), grid.dims.y(), grid.dims.z(), grid.voxel_mm, static_cast<long long>(stats.voxels),
                   static_cast<double>(stats.voxels) * grid.voxel_mm3(), stats.least_hu, stats.most_hu,
                   stats.sum_hu / static_cast<double>(stats.voxels)));
  return voxmap;
}

void note_trabecular(const ct::BoneField& bone, double threshold_hu, Report& report) {
  report.note(text("inside kept: %lld of %lld bone voxels (%.1f %%) are below %.0f HU",
                   static_cast<long long>(bone.inside_below), static_cast<long long>(bone.voxels),
                   100.0 * static_cast<double>(bone.inside_below) / static_cast<double>(bone.voxels), threshold_hu));
}

}  // namespace

Voxmap voxmap_from_ct(const BoneSettings& settings, Report& report) {
  const CtSettings& ct_settings = settings.ct;
  try {
    const auto source = ct::open_scan(ct_settings.path, kPathKey, report);
    note_image(*source, ct_settings.path, report);
    ct::AlignedImage hu = read_cropped(*source, ct_settings, ct_settings.path, kPathKey, false, report);
    filter(hu, ct_settings, report);
    const ct::BoneField bone =
        ct_settings.label_map
            ? ct::segment_by_label(read_label(ct_settings, source->geometry(), report), hu, ct_settings, report)
            : ct::segment_by_threshold(hu, ct_settings, report);
    note_trabecular(bone, ct_settings.threshold_hu, report);
    return build_voxmap(hu, bone, settings, report);
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

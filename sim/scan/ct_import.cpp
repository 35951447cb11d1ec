// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/ct_import.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "sim/scan/segment.h"

namespace reamsim {

namespace {

/// The default relation from HU to density is that of one tube voltage.
void warn_of_voltage(const ct::ScanSource& source, const BoneSettings& settings, Diagnostics& report) {
  constexpr double kLeast_kv = 110, kMost_kv = 130;
  const double kvp = source.kvp;
  if (kvp <= 0 || (kvp >= kLeast_kv && kvp <= kMost_kv) || settings.density != DensitySettings()) return;
  report.warn(fmt::format(
      "{}: scanned at {:g} kV, where bone has {} HU than at 120 kV; the relation from HU to density is that of 120 kV: "
      "give the constants of this scanner (bone.density)",
      settings.ct.path, kvp, kvp < kLeast_kv ? "more" : "fewer"));
}

/// Replaces NaN and infinity by the least value (padding outside the field of view is often NaN); returns that value.
float replace_non_finite(std::vector<float>& values, const std::string& path, const char* key, Diagnostics& report) {
  float least = std::numeric_limits<float>::infinity();
  for (const float value : values) {
    if (std::isfinite(value)) least = std::min(least, value);
  }
  if (!std::isfinite(least)) throw InputError({path}, key, "the crop contains no finite voxel", "expected HU");
  const auto not_finite = [](float value) { return !std::isfinite(value); };
  const auto count = std::count_if(values.begin(), values.end(), not_finite);
  if (count == 0) return least;
  std::replace_if(values.begin(), values.end(), not_finite, least);
  report.warn(path + fmt::format(": {} voxels are NaN or infinite; replaced by {:.0f}, the minimum", count,
                                 static_cast<double>(least)));
  return least;
}

ct::IndexBox cropped_box(const ct::ScanSource& source, const CtSettings& settings) {
  const ct::IndexBox box = ct::voxels_in_crop(source.geometry, settings);
  if (box.empty()) {
    throw InputError({settings.path}, "bone.ct.crop_min_mm, bone.ct.crop_max_mm",
                     "the crop contains no voxel of the image",
                     "the image spans " + ct::box_text(source.geometry.bounds_mm()) + " (LPS)");
  }
  const double images = ct::is_axis_aligned(source.geometry) ? 2 : 3;  // as read, and CroppedImage
  ct::check_fits_in_memory(static_cast<double>(box.voxels()), images * sizeof(float), {settings.path, ct::kScanKey});
  return box;
}

/// Warns of values that cannot be HU: scans have air, fat or water below 0 HU. Proposes the offset that makes the
/// lowest peak of the histogram air, unless no bone would be left then. Of these, images that are masked with 0 are not
/// warned of; others may be crops without air of a scan with an offset.
void warn_of_offset(const std::vector<float>& values, const std::string& path, Diagnostics& report) {
  constexpr double kBin = 8, kAir_hu = -1000, kBone_hu = 200, kPeakFraction = 0.005, kLeastHu = -100;
  const auto [low, high] = std::ranges::minmax(values);
  const double least = double{low};
  if (least < kLeastHu) return;
  std::map<std::int64_t, std::size_t> histogram;
  for (const float value : values)
    ++histogram[static_cast<std::int64_t>(std::floor(static_cast<double>(value) / kBin))];
  double peak = least;
  for (auto at = histogram.begin(); at != histogram.end(); ++at) {
    const auto next = std::next(at);
    if (static_cast<double>(at->second) < kPeakFraction * static_cast<double>(values.size())) continue;
    if (next != histogram.end() && next->second > at->second) continue;
    peak = kBin * static_cast<double>(at->first);
    break;
  }
  const bool leaves_bone = double{high} + kAir_hu - peak >= kBone_hu;
  if (!leaves_bone && peak == 0) return;
  const std::string advice =
      leaves_bone
          ? fmt::format("If that is air, the values are offset: set bone.ct.hu.intercept to {:.0f}", kAir_hu - peak)
          : "If the values are offset, set bone.ct.hu.intercept";
  report.warn(
      fmt::format("{}: the least value is {:.0f}, and the lowest common one {:.0f}; HU of a scan are below 0 in air "
                  "and fat. {}. As they are, threshold and density may be wrong",
                  path, least, peak, advice));
}

void filter(ct::AlignedImage& image, const CtSettings& settings, Diagnostics& report) {
  if (settings.filter == CtFilter::median) {
    ct::median_filter(image, settings.median_radius_voxels);
    report.note("median filter, radius " + std::to_string(settings.median_radius_voxels) + " voxels");
  } else if (settings.filter == CtFilter::curvature_anisotropic) {
    ct::curvature_anisotropic_filter(image, settings.anisotropic_iterations, settings.anisotropic_conductance);
    report.note(fmt::format("curvature anisotropic diffusion, {} iterations, conductance {:g}",
                            settings.anisotropic_iterations, settings.anisotropic_conductance));
  }
}

/// The filtered voxels in the crop, on LPS axes. Beyond an oblique image they get its least value.
struct CroppedImage {
  ct::AlignedImage hu;
  std::optional<ct::AlignedImage> sharp;  ///< of an oblique image: the same, with the edges that interpolation blurs

  /// For surfaces.
  [[nodiscard]] const ct::AlignedImage& edges() const { return sharp ? *sharp : hu; }
};

CroppedImage read_cropped(const ct::ScanSource& source, const ct::IndexBox& box, const CtSettings& settings,
                          Diagnostics& report, const StageSink& stages = {}, bool for_surfaces = true) {
  ct::Scan scan = source.read(box, 0);
  float least = replace_non_finite(scan.value, settings.path, ct::kScanKey, report);
  if (settings.hu) {
    const auto to_hu = [&](float value) {
      return static_cast<float>(settings.hu->slope * static_cast<double>(value) + settings.hu->intercept);
    };
    std::ranges::transform(scan.value, scan.value.begin(), to_hu);
    least = to_hu(least);
    report.note(fmt::format("bone.ct.hu: HU = {:g} · value + {:g}", settings.hu->slope, settings.hu->intercept));
  }
  warn_of_offset(scan.value, settings.path, report);
  CroppedImage out{.hu = ct::align_to_lps(scan, settings, least), .sharp = {}};
  if (out.hu.lattice.size() < source.geometry.size()) {
    const Vec3i& dims = out.hu.lattice.dims;
    report.note(fmt::format("crop: {}x{}x{} voxels, ", dims.x(), dims.y(), dims.z()) +
                ct::box_text(out.hu.lattice.bounds_mm()));
  }
  if (for_surfaces && !ct::is_axis_aligned(scan.geometry))
    out.sharp = ct::align_to_lps(scan, settings, least, ct::Interpolation::cubic);
  begin_stage(stages, BoneStage::filter);
  filter(out.hu, settings, report);
  Diagnostics said;  // already
  if (out.sharp) filter(*out.sharp, settings, said);
  return out;
}

/// A plane of LPS in the radiological convention.
struct View {
  ScanPlane plane;  ///< without its values
  int across;       // axis of the columns
  int down;         // axis of the rows
  bool upwards;     // the axis points up
};

ScanPlane plane_of(const View& view, const ct::AlignedImage& hu, const ct::BoneField& bone, const CtSettings& settings,
                   const Vec3i& through) {
  const ct::Lattice& lattice = hu.lattice;
  ScanPlane out = view.plane;
  out.columns = lattice.dims[view.across];
  out.rows = lattice.dims[view.down];
  out.spacing_mm = {lattice.spacing_mm[view.across], lattice.spacing_mm[view.down]};
  const auto row_of = [&](int index) { return view.upwards ? out.rows - 1 - index : index; };
  out.through = Vec2(through[view.across], row_of(through[view.down]));
  for (int row = 0; row < out.rows; ++row) {
    for (int column = 0; column < out.columns; ++column) {
      Vec3i voxel = through;
      voxel[view.across] = column;
      voxel[view.down] = row_of(row);
      const std::size_t at = lattice.index(voxel);
      const float field = bone.field.value[at];
      const bool cut = bone.facts.method == "threshold" && ct::is_cut_away(settings, lattice.center_mm(voxel));
      out.hu.push_back(hu.value[at]);
      out.field.push_back(cut ? -std::abs(field) : field);
    }
  }
  return out;
}

/// The axial, coronal and sagittal planes of an image through a point of B. A point outside the image is moved to its
/// nearest voxel. Cuts count as outside the bone.
std::vector<ScanPlane> scan_planes(const ct::AlignedImage& hu, const ct::BoneField& bone, const CtSettings& settings,
                                   const Vec3& through_mm) {
  const auto named = [](const char* name, const char* left, const char* right, const char* top, const char* bottom) {
    return ScanPlane{.name = name, .left = left, .right = right, .top = top, .bottom = bottom, .hu = {}, .field = {}};
  };
  const Vec3i last = hu.lattice.dims - Vec3i::Ones();
  const Vec3 index = (through_mm - hu.lattice.origin_mm).cwiseQuotient(hu.lattice.spacing_mm);
  const Vec3 inside = index.cwiseMax(0).cwiseMin(last.cast<double>());
  const Vec3i through = inside.array().round().cast<int>();
  std::vector<ScanPlane> out;
  for (const View& view :
       {View{named("axial", "R", "L", "A", "P"), 0, 1, false}, View{named("coronal", "R", "L", "S", "I"), 0, 2, true},
        View{named("sagittal", "A", "P", "S", "I"), 1, 2, true}}) {
    out.push_back(plane_of(view, hu, bone, settings, through));
  }
  return out;
}

/// The point of the scenario on the face of the glenoid, or near it.
std::optional<Vec3> glenoid_point(const GlenoidSettings& glenoid) {
  if (glenoid.near_mm) return glenoid.near_mm;
  if (glenoid.center_mm) return glenoid.center_mm;
  if (glenoid.landmarks) return glenoid.landmarks->glenoid_center_mm;
  return std::nullopt;
}

/// The seed, else the centre of the glenoid, else the centre of the bone.
Vec3 point_of_interest(const BoneSettings& settings, const ct::BoneField& bone) {
  if (settings.ct.seed_mm) return *settings.ct.seed_mm;
  if (const auto glenoid = glenoid_point(settings.glenoid)) return *glenoid;
  const ct::Lattice& lattice = bone.field.lattice;
  return 0.5 * (lattice.center_mm(bone.min) + lattice.center_mm(bone.max));
}

/// The settings; where `separate` says so, with the cut through the joint gap, and a seed behind it.
BoneSettings with_cuts(const ct::AlignedImage& hu, const BoneSettings& settings, Diagnostics& report) {
  if (settings.ct.separate != Separate::humerus) return settings;
  const auto near = glenoid_point(settings.glenoid);
  if (!near)
    throw InputError({}, "bone.ct.separate", "no glenoid", "give bone.glenoid.near_mm, on the face of the glenoid");
  const auto head = ct::find_humeral_head(hu, settings.ct.threshold_hu, *near);
  if (!head) {
    throw InputError({}, "bone.ct.separate",
                     fmt::format("no head of a humerus next to the glenoid at {}", point_text(*near)),
                     "check bone.glenoid.near_mm and threshold_hu; or give cut_spheres, or a label map");
  }
  BoneSettings out = settings;
  out.ct.cut_spheres.push_back({head->center_mm, head->cut_radius_mm});
  const Vec3 inward = (*near - head->center_mm).normalized();
  constexpr double kBehindGap_mm = 12;
  if (!out.ct.seed_mm) out.ct.seed_mm = head->center_mm + (head->cut_radius_mm + kBehindGap_mm) * inward;
  report.note(
      fmt::format("humeral head: sphere of radius {:.1f} mm about {}, within {:.2f} mm (rms); cut at {:.1f} mm, "
                  "through the joint gap",
                  head->radius_mm, point_text(head->center_mm), head->rms_mm, head->cut_radius_mm));
  constexpr double kMostTouching = 0.1;
  if (head->touching_fraction > kMostTouching) {
    report.warn(
        fmt::format("humerus and scapula touch in {:.0f} % of the joint: no voxel between them is below {:.0f} HU. "
                    "The cut goes through bone there; a label map is more reliable (bone.ct.label_map)",
                    100 * head->touching_fraction, settings.ct.threshold_hu));
  }
  return out;
}

/// Threshold or label map, as the settings say.
ct::BoneField segment(const ct::ScanSource& source, const ct::IndexBox& box, const ct::AlignedImage& hu,
                      const CtSettings& settings, Diagnostics& report) {
  if (!settings.label_map) return ct::segment_by_threshold(hu, settings, report);
  return ct::segment_by_label(ct::read_labels(settings, source.geometry, box, hu, report), hu, settings, report);
}

/// Opens the scan and calls `use(source)`. Errors of ITK and of the memory become InputErrors.
template <class Use>
auto with_open_scan(const CtSettings& settings, Diagnostics& report, const Use& use) {
  try {
    const ct::ScanSource source = ct::open_scan(settings, report);
    report.note("image " + settings.path + ": " + source.description + ", " + ct::shape_text(source.geometry) + ", " +
                (ct::is_axis_aligned(source.geometry) ? "axes along LPS" : "oblique, resampled to LPS axes") + ", " +
                ct::box_text(source.geometry.bounds_mm()));
    return use(source);
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw InputError({settings.path}, ct::kScanKey, "the image and its voxmap need more memory than this machine has",
                     "crop it, or use larger voxels");
  } catch (const std::exception&) {  // from a filter of ITK
    throw InputError({settings.path}, ct::kScanKey,
                     "the image cannot be processed: its size, spacing or axes are implausible",
                     "check the file, or crop it");
  }
}

/// The width of the point spread along each axis of LPS, mm; 0: the spacing of the lattice. A value of an oblique scan
/// is as wide as its voxel reaches along the axis, and interpolation widens it.
Vec3 psf_of(const ct::ScanGeometry& scan, const CtSettings& settings) {
  constexpr double kInterpolated = 1.25;  // with less, values at the surface of uniform blocks are too low
  if (settings.psf_mm > 0 || ct::is_axis_aligned(scan)) return Vec3::Constant(settings.psf_mm);
  return kInterpolated * scan.step_mm.cwiseAbs().rowwise().sum();
}

/// Corrects the density at the boundary and resamples.
FilledVoxmap voxels_of(ct::AlignedImage hu, const ct::BoneField& bone, const BoneSettings& settings, const Vec3& psf_mm,
                       Diagnostics& report, Segmentation* segmentation, const StageSink& stages) {
  begin_stage(stages, BoneStage::correct_density);
  const ct::BoundaryDensity boundary =
      ct::correct_boundary(hu, bone, psf_mm, ct::resampling_reach(hu.lattice, settings.voxel_mm));
  report.note(fmt::format(
      "partial volume: the density of {} boundary voxels comes from the bone below them; in {:.1f} % of "
      "them the cortex is thinner than the scan resolves, and the density is a lower bound (noise {:.0f} HU)",
      boundary.boundary_voxels, 100 * boundary.unresolved_fraction(), boundary.noise_hu));
  if (segmentation != nullptr) {
    segmentation->lower_bound_fraction = boundary.unresolved_fraction();
    segmentation->noise_hu = boundary.noise_hu;
  }
  begin_stage(stages, BoneStage::voxels);
  return ct::voxelize(hu, bone, settings, report);
}

}  // namespace

FilledVoxmap voxmap_from_scan(const ct::ScanSource& source, const BoneSettings& given, Diagnostics& report,
                              Segmentation* segmentation, const StageSink& stages) {
  warn_of_voltage(source, given, report);
  const ct::IndexBox box = cropped_box(source, given.ct);
  CroppedImage image = read_cropped(source, box, given.ct, report, stages);
  ct::AlignedImage& hu = image.hu;
  begin_stage(stages, BoneStage::segment);
  const BoneSettings settings = with_cuts(hu, given, report);
  const CtSettings& ct_settings = settings.ct;
  const ct::BoneField bone = segment(source, box, image.edges(), ct_settings, report);
  report.note(fmt::format(
      "interior kept: {} of {} bone voxels ({:.1f} %) are below {:.0f} HU", bone.inside_below, bone.voxels,
      100.0 * static_cast<double>(bone.inside_below) / static_cast<double>(bone.voxels), ct_settings.threshold_hu));
  if (segmentation != nullptr) {
    *segmentation = bone.facts;
    segmentation->planes_through_mm = point_of_interest(settings, bone);
    segmentation->planes = scan_planes(hu, bone, ct_settings, segmentation->planes_through_mm);
  }
  return voxels_of(std::move(hu), bone, settings, psf_of(source.geometry, ct_settings), report, segmentation, stages);
}

FilledVoxmap voxmap_from_ct(const BoneSettings& settings, Diagnostics& report, Segmentation* segmentation,
                            const StageSink& stages) {
  begin_stage(stages, BoneStage::read);
  return with_open_scan(settings.ct, report, [&](const ct::ScanSource& source) {
    return voxmap_from_scan(source, settings, report, segmentation, stages);
  });
}

SegmentedScan segmented_scan(const BoneSettings& given, Diagnostics& report, std::optional<FilledVoxmap>* voxmap) {
  return with_open_scan(given.ct, report, [&](const ct::ScanSource& source) {
    const ct::IndexBox box = cropped_box(source, given.ct);
    CroppedImage image = read_cropped(source, box, given.ct, report);
    SegmentedScan out{.hu = {}, .field = {}, .settings = given.ct, .mistakes = {}};
    try {
      const BoneSettings settings = with_cuts(image.hu, given, report);
      out.settings = settings.ct;
      ct::BoneField bone = segment(source, box, image.edges(), out.settings, report);
      if (voxmap != nullptr) {
        *voxmap = voxels_of(image.hu, bone, settings, psf_of(source.geometry, settings.ct), report, nullptr, {});
      }
      out.field = std::move(bone.field.value);
    } catch (const InputError& error) {
      out.mistakes = error.mistakes();
    }
    out.hu = std::move(image.hu);
    if (out.field.empty() || out.settings.label_map) return out;
    out.hu.lattice.for_each([&](const Vec3i& voxel, std::size_t at) {
      if (ct::is_cut_away(out.settings, out.hu.lattice.center_mm(voxel))) out.field[at] = -std::abs(out.field[at]);
    });
    return out;
  });
}

std::vector<ct::Joint> joints_in_scan(const BoneSettings& settings, Diagnostics& report) {
  return with_open_scan(settings.ct, report, [&](const ct::ScanSource& source) {
    const CroppedImage image = read_cropped(source, cropped_box(source, settings.ct), settings.ct, report, {}, false);
    return ct::find_joints(image.hu, settings.ct.threshold_hu);
  });
}

std::string sentence_of(const Segmentation& s) {
  const std::string bone =
      s.method == "label_map"
          ? fmt::format("label map, {:.0f} mm3 of bone, {:.1f} % below {:.0f} HU", s.bone_mm3,
                        100 * s.below_threshold_fraction, s.threshold_hu)
          : fmt::format(
                "threshold {:.0f} HU, {} pieces, kept {} (rank {} by size); {:.0f} mm3 of bone, {:.1f} % below the "
                "threshold; discarded {:.0f} mm3, cut {:.0f} mm3, added by closing {:.0f} mm3, by filling {:.0f} mm3",
                s.threshold_hu, s.pieces, s.by_seed ? "the one with the seed" : "the largest", s.kept_rank, s.bone_mm3,
                100 * s.below_threshold_fraction, s.dropped_mm3, s.cut_mm3, s.closed_mm3, s.filled_mm3);
  return fmt::format("segmentation: {}; on {:.1f} % of its surface the density is a lower bound", bone,
                     100 * s.lower_bound_fraction);
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/verify/ct_slab.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/scan/ct_import.h"

namespace reamsim::verify {

namespace {

/// Soft tissue above the face, and bone beside and below the reamed region, mm: more than the reach of the tool and the
/// PSF of the scan.
constexpr double kAbove_mm = 4, kBeside_mm = 4;

/// The scan of the slab, computed on reading.
class SlabScan final : public ct::ScanSource {
 public:
  explicit SlabScan(const CtSlab& slab) : slab_(slab) {
    const double half = slab.radius_mm + slab.depth_mm + kBeside_mm;
    geometry_.dims = Vec3i::Constant(2 * static_cast<int>(std::ceil(half / slab.spacing_mm)));
    geometry_.step_mm = slab.spacing_mm * Mat3::Identity();
    geometry_.origin_mm = -0.5 * slab.spacing_mm * (geometry_.dims - Vec3i::Ones()).cast<double>();
  }

  [[nodiscard]] const ct::ScanGeometry& geometry() const override { return geometry_; }
  [[nodiscard]] std::string description() const override { return "slab"; }
  [[nodiscard]] bool is_unsigned() const override { return false; }
  [[nodiscard]] ct::Scan read(const ct::IndexBox& box) const override {
    ct::Scan out{ct::part_of(geometry_, box), {}};
    out.value.reserve(static_cast<std::size_t>(box.voxels()));
    for (int k = 0; k < box.size.z(); ++k) {
      for (int j = 0; j < box.size.y(); ++j) {
        for (int i = 0; i < box.size.x(); ++i) {
          out.value.push_back(static_cast<float>(mean_hu(out.geometry.point_mm(Vec3(i, j, k)))));
        }
      }
    }
    return out;
  }

 private:
  [[nodiscard]] double depth_of(const Vec3& point) const { return slab_.outward().dot(slab_.face_mm() - point); }
  [[nodiscard]] double hu_at(double depth) const { return depth < 0 ? kSoftTissue_hu : slab_.hu(depth); }

  /// Mean over the voxel, from many points where the profile is not linear across it.
  [[nodiscard]] double mean_hu(const Vec3& center) const {
    constexpr int kAcross = 6, kAlong = 24;
    const double depth = depth_of(center);
    const double reach = 0.5 * slab_.spacing_mm * slab_.outward().cwiseAbs().sum() + 1e-9;
    const auto crossed = [&](double mm) { return std::abs(depth - mm) < reach; };
    if (!crossed(0) && std::ranges::none_of(slab_.breaks_mm, crossed)) return hu_at(depth);
    double sum = 0;
    for (int n = 0; n < kAcross * kAcross * kAlong; ++n) {
      const Vec3i cell(n % kAcross, n / kAcross % kAcross, n / kAcross / kAcross);
      const Vec3 at = cell.cast<double>() + Vec3::Constant(0.5);
      const Vec3 part = at.cwiseQuotient(Vec3(kAcross, kAcross, kAlong)) - Vec3::Constant(0.5);
      sum += hu_at(depth_of(center + slab_.spacing_mm * part));
    }
    return sum / (kAcross * kAcross * kAlong);
  }

  CtSlab slab_;
  ct::ScanGeometry geometry_;
};

}  // namespace

Vec3 CtSlab::outward() const {
  const double tilt = tilt_deg * std::numbers::pi / 180;
  return {0.8 * std::sin(tilt), 0.6 * std::sin(tilt), std::cos(tilt)};
}

Vec3 CtSlab::face_mm() const {
  const double above = 0.5 * depth_mm - kAbove_mm / 2;
  return above * outward() + Vec3(0, 0, offset_voxels * spacing_mm);
}

double CtSlab::specific_energy_to(double depth) const {
  constexpr int kParts = 4000;
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    sum += specific_energy(DensityMapping().density_from_hu(hu((i + 0.5) / kParts * depth)));
  }
  return sum / kParts;
}

FilledVoxmap scan_and_import(const CtSlab& slab, double voxel_mm) {
  BoneSettings settings;
  settings.source = BoneSource::ct;
  settings.voxel_mm = voxel_mm;
  settings.surface_voxels = SurfaceVoxels::partial;
  settings.ct.path = "slab";
  settings.ct.threshold_hu = kSlabThreshold_hu;
  settings.ct.closing_mm = 0;
  Diagnostics report;
  return voxmap_from_scan(SlabScan(slab), settings, report);
}

}  // namespace reamsim::verify

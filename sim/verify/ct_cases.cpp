// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Bone from a CT: the partial volume at its surface must not affect energy or force at any voxel size.

#include <fmt/core.h>
#include <algorithm>
#include <numbers>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/ct_import.h"
#include "sim/verify/suite.h"

namespace reamsim::verify {

namespace {

constexpr double kSoftTissue_hu = 40, kSlabThreshold_hu = 226;

/// Soft tissue above the face, and bone beside and below the reamed region, mm: more than the reach of the tool and the
/// PSF of the scan.
constexpr double kAbove_mm = 4, kBeside_mm = 4;

/// A slab of bone in a CT with voxel averaging: radiodensity over the depth below a tilted face, soft tissue outside.
struct CtSlab {
  std::function<double(double depth_mm)> hu;  ///< linear between the breaks
  std::vector<double> breaks_mm = {};         ///< depths where `hu` has a step or a corner, besides the face
  double spacing_mm = 1;                      ///< of the scan
  double offset_voxels = 0;                   ///< of the face against the scan's voxels
  double tilt_deg = 0;
  double depth_mm = 6;  ///< greatest reamed depth
  double radius_mm = 5;

  [[nodiscard]] Vec3 outward() const {
    const double tilt = tilt_deg * std::numbers::pi / 180;
    return {0.8 * std::sin(tilt), 0.6 * std::sin(tilt), std::cos(tilt)};
  }
  /// The point of the face in the middle of the reamed region.
  [[nodiscard]] Vec3 face_mm() const {
    const double above = 0.5 * depth_mm - kAbove_mm / 2;
    return above * outward() + Vec3(0, 0, offset_voxels * spacing_mm);
  }
  /// Energy per volume of the bone down to a depth, by quadrature, mJ/mm³.
  [[nodiscard]] double specific_energy_to(double depth) const {
    constexpr int kParts = 4000;
    double sum = 0;
    for (int i = 0; i < kParts; ++i) {
      sum += specific_energy(DensityMapping().density_from_hu(hu((i + 0.5) / kParts * depth)));
    }
    return sum / kParts;
  }
};

/// The mean over the voxel about a point, from many points where the profile is not linear across it.
double mean_hu(const CtSlab& slab, const Vec3& center) {
  constexpr int kAcross = 6, kAlong = 24;
  const auto depth_of = [&](const Vec3& point) { return slab.outward().dot(slab.face_mm() - point); };
  const auto hu_at = [&](double depth) { return depth < 0 ? kSoftTissue_hu : slab.hu(depth); };
  const double depth = depth_of(center);
  const double reach = 0.5 * slab.spacing_mm * slab.outward().cwiseAbs().sum() + 1e-9;
  const auto crossed = [&](double mm) { return std::abs(depth - mm) < reach; };
  if (!crossed(0) && std::ranges::none_of(slab.breaks_mm, crossed)) return hu_at(depth);
  double sum = 0;
  for (int n = 0; n < kAcross * kAcross * kAlong; ++n) {
    const Vec3i cell(n % kAcross, n / kAcross % kAcross, n / kAcross / kAcross);
    const Vec3 at = cell.cast<double>() + Vec3::Constant(0.5);
    const Vec3 part = at.cwiseQuotient(Vec3(kAcross, kAcross, kAlong)) - Vec3::Constant(0.5);
    sum += hu_at(depth_of(center + slab.spacing_mm * part));
  }
  return sum / (kAcross * kAcross * kAlong);
}

/// The scan of the slab, computed on reading.
ct::ScanSource scan_of(const CtSlab& slab) {
  const double half = slab.radius_mm + slab.depth_mm + kBeside_mm;
  ct::ScanGeometry geometry;
  geometry.dims = Vec3i::Constant(2 * static_cast<int>(std::ceil(half / slab.spacing_mm)));
  geometry.step_mm = slab.spacing_mm * Mat3::Identity();
  geometry.origin_mm = -0.5 * slab.spacing_mm * (geometry.dims - Vec3i::Ones()).cast<double>();
  const auto read = [slab, geometry](const ct::IndexBox& box, int) {
    ct::Scan out{ct::part_of(geometry, box), {}};
    out.value.reserve(static_cast<std::size_t>(box.voxels()));
    for_each_voxel(box.size, [&](const Vec3i& index) {
      out.value.push_back(static_cast<float>(mean_hu(slab, out.geometry.point_mm(index.cast<double>()))));
    });
    return out;
  };
  return {.geometry = geometry, .description = "slab", .segments = {}, .read = read};
}

/// Scans the slab and imports it at `voxel_mm`, as `bone.source: ct` does.
FilledVoxmap scan_and_import(const CtSlab& slab, double voxel_mm) {
  const BoneSettings settings{.source = BoneSource::ct,
                              .voxel_mm = voxel_mm,
                              .surface_voxels = SurfaceVoxels::partial,
                              .ct = {.path = "slab", .threshold_hu = kSlabThreshold_hu, .closing_mm = 0}};
  Diagnostics report;
  return voxmap_from_scan(scan_of(slab), settings, report);
}

constexpr double kSlabRate_hz = 500, kRpm = 250, kFeed_mm_s = 20, kStart_mm = 2;

Quat along(const Vec3& direction) {
  return smallest_rotation(Vec3::UnitZ(), direction);
}

/// What a flat-ended cylinder removes down the face's normal as far as each of the depths, which rise.
std::vector<Removed> plunge(const CtSlab& slab, double voxel_mm, const std::vector<double>& depths_mm,
                            const Setting& setting) {
  const Vec3 n = slab.outward();
  std::vector<Leg> legs;
  double from = -kStart_mm;
  for (const double depth : depths_mm) {
    const int frames = static_cast<int>(std::lround((depth - from) / kFeed_mm_s * kSlabRate_hz));
    legs.push_back({slab.face_mm() - depth * n, frames, kRpm, along(n)});
    from = depth;
  }
  const Tool tool = make_tool(flat_profile(slab.radius_mm, 0, slab.depth_mm + 4));
  const Reamed reamed =
      ream(scene_of(scan_and_import(slab, voxel_mm), tool, path(kSlabRate_hz, slab.face_mm() + kStart_mm * n, legs)),
           setting);
  std::vector<Removed> out;
  Removed sum;
  std::size_t row = 0;
  for (const Leg& leg : legs) {
    for (int k = 0; k < leg.frames; ++k) {
      ++row;
      sum.energy_mj += reamed.rows[row].energy_mj;
      sum.volume_mm3 += reamed.rows[row].removed_mm3;
    }
    out.push_back(sum);
  }
  return out;
}

/// The largest error found, with where it was.
struct Worst {
  double error = 0;
  std::string where;
  int runs = 0;

  void add(double found, double expected, const std::string& place) {
    ++runs;
    const double relative = found / expected - 1;
    if (std::abs(relative) <= std::abs(error)) return;
    error = relative;
    where = place;
  }
};

std::string place(const CtSlab& slab, double voxel_mm) {
  return fmt::format("scan {:g} mm, offset {:g}, tilt {:g}°, voxels {:g} mm", slab.spacing_mm, slab.offset_voxels,
                     slab.tilt_deg, voxel_mm);
}

/// Calls visit(slab, voxel) for spacings, offsets, tilts and voxel sizes; the quick suite has a part of them.
template <class Visit>
void for_each_scan(CtSlab slab, const Setting& setting, const Visit& visit) {
  const std::vector<double> spacings = setting.quick ? std::vector{1.0} : std::vector{0.6, 1.0};
  const std::vector<double> offsets = setting.quick ? std::vector{0.31, 0.74} : std::vector{0.0, 0.31, 0.74};
  const std::vector<double> voxels = setting.quick ? std::vector{1.0, 0.5} : std::vector{1.0, 0.5, 0.25};
  for (const double spacing_mm : spacings) {
    for (const double offset : offsets) {
      for (const double tilt_deg : {0.0, 30.0}) {
        slab.spacing_mm = spacing_mm;
        slab.offset_voxels = offset;
        slab.tilt_deg = tilt_deg;
        for (const double voxel_mm : voxels) visit(slab, voxel_mm);
      }
    }
  }
}

void check_worst(const std::string& quantity, const Worst& worst, double tolerance, Report& out,
                 bool has_limit = true) {
  out.add(has_limit ? Measure::absolute : Measure::reported,
          fmt::format("{}, worst of {} ({})", quantity, worst.runs, worst.where), "", 0, worst.error, tolerance,
          has_limit ? "limit set by this project for a CT" : "");
}

}  // namespace

void ct_uniform_case(const Setting& setting, Report& out) {
  out.title = "CT of a uniform slab";
  out.scene =
      "slab of 1000 HU in soft tissue of 40 HU, voxel averages at odd offsets and tilts; a flat reamer of 5 mm radius "
      "plunged along the face's normal";
  out.form = "energy per removed volume = u(ρ(HU))";
  Worst shallow, deep;
  for_each_scan({.hu = [](double) { return 1000.0; }}, setting, [&](const CtSlab& slab, double voxel_mm) {
    const std::vector<Removed> removed = plunge(slab, voxel_mm, {1, 5}, setting);
    shallow.add(removed[0].per_mm3(), slab.specific_energy_to(1), place(slab, voxel_mm));
    deep.add(removed[1].per_mm3(), slab.specific_energy_to(5), place(slab, voxel_mm));
  });
  check_worst("energy per volume, 1 mm deep", shallow, 0.02, out);
  check_worst("energy per volume, 5 mm deep", deep, 0.02, out);
}

void ct_ramp_case(const Setting& setting, Report& out) {
  out.title = "CT of a density ramp";
  out.scene =
      "slab whose radiodensity runs from 400 to 1200 HU over 20 mm, the dense side up or down, reamed 5 mm deep";
  out.form = "energy per removed volume = mean of u(ρ(HU)) over the depth";
  for (const bool dense_up : {false, true}) {
    Worst worst;
    const auto hu = [=](double depth) { return dense_up ? 1200 - 40 * depth : 400 + 40 * depth; };
    for_each_scan({.hu = hu}, setting, [&](const CtSlab& slab, double voxel_mm) {
      worst.add(plunge(slab, voxel_mm, {5}, setting)[0].per_mm3(), slab.specific_energy_to(5), place(slab, voxel_mm));
    });
    check_worst(dense_up ? "energy per volume, dense side up" : "energy per volume, soft side up", worst, 0.02, out);
  }
}

void ct_plate_case(const Setting& setting, Report& out) {
  out.title = "CT of a dense plate";
  out.scene = "plate of 1600 HU on 400 HU, scanned at 0.8 mm; three quarters of its thickness are reamed";
  out.form = "energy per removed volume = u(ρ(1600 HU))";
  const std::vector<double> thicknesses =
      setting.quick ? std::vector{1.0, 2.0} : std::vector{0.4, 0.8, 1.0, 1.2, 1.6, 2.0, 2.4, 3.2};
  const std::vector<double> voxels = setting.quick ? std::vector{0.8, 0.4} : std::vector{0.8, 0.4, 0.2};
  for (const double thickness_mm : thicknesses) {
    Worst worst;
    double mean = 0;
    for (const double offset : {0.0, 0.31, 0.74}) {
      const auto hu = [=](double depth) { return depth < thickness_mm ? 1600.0 : 400.0; };
      const CtSlab slab{.hu = hu, .breaks_mm = {thickness_mm}, .spacing_mm = 0.8, .offset_voxels = offset};
      for (const double voxel_mm : voxels) {
        const double expected = specific_energy(DensityMapping().density_from_hu(1600));
        const double found = plunge(slab, voxel_mm, {0.75 * thickness_mm}, setting)[0].per_mm3();
        worst.add(found, expected, place(slab, voxel_mm));
        mean += found / expected - 1;
      }
    }
    const std::string plate = fmt::format("energy per volume, plate of {:g} mm", thickness_mm);
    check_worst(plate, worst, 0.10, out, thickness_mm == 2);
    out.reported(plate + ", mean", "", mean / worst.runs);
  }
}

void ct_force_case(const Setting& setting, Report& out) {
  out.title = "Torque and axial force in a CT";
  out.scene =
      "slab of 1000 HU scanned at 1 mm, face at 0.31 voxels and tilted by 30°; convex head of 29 mm radius, 8 mm wide, "
      "cannula radius 1.25 mm, 0.5 mm/s and 250 rpm in full contact, voxels halved";
  out.form = "integral of the law over the face";
  const CtSlab slab{.hu = [](double) { return 1000.0; }, .offset_voxels = 0.31, .tilt_deg = 30};
  const double density = DensityMapping::density_from_grade(DensityMapping().grade_from_hu(1000));
  const SteadyPlunge form{
      .radius_mm = 29, .outer_mm = 4, .bore_mm = 1.25, .rpm = kRpm, .feed_mm_s = 0.5, .density_g_cm3 = density};
  const PlungeLoads expected = form.full_loads();
  const Tool tool = make_tool(convex_profile(29, 4, 1.25, 8, 0.1));
  const Vec3 n = slab.outward();
  Refinement torque{"mean spin torque", "N·mm", "voxel, mm", expected.torque_nmm};
  Refinement axial_force{"mean axial force", "N", "voxel, mm", expected.axial_force_n};
  for (const double voxel_mm : four_voxels(0.25)) {
    constexpr int kDown = 100, kSteady = 400;
    const Motion motion =
        path(200, slab.face_mm() + n,
             {{slab.face_mm() - 2 * n, kDown, kRpm, along(n)}, {slab.face_mm() - 3 * n, kSteady, kRpm, along(n)}});
    const Reamed reamed = ream(scene_of(scan_and_import(slab, voxel_mm), tool, motion), setting);
    const MeanLoads loads = mean_loads(reamed.after(kDown));
    add_level(torque, voxel_mm, loads.spin_torque_nmm);
    add_level(axial_force, voxel_mm, loads.axial_force_n);
  }
  for (const Refinement& refinement : {torque, axial_force}) {
    out.refinement(refinement, 0.01, "the grade of the slab is rounded to 0.4 %");
  }
}

}  // namespace reamsim::verify

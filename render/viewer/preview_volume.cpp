// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/viewer/preview_volume.h"

#include <algorithm>
#include <cmath>

#include "render/viewer/page.h"
#include "sim/bone/voxmap/density.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

/// A field of 1 in the page is this many HU away from the threshold.
constexpr float kFieldRange_hu = 200;
/// HU of the bytes 0 and 255: fat to dense cortex, in steps of 8 HU.
constexpr double kLow_hu = -440, kStep_hu = 8;

/// Voxels that are averaged along each axis.
Vec3i reduction(const ct::Lattice& lattice, std::int64_t most_voxels) {
  Vec3i by = Vec3i::Ones();
  const auto reduced = [&] { return Vec3i((lattice.dims.array() + by.array() - 1) / by.array()); };
  while (reduced().cast<std::int64_t>().prod() > most_voxels) {
    int finest = 0;
    lattice.spacing_mm.cwiseProduct(by.cast<double>()).minCoeff(&finest);
    ++by[finest];
  }
  return by;
}

/// The lattice of boxes of `by` voxels. The last box along an axis may extend beyond the image.
ct::Lattice reduced_lattice(const ct::Lattice& lattice, const Vec3i& by) {
  ct::Lattice out = lattice;
  out.dims = (lattice.dims.array() + by.array() - 1) / by.array();
  out.spacing_mm = lattice.spacing_mm.cwiseProduct(by.cast<double>());
  out.origin_mm = lattice.origin_mm + 0.5 * (out.spacing_mm - lattice.spacing_mm);
  return out;
}

/// Means over the boxes of `by` voxels of the voxels that lie in the image.
std::vector<float> means(const std::vector<float>& values, const ct::Lattice& from, const ct::Lattice& to,
                         const Vec3i& by) {
  std::vector<float> out(static_cast<std::size_t>(to.size()), 0);
  std::vector<float> count(out.size(), 0);
  from.for_each([&](const Vec3i& voxel, std::size_t at) {
    const std::size_t box = to.index(voxel.cwiseQuotient(by));
    out[box] += values[at];
    ++count[box];
  });
  for (std::size_t i = 0; i < out.size(); ++i) out[i] /= count[i];
  return out;
}

/// `byte_of(value)` of each, as differences to the one before.
template <class ByteOf>
std::string packed(const std::vector<float>& values, const ByteOf& byte_of) {
  std::vector<std::uint8_t> bytes(values.size());
  std::uint8_t before = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto byte = static_cast<std::uint8_t>(std::clamp(std::lround(byte_of(values[i])), 0L, 255L));
    bytes[i] = static_cast<std::uint8_t>(byte - before);
    before = byte;
  }
  return compressed_base64(bytes);
}

}  // namespace

PreviewVolume preview_of_scan(const SegmentedScan& scan, std::int64_t most_voxels) {
  const ct::Lattice& lattice = scan.hu.lattice;
  const Vec3i by = reduction(lattice, most_voxels);
  PreviewVolume out{.lattice = reduced_lattice(lattice, by), .unit = "HU", .value = {}, .bone = {}};
  out.value = means(scan.hu.value, lattice, out.lattice, by);
  if (scan.field.empty()) return out;
  // The field of a label map has no unit; its values are −½…½.
  const float most = std::abs(*std::ranges::max_element(scan.field, {}, [](float f) { return std::abs(f); }));
  const float range = most <= 1 ? most : kFieldRange_hu;
  std::vector<float> field(scan.field.size());
  std::ranges::transform(scan.field, field.begin(), [&](float f) { return std::clamp(f / range, -1.0F, 1.0F); });
  out.bone = means(field, lattice, out.lattice, by);
  return out;
}

PreviewVolume preview_of_voxmap(const BoneView& bone, std::int64_t most_voxels) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const ct::Lattice fine{grid.dims, Vec3::Constant(grid.voxel_mm), grid.center_mm(Vec3i::Zero())};
  Vec3i by = Vec3i::Ones();
  while (reduced_lattice(fine, by).dims.cast<std::int64_t>().prod() > most_voxels) by += Vec3i::Ones();
  PreviewVolume out{.lattice = reduced_lattice(fine, by), .unit = "g/cm³", .value = {}, .bone = {}};
  out.value.assign(static_cast<std::size_t>(out.lattice.size()), 0);
  out.bone.assign(out.value.size(), -1);
  const auto voxels = static_cast<float>(by.prod());
  for_each_bone_voxel(bone, [&](const Vec3i& voxel, std::uint8_t grade, std::uint16_t fill) {
    const std::size_t box = out.lattice.index(voxel.cwiseQuotient(by));
    const float part = static_cast<float>(fill) / static_cast<float>(FillBricks::kWhole) / voxels;
    out.value[box] += part * static_cast<float>(DensityMapping::density_from_grade(grade));
    out.bone[box] += 2 * part;
  });
  return out;
}

Json volume_json(const PreviewVolume& volume) {
  const bool hu = volume.unit == "HU";
  const double low = hu ? kLow_hu : 0, step = hu ? kStep_hu : DensityMapping::kGradeStep_g_cm3;
  const Vec3i& dims = volume.lattice.dims;
  Json json{{"dims", {dims.x(), dims.y(), dims.z()}},
            {"origin_mm", vector_json(volume.lattice.origin_mm)},
            {"spacing_mm", vector_json(volume.lattice.spacing_mm)},
            {"unit", volume.unit},
            {"low", low},
            {"step", step},
            {"values", packed(volume.value, [&](float v) { return (static_cast<double>(v) - low) / step; })},
            {"bone", Json()}};
  if (!volume.bone.empty()) json["bone"] = packed(volume.bone, [](float f) { return 128 + 127 * f; });
  return json;
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/report/page_data.h"

#include "render/pictures/run_view.h"
#include "render/report/markup.h"
#include "render/report/mesh_data.h"
#include "render/surface/color_map.h"
#include "render/surface/unreamed_surface.h"
#include "sim/base/error.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kMaxDensityCells = 2'500'000;

BoneSurface surface_of(const Voxmap& voxmap, const FillBricks& fill, const UnreamedSurface& unreamed) {
  return simplified(make_bone_surface(BoneFields(voxmap, fill, unreamed)), MeshBudget());
}

Json volume_json(const DensityVolume& volume) {
  return {{"dims", {volume.dims.x(), volume.dims.y(), volume.dims.z()}},
          {"origin_mm", vector_json(volume.origin_mm)},
          {"cell_mm", volume.cell_mm},
          {"bytes", compressed_base64(volume.grades)}};
}

Json colors_json(const ColorMap& map, const Scale& scale) {
  Json json{{"stops", Json::array()}, {"max", scale.max}, {"step", scale.step}, {"ticks", Json::array()}};
  for (const Eigen::Vector3f& stop : map.stops) json["stops"].push_back(vector_json(stop));
  for (int tick = 0; tick < scale.ticks(); ++tick) json["ticks"].push_back(scale.label(tick));
  return json;
}

/// Directions are unit vectors; unknown ones are null.
Json view_json(const ViewTarget& target) {
  const Camera oblique = make_camera(CameraView::oblique, target, 1000, 1000);
  const Camera section = make_camera(CameraView::section, target, 1000, 1000);
  const Mat3 bone_from_eye = oblique.eye_from_bone.linear().transpose();
  return {{"focus_mm", vector_json(target.focus_mm)},
          {"reach_mm", short_number(target.radius_mm)},
          {"height_mm", short_number(1000 * oblique.mm_per_px)},
          {"towards_viewer", vector_json(bone_from_eye.col(2))},
          {"outward", vector_json(target.outward)},
          {"superior", vector_json(target.superior)},
          {"anterior", target.anterior ? vector_json(*target.anterior) : Json()},
          {"anatomical", target.anatomical},
          {"axis", vector_json(target.bone_from_tool.linear().col(2))},
          {"axis_point_mm", vector_json(target.bone_from_tool.translation())},
          {"front", vector_json(-section.cut_plane->head<3>())}};
}

constexpr int kPadding_cells = 2;  // extrapolated into the air

/// Edge of a cell in voxels, and the lattice of cells.
int voxels_per_cell(const Vec3i& voxels, std::int64_t most_cells, BrickLattice& cells) {
  for (int n = 1;; ++n) {
    cells = {(voxels.array() + n - 1) / n + 2 * kPadding_cells};
    if (static_cast<std::int64_t>(cells.count()) <= most_cells || cells.dims.maxCoeff() <= 1 + 2 * kPadding_cells) {
      return n;
    }
  }
}

/// Sets air cells next to bone to the mean of their bone neighbours.
void extrapolate(const BrickLattice& cells, std::vector<std::uint8_t>& grades) {
  const std::vector<std::uint8_t> before = grades;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i] != 0) continue;
    int sum = 0, count = 0;
    for (int side = 0; side < 6; ++side) {
      const Vec3i near = cells.coord(i) + (side % 2 == 0 ? 1 : -1) * Vec3i::Unit(side / 2);
      if (!cells.contains(near)) continue;
      const int grade = before[cells.index(near)];
      sum += grade;
      count += grade != 0 ? 1 : 0;
    }
    if (count > 0) grades[i] = static_cast<std::uint8_t>((sum + count / 2) / count);
  }
}

}  // namespace

DensityVolume density_volume(const Voxmap& voxmap, std::int64_t most_cells) {
  const VoxelBox bone = bone_extent(voxmap);
  if (bone.empty()) throw InputError({"reamed.vdb", 0, 0}, "density", "contains no bone", "the bone of a run");
  DensityVolume out;
  BrickLattice cells;
  const int n = voxels_per_cell(bone.size(), most_cells, cells);
  out.dims = cells.dims;
  out.cell_mm = n * voxmap.grid.voxel_mm;
  const Vec3i first = bone.first - Vec3i::Constant(n * kPadding_cells);
  out.origin_mm = voxmap.grid.origin_mm + voxmap.grid.voxel_mm * first.cast<double>();
  std::vector<std::uint32_t> sums(cells.count());
  std::vector<std::uint32_t> counts(sums.size());
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      const std::uint8_t grade = grades[static_cast<std::size_t>(offset)];
      if (grade == 0) continue;
      const std::size_t cell = cells.index((BrickLattice::voxel_at(coord, offset) - first) / n);
      sums[cell] += grade;
      ++counts[cell];
    }
  });
  out.grades.resize(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (counts[i] > 0) out.grades[i] = static_cast<std::uint8_t>((sums[i] + counts[i] / 2) / counts[i]);
  }
  for (int round = 0; round < kPadding_cells; ++round) extrapolate(cells, out.grades);
  return out;
}

Json bone_data(const RunData& run, const RenderSettings& settings) {
  const Voxmap& voxmap = run.voxmap();
  const UnreamedSurface& unreamed = run.unreamed();
  const BoneSurface after = surface_of(voxmap, run.last_fill(), unreamed);
  const BoneSurface before = surface_of(voxmap, unreamed.before(), unreamed);
  const Scale depth = depth_scale(run, settings.depth_max_mm);
  const Eigen::AlignedBox3f box = bounds_of(before).merged(bounds_of(after));
  Json json;
  json["look"] = view_json(run.target());
  json["box_mm"] = box_json(box.min(), box.max());
  json["grade_per_g_cm3"] = DensityMapping::kMaxGrade / DensityMapping::kMaxDensity_g_cm3;
  json["deepest_mm"] = short_number(after.deepest_mm);
  json["depth_colors"] = colors_json(depth_colors(), depth);
  json["density_colors"] = colors_json(density_colors(), scale_up_to(DensityMapping::kMaxDensity_g_cm3));
  json["before"] = mesh_json(before, box, depth.max);
  json["after"] = mesh_json(after, box, depth.max);
  json["reaming"] = reaming_data(run, after);
  json["density"] = volume_json(density_volume(voxmap, kMaxDensityCells));
  return json;
}

}  // namespace reamsim

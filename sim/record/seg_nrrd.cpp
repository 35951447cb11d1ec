// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "sim/base/file.h"
#include "sim/record/summary.h"

namespace reamsim {

namespace {

/// The header of an NRRD, which 3D Slicer opens as a segmentation by its fields "Segment...".
std::string nrrd_header(const VoxelGrid& grid) {
  const Vec3 first = grid.center_mm({0, 0, 0});
  const Vec3i& n = grid.dims;
  std::string out = fmt::format(
      "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: {0} {1} {2}\n"
      "space directions: ({3},0,0) (0,{3},0) (0,0,{3})\nkinds: domain domain domain\nencoding: gzip\n"
      "space origin: ({4},{5},{6})\nSegmentation_MasterRepresentation:=Binary labelmap\n",
      n.x(), n.y(), n.z(), shortest_text(grid.voxel_mm), shortest_text(first.x()), shortest_text(first.y()),
      shortest_text(first.z()));
  for (const int s : {0, 1}) {
    out += fmt::format(
        "Segment{0}_ID:=Segment_{1}\nSegment{0}_Name:={2} bone\nSegment{0}_LabelValue:={1}\nSegment{0}_Layer:=0\n"
        "Segment{0}_Extent:=0 {3} 0 {4} 0 {5}\n",
        s, s + 1, s == 0 ? "remaining" : "removed", n.x() - 1, n.y() - 1, n.z() - 1);
  }
  return out + "\n";
}

/// The labels of the voxels of a layer of bricks, x fastest.
std::vector<std::uint8_t> labels_in_layer(const BoneView& bone, const FillBricks& fill_before, int layer) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const int first = layer * GradeBricks::kSide, planes = std::min(GradeBricks::kSide, grid.dims.z() - first);
  std::vector<std::uint8_t> out(static_cast<std::size_t>(grid.index({0, 0, planes})));
  const Vec3i last = bone.fill.brick_dims() - Vec3i::Ones();
  constexpr int kHalf = FillBricks::kWhole / 2;
  for_each_voxel({0, 0, layer}, {last.x(), last.y(), layer}, [&](const Vec3i& brick) {
    if (bone.voxmap.grade.brick(brick) == nullptr) return;
    for_each_bone_voxel_in(bone, brick, [&](const Vec3i& voxel, int, int fill) {
      const std::uint8_t label = fill > kHalf ? 1 : fill_before.get(voxel) > kHalf ? 2 : 0;
      out[static_cast<std::size_t>(grid.index(voxel - Vec3i(0, 0, first)))] = label;
    });
  });
  return out;
}

}  // namespace

void write_segmentation(const std::string& path, const BoneView& bone, const FillBricks& fill_before) {
  write_file(path, nrrd_header(bone.voxmap.grid));
  std::unique_ptr<gzFile_s, decltype(&gzclose)> out(gzopen(path.c_str(), "ab"), &gzclose);
  bool written = out != nullptr;
  for (int layer = 0; written && layer < bone.fill.brick_dims().z(); ++layer) {
    const std::vector<std::uint8_t> labels = labels_in_layer(bone, fill_before, layer);
    written = gzfwrite(labels.data(), 1, labels.size(), out.get()) == labels.size();
  }
  if (!written || gzclose(out.release()) != Z_OK) fail_to_write(path);
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Voxels of the reamed bone for programs without OpenVDB: a VTK ImageData and a segmentation for 3D Slicer.

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <memory>
#include <new>
#include <vector>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/summary.h"

namespace reamsim {

namespace {

// Debian's VTK would bring Qt and MPI along; the format is an XML header and zlib blocks.
constexpr std::size_t kBlockVoxels = 1 << 18;

std::string vti_header(const VoxelGrid& grid) {
  const Vec3 first = grid.center_mm({0, 0, 0});
  const std::string extent = fmt::format("0 {} 0 {} 0 {}", grid.dims.x() - 1, grid.dims.y() - 1, grid.dims.z() - 1);
  const std::string step = shortest_text(grid.voxel_mm);
  return fmt::format(
      R"(<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64" )"
      R"(compressor="vtkZLibDataCompressor">
<ImageData WholeExtent="{0}" Origin="{1} {2} {3}" Spacing="{4} {4} {4}">
<Piece Extent="{0}">
<PointData Scalars="density_g_cm3">
<DataArray type="Float32" Name="density_g_cm3" format="appended" offset="0"/>
</PointData>
</Piece>
</ImageData>
<AppendedData encoding="raw">
_)",
      extent, shortest_text(first.x()), shortest_text(first.y()), shortest_text(first.z()), step);
}

/// Density × fill of `count` voxels along x that lie in one brick; leaves air as it is.
void put_row(const BoneView& bone, const Vec3i& voxel, std::size_t count, float* out) {
  const Vec3i brick = BrickLattice::brick_of(voxel);
  const GradeBricks::Brick* grades = bone.voxmap.grade.brick(brick);
  if (grades == nullptr) return;
  const FillBricks::Brick* fills = bone.fill.brick(brick);
  const auto first = static_cast<std::size_t>(BrickLattice::offset_of(voxel));
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t grade = (*grades)[first + i];
    if (grade == 0) continue;
    const double fill = (fills == nullptr ? FillBricks::kWhole : (*fills)[first + i]) / double{FillBricks::kWhole};
    out[i] = static_cast<float>(fill * DensityMapping::density_from_grade(grade));
  }
}

std::vector<float> density_block(const BoneView& bone, std::size_t begin, std::size_t end) {
  std::vector<float> out(end - begin, 0.0F);
  const int nx = bone.voxmap.grid.dims.x();
  for (std::size_t e = begin; e < end;) {
    const Vec3i voxel = bone.voxmap.grid.coord(static_cast<std::int64_t>(e));
    // The voxels from here on that lie in the same row of the same brick.
    const int row_end = std::min(nx, (voxel.x() | (GradeBricks::kSide - 1)) + 1);
    const std::size_t count = std::min(static_cast<std::size_t>(row_end - voxel.x()), end - e);
    put_row(bone, voxel, count, out.data() + (e - begin));
    e += count;
  }
  return out;
}

std::vector<unsigned char> deflated(const std::vector<float>& values) {
  const auto bytes = static_cast<uLong>(values.size() * sizeof(float));
  std::vector<unsigned char> out(compressBound(bytes));
  uLongf size = out.size();
  const auto* first = reinterpret_cast<const Bytef*>(values.data());
  // The room suffices, so memory is all that can be missing.
  if (compress2(out.data(), &size, first, bytes, Z_BEST_SPEED) != Z_OK) throw std::bad_alloc();
  out.resize(size);
  return out;
}

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
std::vector<std::uint8_t> labels_in_layer(const BoneView& bone, int layer) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const int first = layer * GradeBricks::kSide, planes = std::min(GradeBricks::kSide, grid.dims.z() - first);
  std::vector<std::uint8_t> out(static_cast<std::size_t>(grid.index({0, 0, planes})));
  const Vec3i last = bone.fill.brick_dims() - Vec3i::Ones();
  constexpr int kHalf = FillBricks::kWhole / 2;
  for_each_voxel({0, 0, layer}, {last.x(), last.y(), layer}, [&](const Vec3i& brick) {
    if (bone.voxmap.grade.brick(brick) == nullptr) return;
    for_each_bone_voxel_in(bone, brick, [&](const Vec3i& voxel, int, int fill) {
      const std::uint8_t label = fill > kHalf ? 1 : bone.fill_before.get(voxel) > kHalf ? 2 : 0;
      out[static_cast<std::size_t>(grid.index(voxel - Vec3i(0, 0, first)))] = label;
    });
  });
  return out;
}

}  // namespace

void write_vti(const std::string& path, const BoneView& bone) {
  const auto voxels = static_cast<std::size_t>(bone.voxmap.grid.size());
  const std::size_t blocks = (voxels + kBlockVoxels - 1) / kBlockVoxels;
  std::vector<std::uint64_t> sizes{blocks, kBlockVoxels * sizeof(float), voxels % kBlockVoxels * sizeof(float)};
  sizes.resize(3 + blocks);
  std::ofstream out(path, std::ios::binary);
  const auto put = [&](const auto& items) {
    out.write(reinterpret_cast<const char*>(items.data()),
              static_cast<std::streamsize>(items.size() * sizeof items[0]));
  };
  const std::vector<float> air(kBlockVoxels, 0.0F);
  const std::vector<unsigned char> deflated_air = deflated(air);  // most blocks of a fine lattice
  out << vti_header(bone.voxmap.grid);
  const auto table = out.tellp();
  put(sizes);
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto values = density_block(bone, b * kBlockVoxels, std::min(voxels, (b + 1) * kBlockVoxels));
    const bool all_air = values.size() == kBlockVoxels && values == air;
    const auto block = all_air ? deflated_air : deflated(values);
    sizes[3 + b] = block.size();
    put(block);
  }
  out << "\n</AppendedData>\n</VTKFile>\n";
  out.seekp(table);
  put(sizes);
  close_file(out, path);
}

void write_segmentation(const std::string& path, const BoneView& bone) {
  write_file(path, nrrd_header(bone.voxmap.grid));
  std::unique_ptr<gzFile_s, decltype(&gzclose)> out(gzopen(path.c_str(), "ab"), &gzclose);
  bool written = out != nullptr;
  for (int layer = 0; written && layer < bone.fill.brick_dims().z(); ++layer) {
    const std::vector<std::uint8_t> labels = labels_in_layer(bone, layer);
    written = gzfwrite(labels.data(), 1, labels.size(), out.get()) == labels.size();
  }
  if (!written || gzclose(out.release()) != Z_OK) fail_to_write(path);
}

}  // namespace reamsim

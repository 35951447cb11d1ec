// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Voxels of the reamed bone for programs without OpenVDB: a VTK ImageData and a segmentation for 3D Slicer.

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <memory>
#include <new>
#include <span>
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

/// The voxels of a layer of bricks, x fastest: value_of(voxel, grade, fill) where there is or was bone, else 0.
template <class T, class ValueOf>
std::vector<T> values_in_layer(const BoneView& bone, int layer, const ValueOf& value_of) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const int first = layer * GradeBricks::kSide, planes = std::min(GradeBricks::kSide, grid.dims.z() - first);
  std::vector<T> out(static_cast<std::size_t>(grid.index({0, 0, planes})));
  const Vec3i last = bone.fill.brick_dims() - Vec3i::Ones();
  for_each_voxel({0, 0, layer}, {last.x(), last.y(), layer}, [&](const Vec3i& brick) {
    if (bone.voxmap.grade.brick(brick) == nullptr) return;
    for_each_bone_voxel_in(bone, brick, [&](const Vec3i& voxel, std::uint8_t grade, std::uint16_t fill) {
      out[static_cast<std::size_t>(grid.index(voxel - Vec3i(0, 0, first)))] = value_of(voxel, grade, fill);
    });
  });
  return out;
}

float density_of(const Vec3i& /*voxel*/, std::uint8_t grade, std::uint16_t fill) {
  return static_cast<float>(fill / double{FillBricks::kWhole} * DensityMapping::density_from_grade(grade));
}

std::vector<unsigned char> deflated(std::span<const float> values) {
  const auto bytes = static_cast<uLong>(values.size() * sizeof(float));
  std::vector<unsigned char> out(compressBound(bytes));
  uLongf size = out.size();
  const auto* first = reinterpret_cast<const Bytef*>(values.data());
  // The room suffices, so memory is all that can be missing.
  if (compress2(out.data(), &size, first, bytes, Z_BEST_SPEED) != Z_OK) throw std::bad_alloc();
  out.resize(size);
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
  std::size_t written = 0;    // blocks
  std::vector<float> values;  // that are not written yet
  for (int layer = 0, layers = bone.fill.brick_dims().z(); layer < layers; ++layer) {
    const auto more = values_in_layer<float>(bone, layer, density_of);
    values.insert(values.end(), more.begin(), more.end());
    std::span<const float> left(values);
    while (left.size() >= kBlockVoxels || (layer + 1 == layers && !left.empty())) {
      const auto block = left.first(std::min(left.size(), kBlockVoxels));
      const auto bytes = std::ranges::equal(block, air) ? deflated_air : deflated(block);
      sizes[3 + written++] = bytes.size();
      put(bytes);
      left = left.subspan(block.size());
    }
    values.erase(values.begin(), values.end() - std::ssize(left));
  }
  out << "\n</AppendedData>\n</VTKFile>\n";
  out.seekp(table);
  put(sizes);
  close_file(out, path);
}

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

}  // namespace

void write_segmentation(const std::string& path, const BoneView& bone, const FillBricks& fill_before) {
  write_file(path, nrrd_header(bone.voxmap.grid));
  std::unique_ptr<gzFile_s, decltype(&gzclose)> out(gzopen(path.c_str(), "ab"), &gzclose);
  bool written = out != nullptr;
  const auto label_of = [&](const Vec3i& voxel, std::uint8_t, std::uint16_t fill) -> std::uint8_t {
    constexpr int kHalf = FillBricks::kWhole / 2;
    return fill > kHalf ? 1 : fill_before.get(voxel) > kHalf ? 2 : 0;
  };
  for (int layer = 0; written && layer < bone.fill.brick_dims().z(); ++layer) {
    const auto labels = values_in_layer<std::uint8_t>(bone, layer, label_of);
    written = gzfwrite(labels.data(), 1, labels.size(), out.get()) == labels.size();
  }
  if (!written || gzclose(out.release()) != Z_OK) fail_to_write(path);
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "kernels/shared.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/device/opencl.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/tables.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// Layout of the voxels of a dense engine; the published ones.
enum class VoxelLayout {
  claimed_grade,  ///< direct: an 8-bit grade (the paper), and a claim bit
  flagged_hu,     ///< octree: a float HU and a collision flag of 8 bits (Zheng et al.)
  bare_grade,     ///< implicit: an 8-bit grade alone; no voxel is tested twice
};

/// The device memory of a dense engine, planned before it is allocated.
struct DensePlan {
  VoxelLayout layout = VoxelLayout::claimed_grade;
  std::size_t voxels = 0;
  std::size_t bone_voxels = 0;  ///< voxels of bone, removed ones included
  std::size_t points = 0;       ///< of the shell; 0 for implicit
  bool wide_codes = false;      ///< 8 bytes per Morton code instead of 4: shells of more than 1024 cells per axis
  bool fill = false;            ///< 16 bits per voxel beside the grade; without it voxels are whole or removed
  std::size_t contacts = 0;     ///< size of the contact list: most voxels that one substep can touch
  std::size_t removed = 0;      ///< size of a batch's list of removed voxels

  [[nodiscard]] DeviceBatch::RemovedList removed_list() const { return {1, removed, contacts, bone_voxels}; }
  [[nodiscard]] std::size_t bone_bytes() const { return voxels * (has_hu() ? sizeof(cl_float) : sizeof(cl_uchar)); }
  [[nodiscard]] std::size_t claim_bytes() const {
    if (layout == VoxelLayout::bare_grade) return 0;
    return sizeof(cl_uint) * (voxels / (has_hu() ? 4 : 32) + 1);  // a flag of 8 bits, or a bit
  }
  [[nodiscard]] std::size_t fill_bytes() const { return fill ? sizeof(cl_ushort) * voxels : 0; }
  [[nodiscard]] std::size_t shell_bytes() const {
    return points * (has_hu() ? 3 * sizeof(cl_float) : wide_codes ? sizeof(cl_ulong) : sizeof(cl_uint));
  }
  /// In total, and in the largest single allocation.
  [[nodiscard]] std::size_t bytes() const {
    return bone_bytes() + claim_bytes() + fill_bytes() + shell_bytes() + sizeof(cl_uint) * contacts +
           DeviceBatch::bytes(removed_list());
  }
  [[nodiscard]] std::size_t largest_bytes() const {
    return std::max({bone_bytes(), claim_bytes(), fill_bytes(), shell_bytes(), sizeof(cl_uint) * contacts,
                     sizeof(RemovedVoxel) * removed});
  }
  [[nodiscard]] bool has_hu() const { return layout == VoxelLayout::flagged_hu; }
};

/// `engine`: direct | octree | implicit.
DensePlan plan_dense(EngineKind engine, const BoneView& bone, const Tool& tool, bool wear);

/// Throws InputError with the voxel size that would fit, unless the plan fits: 2^32 voxels (32-bit indices), the
/// device's memory and its largest allocation.
void require_fit(const DensePlan& plan, const cl::DeviceInfo& device, double voxel_mm);

/// Grades as float HU, the representation of Zheng et al. HU is linear in density, and so in the grade; the conversion
/// is lossless as long as the HU of one grade is well above the rounding of a float.
struct HuScale {
  float of_air;     ///< HU of density 0, which stands for air; bone lies above it
  float per_grade;  ///< HU from one grade to the next

  explicit HuScale(const DensityMapping& mapping)
      : of_air(static_cast<float>(mapping.hu_from_density(0))),
        per_grade(static_cast<float>(mapping.hu_from_density(DensityMapping::kGradeStep_g_cm3) -
                                     mapping.hu_from_density(0))) {}

  [[nodiscard]] float hu(std::uint8_t grade) const { return of_air + static_cast<float>(grade) * per_grade; }
  /// The grade as dense.cl computes it.
  [[nodiscard]] int grade(float hu) const { return static_cast<int>(std::floor((hu - of_air) / per_grade + 0.5F)); }
  /// Whether the conversion of every grade is lossless.
  [[nodiscard]] bool exact() const;
};

/// The data on the device beside the batch: the bone in the plan's layout, the tool, the contact list, and tables.
struct DenseState {
  cl::Buffer<cl_uchar> grades;      ///< 0 = air or removed; unless the layout is flagged_hu
  cl::Buffer<cl_float> hu;          ///< HuScale::of_air = air or removed; where the layout is flagged_hu
  HuScale scale{DensityMapping{}};  ///< of `hu`
  cl::Buffer<cl_ushort> fill;       ///< per voxel, or one dummy entry where every voxel is whole
  bool has_fill = false;
  cl::Buffer<cl_uint> claims;  ///< a bit or a byte per voxel, or one dummy word
  cl::Buffer<cl_uint> contacts;
  DeviceOutline outline;
  cl_uint point_count = 0;        ///< of the shell
  cl::Buffer<cl_uint> codes;      ///< of the shell's points, one or two words each; where the layout is claimed_grade
  cl::Buffer<cl_float> points;    ///< cell numbers of the shell's points; where the layout is flagged_hu
  cl::Buffer<cl_uint4> children;  ///< octree_children()
  cl_int levels = 0;              ///< octree_levels()
  cl::Buffer<rs_i64> units_of_grade;    ///< energy of a whole voxel
  cl::Buffer<rs_i32> density_of_grade;  ///< RS_DENSITY_SCALE
};

/// Uploads bone, tool and tables. Throws InputError when the device runs out of memory, or when the layout is
/// flagged_hu and the conversion of grades to HU is lossy.
DenseState make_dense_state(const cl::Device& device, const DensePlan& plan, const BoneView& bone, const Tool& tool,
                            const EnergyTable& energy);

/// Writes the HU of these grades piecewise, because all of them take four times the memory of the grades.
void upload_hu(const cl::Device& device, const std::vector<std::uint8_t>& grades, const HuScale& scale,
               cl::Buffer<cl_float>& hu);

/// The cells of the shell's points as x, y, z in floats, which represent them exactly up to 2^24.
std::vector<cl_float> cell_numbers(const PointShell& shell);

/// Uploads the bone again. Throws RunError where it is not the bone that `plan` was made for.
void upload_bone(const cl::Device& device, const DensePlan& plan, const BoneView& bone, DenseState& state);

/// Levels of the octree descent: the cube around the lattice has 2^levels voxels along a side.
int octree_levels(const VoxelGrid& grid);

/// The look-up tables of the octree descent. Entry 8·l + o is the corner of octant o of a cell of level l relative to
/// the cell's corner: x, y, z in voxels, and w as a step in the dense array.
std::vector<cl_uint4> octree_children(const VoxelGrid& grid);

}  // namespace reamsim

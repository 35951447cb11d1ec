#pragma once

#include "kernels/shared.h"
#include "sim/bone/voxmap.h"
#include "sim/device/opencl.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// A voxel that went, as the kernel writes it.
struct RemovedVoxel {
  cl_uint voxel;
  cl_uint frame;
};

/// What lives on the device between detect and cut, in the paper's layout: the bone as a dense 8-bit array, the shell
/// at 4 bytes a point (8 beyond 1024³); and beside them a claim bit per voxel, the contact list, and one set of
/// arguments and sums per substep of the batch.
struct DeviceState {
  cl::Buffer<cl_uchar> bone;   ///< grade, 0 = air or gone
  cl::Buffer<cl_ushort> fill;  ///< per voxel, or one dummy where every voxel is whole
  bool has_fill = false;
  cl::Buffer<cl_uint> claims;
  cl::Buffer<cl_uchar> codes;  ///< of `points` points: 32 bits each, or 64 with wide_codes
  std::size_t points = 0;
  bool wide_codes = false;
  cl::Buffer<ProfileEdge> edges;
  cl::Buffer<cl_uint> contacts;
  cl::Buffer<cl_uint> contact_count;  ///< per slot
  cl::Buffer<SubstepArgs> args;       ///< per slot
  cl::Buffer<SubstepSums> sums;       ///< per slot
  cl::Buffer<RemovedVoxel> removed;
  cl::Buffer<cl_uint> removed_count;
};

/// Substeps that a batch holds at most.
inline constexpr int kMaxSlots = 4096;

/// Uploads bone and tool. Throws RunError that says what does not fit (memory is planned before it is taken).
DeviceState make_device_state(const cl::Device& device, const Voxmap& voxmap, const Tool& tool, bool wear);

/// Device memory that make_device_state() would take, bytes.
std::size_t device_bytes(const Voxmap& voxmap, const PointShell& shell, bool wear);

/// The profile's edges off the axis with their outward normals, as the cut reads them.
std::vector<ProfileEdge> profile_edges(const Profile& profile);

}  // namespace reamsim

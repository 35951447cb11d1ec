#pragma once

namespace reamsim {

/// Share of the swept solid voxels (0…1) that a point shell leaves behind when it moves in half-voxel steps, by the
/// ratio of shell spacing to voxel size. It is the severe case: a flat face, along its normal, whose points at all
/// steps form a lattice of s × s × ½ voxels; the share is that of unit cubes without any of them, averaged over how the
/// bone's lattice is turned. A curved face, or one that moves at a slant, leaves less. Up to s = √(3/8) = 0.61 it is 0,
/// because half the diagonal of that lattice's cell is then no more than half a voxel; up to 0.7 none was found in
/// 4·10⁶ cubes, and the value stands for "less than". In between logarithmic; above 3 the value at 3, as a lower bound.
double expected_leak(double spacing_voxels);

/// Up to this spacing expected_leak() is an upper bound, in voxels.
inline constexpr double kHardlyLeakingSpacing = 0.7;
/// Beyond this spacing expected_leak() is a lower bound, in voxels.
inline constexpr double kLargestMeasuredSpacing = 3;

}  // namespace reamsim

#pragma once

#include <vector>

#include "sim/bone/ct/aligned_image.h"
#include "sim/bone/voxel_grid.h"

namespace reamsim::ct {

/// Isotropic voxels round a box of image voxels (`min` and `max` both inside), with `margin_voxels` more on every side
/// and whole bricks of 8. They are counted from the image's lower corner, so that voxels as large as the image's are
/// the image's. Throws std::length_error when a dimension is beyond an int.
VoxelGrid grid_round(const Lattice& image, const Vec3i& min, const Vec3i& max, double voxel_mm, int margin_voxels);

/// Which image values one voxel takes along one axis, and how much of each: weight[n] of value first + n; they sum
/// to 1.
struct AxisWeights {
  int first = 0;
  std::vector<double> weight;
};

/// Along one axis, for every voxel of a grid: averaging over the voxel's length where voxels merge (voxel ≥ spacing),
/// linear interpolation at its centre where they divide (paper §3.2). Beyond the image the outermost value holds.
std::vector<AxisWeights> axis_weights(const Lattice& image, const VoxelGrid& grid, int axis);

/// The image at the voxels of a grid, one slice (constant k) at a time, so that a fine grid of a large bone needs no
/// second large array. Separable: each axis merges or divides by itself, and all three dividing is trilinear.
class SliceResampler {
 public:
  SliceResampler(const AlignedImage& image, const VoxelGrid& grid);

  /// Values of slice k; value (i,j) stands at i + nx·j. Valid until the next call.
  const std::vector<double>& slice(int k);

 private:
  const AlignedImage& image_;
  VoxelGrid grid_;
  std::vector<AxisWeights> weights_[3];
  std::vector<double> plane_;
  std::vector<double> rows_;
  std::vector<double> out_;
};

/// The image at a point, interpolated trilinearly; beyond its outermost values these hold.
double value_at(const AlignedImage& image, const Vec3& point_mm);

/// Says for a voxel of a grid whether at least half of it lies where `field` > 0, the field interpolated trilinearly:
/// by the sign at the centre along axes that divide, by the share of sample points along axes that merge.
class InsideTest {
 public:
  InsideTest(const AlignedImage& field, const VoxelGrid& grid);

  [[nodiscard]] bool operator()(int i, int j, int k) const;

 private:
  struct Sample {
    int low = 0;      ///< lower of the two image voxels along this axis
    float share = 0;  ///< of the upper
  };

  [[nodiscard]] bool inside(const Sample& x, const Sample& y, const Sample& z) const;

  const AlignedImage& field_;
  int samples_[3] = {1, 1, 1};     ///< per voxel
  std::vector<Sample> sample_[3];  ///< of voxel n: samples_ from n·samples_
};

}  // namespace reamsim::ct

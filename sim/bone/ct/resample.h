#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "sim/bone/ct/aligned_image.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/voxel_grid.h"

namespace reamsim::ct {

/// Isotropic voxels round a box of image voxels (`min` and `max` both inside), with `margin_voxels` more on every side
/// and whole bricks of 8. They are counted from the image's lower corner, so that voxels as large as the image's are
/// the image's. Throws std::length_error when a dimension is beyond an int.
VoxelGrid grid_around(const Lattice& image, const Vec3i& min, const Vec3i& max, double voxel_mm, int margin_voxels);

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
  /// The value of one voxel. Reads nothing that slice() changes, so threads may call it.
  [[nodiscard]] double at(const Vec3i& voxel) const;

 private:
  const AlignedImage& image_;
  VoxelGrid grid_;
  std::vector<AxisWeights> weights_[3];
  std::vector<double> plane_;
  std::vector<double> rows_;
  std::vector<double> out_;
};

/// The negative of an image at any point, interpolated trilinearly: a field as fraction_inside() takes it, whose inside
/// is where the image is above 0. Beyond the image's outermost values these hold.
class NegatedField {
 public:
  explicit NegatedField(const AlignedImage& image);

  double operator()(const Vec3& point_mm) const { return value(places(point_mm)); }

  /// The values at a point and `step` before and after it along each axis. A step moves along one axis only, so that
  /// the other two places in the image are found once for all.
  [[nodiscard]] FieldSamples cross(const Vec3& center_mm, double step) const {
    const Places center = places(center_mm);
    FieldSamples out;
    out.center = value(center);
    for (int axis = 0; axis < 3; ++axis) {
      Places moved = center;
      moved[static_cast<std::size_t>(axis)] = place(axis, center_mm[axis] - step);
      out.before[axis] = value(moved);
      moved[static_cast<std::size_t>(axis)] = place(axis, center_mm[axis] + step);
      out.after[axis] = value(moved);
    }
    return out;
  }

 private:
  /// Along one axis: where the lower of two neighbouring values stands, and the share of the upper.
  struct Place {
    std::size_t at = 0;
    double fraction = 0;
  };
  using Places = std::array<Place, 3>;

  [[nodiscard]] Place place(int axis, double mm) const {
    const double index = std::min(std::max((mm - origin_mm_[axis]) / spacing_mm_[axis], 0.0), last_[axis]);
    const int low = std::min(static_cast<int>(index), last_low_[axis]);
    return {stride_[static_cast<std::size_t>(axis)] * static_cast<std::size_t>(low), index - low};
  }
  [[nodiscard]] Places places(const Vec3& mm) const { return {place(0, mm.x()), place(1, mm.y()), place(2, mm.z())}; }
  [[nodiscard]] double value(const Places& p) const {
    const float* corner = values_ + p[0].at + p[1].at + p[2].at;
    const auto along_x = [&](std::size_t at) {
      return (1 - p[0].fraction) * double{corner[at]} + p[0].fraction * double{corner[at + step_[0]]};
    };
    const auto along_y = [&](std::size_t at) {
      return (1 - p[1].fraction) * along_x(at) + p[1].fraction * along_x(at + step_[1]);
    };
    return -((1 - p[2].fraction) * along_y(0) + p[2].fraction * along_y(step_[2]));
  }

  const float* values_;
  Vec3 origin_mm_;
  Vec3 spacing_mm_;
  Vec3 last_;       ///< index of the last value along each axis
  Vec3i last_low_;  ///< of the last value that has another after it
  std::array<std::size_t, 3> stride_{};
  std::array<std::size_t, 3> step_{};  ///< to the upper value; 0 along axes on which the image is one voxel thick
};

/// Says for a voxel of a grid whether at least half of it lies where `field` > 0, the field interpolated trilinearly:
/// by the sign at the centre along axes that divide, by the share of sample points along axes that merge.
class InsideTest {
 public:
  InsideTest(const AlignedImage& field, const VoxelGrid& grid);

  [[nodiscard]] bool operator()(int i, int j, int k) const;

 private:
  struct Sample {
    int low = 0;         ///< lower of the two image voxels along this axis
    float fraction = 0;  ///< of the upper
  };

  [[nodiscard]] bool inside(const Sample& x, const Sample& y, const Sample& z) const;

  const AlignedImage& field_;
  int samples_[3] = {1, 1, 1};     ///< per voxel
  std::vector<Sample> sample_[3];  ///< of voxel n: samples_ from n·samples_
};

}  // namespace reamsim::ct

#include "sim/bone/ct/boundary_normals.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/base/gaussian.h"

namespace reamsim::ct {

namespace {

/// Width of the Gaussian, in the longest side of a voxel.
constexpr double kSigma = 1.2;
constexpr double kReach = 3;  // standard deviations
constexpr double kEven = 1e-4;

/// A Gaussian along one axis; the border's value holds beyond the image.
void smooth_along(AlignedImage& image, int axis, double sigma_voxels) {
  const Lattice& lattice = image.lattice;
  const int reach = static_cast<int>(std::ceil(kReach * sigma_voxels));
  const std::vector<double> weights = gaussian(sigma_voxels, reach);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const Vec3i step = Vec3i::Unit(axis);
  const std::size_t stride = lattice.index(step);
  const int length = lattice.dims[axis];
  std::vector<double> line(static_cast<std::size_t>(length));
  for (std::size_t start = 0; start < image.value.size(); ++start) {
    if (lattice.voxel_at(start)[axis] != 0) continue;
    for (int n = 0; n < length; ++n)
      line[static_cast<std::size_t>(n)] = double{image.value[start + stride * static_cast<std::size_t>(n)]};
    for (int n = 0; n < length; ++n) {
      double value = 0;
      for (int k = -reach; k <= reach; ++k) {
        value += weights[static_cast<std::size_t>(k + reach)] *
                 line[static_cast<std::size_t>(std::clamp(n + k, 0, length - 1))];
      }
      image.value[start + stride * static_cast<std::size_t>(n)] = static_cast<float>(value / sum);
    }
  }
}

}  // namespace

BoundaryNormals::BoundaryNormals(const Mask& bone, const Lattice& lattice)
    : smooth_{lattice, std::vector<float>(bone.begin(), bone.end())} {
  const double sigma_mm = kSigma * lattice.spacing_mm.maxCoeff();
  for (int axis = 0; axis < 3; ++axis) smooth_along(smooth_, axis, sigma_mm / lattice.spacing_mm[axis]);
}

Vec3 BoundaryNormals::inward(const Vec3i& voxel) const {
  const Lattice& lattice = smooth_.lattice;
  Vec3 gradient = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    Vec3i before = voxel, after = voxel;
    before[axis] = std::max(voxel[axis] - 1, 0);
    after[axis] = std::min(voxel[axis] + 1, lattice.dims[axis] - 1);
    if (before[axis] == after[axis]) continue;
    const double difference =
        double{smooth_.value[lattice.index(after)]} - double{smooth_.value[lattice.index(before)]};
    gradient[axis] = difference / ((after[axis] - before[axis]) * lattice.spacing_mm[axis]);
  }
  return gradient.norm() * lattice.spacing_mm.maxCoeff() < kEven ? Vec3(Vec3::Zero()) : gradient.normalized();
}

}  // namespace reamsim::ct

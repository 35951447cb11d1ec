// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "sim/base/parallel.h"
#include "sim/base/statistics.h"
#include "sim/scan/segment.h"

namespace reamsim::ct {

namespace {

constexpr double kSigma = 1.2;  // of the Gaussian, in the longest side of a voxel
constexpr double kReach = 3;    // standard deviations
constexpr double kUniform = 1e-4;

/// A Gaussian along one axis. Beyond the image the value of the border holds.
void smooth_along(AlignedImage& image, int axis, double sigma_voxels) {
  const Lattice& lattice = image.lattice;
  const int reach = static_cast<int>(std::ceil(kReach * sigma_voxels));
  const std::vector<double> weights = gaussian(sigma_voxels, reach);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const std::size_t stride = lattice.index(Vec3i::Unit(axis));
  const int length = lattice.dims[axis];
  const auto smooth_line = [&](std::size_t start) {
    std::vector<double> line(static_cast<std::size_t>(length));
    for (std::size_t n = 0; n < line.size(); ++n) line[n] = double{image.value[start + stride * n]};
    for (int n = 0; n < length; ++n) {
      double value = 0;
      for (int k = -reach; k <= reach; ++k) {
        value += weights[static_cast<std::size_t>(k + reach)] *
                 line[static_cast<std::size_t>(std::clamp(n + k, 0, length - 1))];
      }
      image.value[start + stride * static_cast<std::size_t>(n)] = static_cast<float>(value / sum);
    }
  };
  Vec3i starts = lattice.dims;
  starts[axis] = 1;
  parallel_items(static_cast<std::size_t>(starts.prod()),
                 [&](std::size_t i) { smooth_line(lattice.index(cell_at(starts, i))); });
}

/// The mean of the known voxels among the 26 neighbours, in double precision and a fixed order; nullopt without any.
std::optional<float> mean_of_known(const AlignedImage& image, const Mask& known, const Vec3i& voxel) {
  double sum = 0;
  int count = 0;
  for_each_voxel(voxel - Vec3i::Ones(), voxel + Vec3i::Ones(), [&](const Vec3i& v) {
    if (!image.lattice.contains(v) || known[image.lattice.index(v)] == 0) return;
    sum += double{image.at(v)};
    ++count;
  });
  return count == 0 ? std::nullopt : std::optional(static_cast<float>(sum / count));
}

/// Standard deviation of the noise among the voxels of a mask: from the median of the absolute second differences along
/// each axis (as Immerkær 1996, Comput. Vis. Image Underst. 64:300, with a median, which edges do not affect). 0 where
/// fewer than 30 voxels have two neighbours.
double noise_between(const AlignedImage& image, const Mask& mask) {
  constexpr std::size_t kFewest = 30;
  constexpr double kDeviationOfMedian = 1.4826;  // normal distribution: standard over median absolute deviation
  const Lattice& lattice = image.lattice;
  std::vector<float> differences;
  lattice.for_each([&](const Vec3i& voxel, std::size_t at) {
    if (mask[at] == 0) return;
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t stride = lattice.index(Vec3i::Unit(axis));
      if (voxel[axis] == 0 || voxel[axis] + 1 == lattice.dims[axis]) continue;
      if (mask[at - stride] == 0 || mask[at + stride] == 0) continue;
      differences.push_back(std::abs(image.value[at - stride] - 2 * image.value[at] + image.value[at + stride]));
    }
  });
  if (differences.size() < kFewest) return 0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return kDeviationOfMedian * double{*middle} / std::sqrt(6.0);
}

/// Extends the `known` voxels by `layers` layers. A new voxel gets the mean of its known neighbours (of 26).
void spread_outwards(AlignedImage& image, Mask& known, int layers) {
  const Lattice& lattice = image.lattice;
  for (int layer = 0; layer < layers; ++layer) {
    std::vector<std::pair<std::size_t, float>> found;
    const Mask wider = dilated(known, lattice, Vec3i::Ones());
    for (std::size_t at = 0; at < known.size(); ++at) {
      if (known[at] != 0 || wider[at] == 0) continue;
      if (const auto mean = mean_of_known(image, known, lattice.voxel_at(at))) found.emplace_back(at, *mean);
    }
    for (const auto& [at, value] : found) {
      image.value[at] = value;
      known[at] = 1;
    }
  }
}

constexpr double kStep = 0.25;  // along the normal, voxels
/// Every second step ends on a face of a voxel. Such a point belongs to the inner voxel, whatever the sense of the
/// axes: it is moved inwards by so many voxels, more than rounding and far less than a step.
constexpr double kInwards = 1e-6;
/// Measured values count for the boundary if they lie at most this far below it, voxels.
constexpr double kWindow = 2;
/// A measured value exceeds another only by so many standard deviations of the noise, and by more than rounding.
constexpr double kDeviations = 3;
constexpr double kRounding_hu = 10;
/// The search for trusted voxels ends this far beyond the point spread, voxels.
constexpr double kSearch = 2.5;

/// The length of the search, in the shortest steps of a ray. Near the edges of thick slices the normal leads along the
/// slice, and a ray crosses many voxels before it has left the point spread.
double search_steps(const Lattice& lattice, const Vec3i& spread) {
  const double spread_mm = spread.cast<double>().cwiseProduct(lattice.spacing_mm).maxCoeff();
  const double voxels = std::round(spread_mm / lattice.spacing_mm.minCoeff());  // kSearch covers less than one more
  return std::sqrt(3.0) * voxels + kSearch;
}

/// The line through a voxel along the inward normal, in voxel indices.
struct Ray {
  Vec3 start;
  Vec3 inward;                   ///< one voxel along the fastest axis
  std::array<Vec3, 4> sideways;  ///< steps of about a voxel across the ray
  double step_mm = 0;            ///< length of `inward`

  [[nodiscard]] Vec3 at(double t) const { return start + t * inward; }
};

/// The radiodensity of the bone at the boundary.
struct Estimate {
  double hu = 0;
  bool resolved = false;  ///< extrapolated from trusted voxels
};

class BoundaryEstimator {
 public:
  BoundaryEstimator(const AlignedImage& hu, const Mask& bone, const Mask& trusted, const AlignedImage& smooth,
                    double noise_hu, const Vec3i& spread)
      : hu_(hu),
        bone_(bone),
        trusted_(trusted),
        smooth_(smooth),
        tolerance_hu_(std::max(kDeviations * noise_hu, kRounding_hu)),
        search_(search_steps(hu.lattice, spread)) {}

  [[nodiscard]] Estimate operator()(const Vec3i& voxel) const {
    const Vec3 gradient = smooth_.gradient(voxel);  // points into the bone, LPS
    const bool uniform = gradient.norm() * smooth_.lattice.spacing_mm.maxCoeff() < kUniform;
    if (uniform) return {densest_around(voxel), false};
    const Ray ray = make_ray(voxel, gradient.normalized());
    const std::optional<double> boundary = boundary_on(ray, voxel);
    if (!boundary) return {densest_around(voxel), false};
    double most = -std::numeric_limits<double>::infinity();
    visit_window(ray, *boundary, [&](const Vec3i& place) { most = std::max(most, double{hu_.at(place)}); });
    const std::optional<Line> line = trusted_line(ray, std::max(*boundary, 0.0));
    if (!line || measured_exceeds(ray, *boundary, *line)) return {most, false};
    return {std::min(line->at(0), std::max(most, line->value)), true};
  }

 private:
  /// Trusted values as a linear function of the depth along a ray, in steps of the ray.
  struct Line {
    double depth = 0;
    double value = 0;
    double slope = 0;  ///< increase outwards

    [[nodiscard]] double at(double t) const { return value + slope * (depth - t); }
  };

  [[nodiscard]] Ray make_ray(const Vec3i& voxel, const Vec3& normal) const {
    const Vec3& spacing = hu_.lattice.spacing_mm;
    Ray ray;
    ray.start = voxel.cast<double>();
    const Vec3 steps = normal.cwiseQuotient(spacing);
    ray.step_mm = 1 / steps.cwiseAbs().maxCoeff();
    ray.inward = ray.step_mm * steps;
    const Vec3 u = normal.unitOrthogonal();
    const Vec3 w = normal.cross(u);
    const std::array<Vec3, 4> directions{u, w, (u + w).eval(), (u - w).eval()};
    for (std::size_t i = 0; i < directions.size(); ++i) {
      ray.sideways[i] = ray.step_mm * directions[i].cwiseQuotient(spacing);
    }
    return ray;
  }

  [[nodiscard]] Vec3i nearest(const Vec3& place) const {
    const Vec3i voxel = (place + Vec3::Constant(0.5)).array().floor().cast<int>();
    return voxel.cwiseMax(0).cwiseMin(hu_.lattice.dims - Vec3i::Ones());
  }
  [[nodiscard]] Vec3i voxel_at(const Ray& ray, double t) const { return nearest(ray.at(t + kInwards)); }
  [[nodiscard]] bool is_bone(const Vec3i& v) const { return bone_[hu_.lattice.index(v)] != 0; }

  /// Where bone begins on the ray: outwards from a voxel of bone, inwards from a voxel outside.
  [[nodiscard]] std::optional<double> boundary_on(const Ray& ray, const Vec3i& voxel) const {
    double t = 0;
    if (is_bone(voxel)) {
      while (t > -search_ && is_bone(voxel_at(ray, t - kStep))) t -= kStep;
      return t;
    }
    while (t < search_ && !is_bone(voxel_at(ray, t))) t += kStep;
    return t < search_ ? std::optional(t) : std::nullopt;
  }

  /// Calls visit(voxel) for bone on the ray within the window below the boundary, until the ray leaves the bone.
  template <class Visit>
  void visit_window(const Ray& ray, double boundary, const Visit& visit) const {
    for (double t = boundary; t <= boundary + kWindow; t += kStep) {
      const Vec3i voxel = voxel_at(ray, t);
      if (!is_bone(voxel)) return;
      visit(voxel);
    }
  }

  /// The largest value of bone in the 3×3×3 neighbourhood; without bone the value of the voxel.
  [[nodiscard]] double densest_around(const Vec3i& voxel) const {
    double most = -std::numeric_limits<double>::infinity();
    for_each_voxel(voxel - Vec3i::Ones(), voxel + Vec3i::Ones(), [&](const Vec3i& neighbour) {
      const Vec3i v = nearest(neighbour.cast<double>());
      if (is_bone(v)) most = std::max(most, double{hu_.at(v)});
    });
    return std::isfinite(most) ? most : double{hu_.at(voxel)};
  }

  /// The scan interpolated between voxels that are all trusted.
  [[nodiscard]] std::optional<double> trusted_at(const Vec3& place) const {
    constexpr double kNoWeight = 1e-9;
    const Vec3i low = place.array().floor().cast<int>();
    std::optional<double> sum = 0.0;
    for_each_trilinear_weight(place - low.cast<double>(), [&](const Vec3i& step, double weight) {
      if (!sum || weight < kNoWeight) return;
      const Vec3i at = low + step;
      const bool trusted = hu_.lattice.contains(at) && trusted_[hu_.lattice.index(at)] != 0;
      sum = trusted ? std::optional(*sum + weight * double{hu_.at(at)}) : std::nullopt;
    });
    return sum;
  }

  /// The mean over points across the ray, in opposite pairs so that a slope across the ray cancels.
  [[nodiscard]] std::optional<double> trusted_mean(const Ray& ray, double t) const {
    const Vec3 middle = ray.at(t);
    const std::optional<double> own = trusted_at(middle);
    if (!own) return std::nullopt;
    double sum = *own;
    int count = 1;
    for (const Vec3& step : ray.sideways) {
      const std::optional<double> one = trusted_at(middle + step), other = trusted_at(middle - step);
      if (!one || !other) continue;
      sum += *one + *other;
      count += 2;
    }
    return sum / count;
  }

  [[nodiscard]] std::optional<Line> trusted_line(const Ray& ray, double from) const {
    for (double t = from; t <= from + search_; t += kStep) {
      if (!is_bone(voxel_at(ray, t))) return std::nullopt;
      const std::optional<double> first = trusted_mean(ray, t);
      if (!first) continue;
      Line line{t, *first, 0};
      const std::optional<double> second = trusted_mean(ray, t + 1), third = trusted_mean(ray, t + 2);
      if (second && third) {
        const double near = *first - *second, far = *second - *third;
        if (near * far > 0) line.slope = std::abs(near) < std::abs(far) ? near : far;
      }
      return line;
    }
    return std::nullopt;
  }

  /// Whether untrusted bone within the window is denser than extrapolated. Partial volume only lowers it.
  [[nodiscard]] bool measured_exceeds(const Ray& ray, double boundary, const Line& line) const {
    const Vec3& spacing = hu_.lattice.spacing_mm;
    const Vec3 along = ray.inward.cwiseProduct(spacing).normalized();
    bool exceeds = false;
    visit_window(ray, boundary, [&](const Vec3i& v) {
      if (trusted_[hu_.lattice.index(v)] != 0) return;
      const double depth_mm = along.dot((v.cast<double>() - ray.start).cwiseProduct(spacing));
      exceeds |= double{hu_.at(v)} > line.at(depth_mm / ray.step_mm) + tolerance_hu_;
    });
    return exceeds;
  }

  const AlignedImage& hu_;
  const Mask& bone_;
  const Mask& trusted_;
  const AlignedImage& smooth_;
  double tolerance_hu_;
  double search_;  ///< steps along a ray
};

Vec3i spread_in_voxels(const Lattice& lattice, const Vec3& psf_mm) {
  constexpr double kWhole = 1e-6;
  return (psf_mm.cwiseQuotient(lattice.spacing_mm) - Vec3::Constant(kWhole)).array().ceil().cast<int>().cwiseMax(1);
}

/// As correct_boundary(), for a whole image.
BoundaryDensity correct(AlignedImage& hu, const Mask& mask, const Vec3& psf_mm, int reach_voxels) {
  constexpr int kByRay = 2;  // layers outside whose values are estimated; further layers are means of neighbours
  const Lattice& lattice = hu.lattice;
  const Vec3i spread = spread_in_voxels(lattice, psf_mm);
  const Mask trusted = eroded(mask, lattice, spread);
  // The mask after a Gaussian filter, which smooths the voxel steps. Its gradient is normal to the boundary.
  AlignedImage smooth{lattice, std::vector<float>(mask.begin(), mask.end())};
  const double sigma_mm = kSigma * lattice.spacing_mm.maxCoeff();
  for (int axis = 0; axis < 3; ++axis) smooth_along(smooth, axis, sigma_mm / lattice.spacing_mm[axis]);
  BoundaryDensity out;
  out.noise_hu = noise_between(hu, trusted);
  const BoundaryEstimator estimate(hu, mask, trusted, smooth, out.noise_hu, spread);

  Mask known = dilated(mask, lattice, Vec3i::Constant(kByRay));
  std::vector<std::size_t> places;
  for (std::size_t at = 0; at < known.size(); ++at) {
    if (known[at] != 0 && trusted[at] == 0) places.push_back(at);
  }
  std::vector<Estimate> found(places.size());
  parallel_items(places.size(), 1024, [&](std::size_t i) { found[i] = estimate(lattice.voxel_at(places[i])); });
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (mask[places[i]] == 0 || !has_face_outside(mask, lattice, lattice.voxel_at(places[i]))) continue;
    ++out.boundary_voxels;
    out.unresolved_voxels += found[i].resolved ? 0 : 1;
  }
  for (std::size_t i = 0; i < places.size(); ++i) hu.value[places[i]] = static_cast<float>(found[i].hu);
  spread_outwards(hu, known, reach_voxels - kByRay);
  return out;
}

}  // namespace

BoundaryDensity correct_boundary(AlignedImage& hu, const BoneField& bone, const Vec3& psf_mm, int reach_voxels) {
  // The field extends up to two voxels beyond the kept bone where a cut passes; erosion needs another point spread.
  const Vec3i room = spread_in_voxels(hu.lattice, psf_mm) + Vec3i::Constant(reach_voxels + 3);
  const IndexBox box = box_around(bone.min, bone.max, room, hu.lattice);
  AlignedImage part{hu.lattice.part(box), part_of(hu.value, hu.lattice, box)};
  const AlignedImage field{part.lattice, part_of(bone.field.value, hu.lattice, box)};
  const BoundaryDensity out = correct(part, positive_voxels(field), psf_mm, reach_voxels);
  part.lattice.for_each(
      [&](const Vec3i& voxel, std::size_t at) { hu.value[hu.lattice.index(voxel + box.start)] = part.value[at]; });
  return out;
}

}  // namespace reamsim::ct

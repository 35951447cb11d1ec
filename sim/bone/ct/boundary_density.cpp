#include "sim/bone/ct/boundary_density.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "sim/base/parallel.h"
#include "sim/bone/ct/boundary_layers.h"
#include "sim/bone/ct/boundary_normals.h"

namespace reamsim::ct {

namespace {

/// Steps along the normal, in voxels.
constexpr double kStep = 0.25;
/// Below the boundary, measured values may speak for it as deep as this, voxels.
constexpr double kWindow = 2;
/// A measured value is higher than another when it exceeds it by so many standard deviations of the noise, and by what
/// rounding to whole HU can do.
constexpr double kDeviations = 3;
constexpr double kRounding_hu = 10;
/// Trusted voxels are looked for this far beyond the point spread, voxels.
constexpr double kSearch = 2.5;

/// The line through a voxel along the inward normal, in voxel indices.
struct Ray {
  Vec3 start;
  Vec3 inward;                   ///< one voxel along the axis in which it moves fastest
  std::array<Vec3, 4> sideways;  ///< steps across it, about a voxel long
  double step_mm = 0;            ///< length of `inward`

  [[nodiscard]] Vec3 at(double t) const { return start + t * inward; }
};

/// A value of the bone at the boundary; `resolved` where trusted voxels gave it.
struct Estimate {
  double hu = 0;
  bool resolved = false;
};

class BoundaryEstimator {
 public:
  BoundaryEstimator(const AlignedImage& hu, const Mask& bone, const Mask& trusted, const BoundaryNormals& normals,
                    double noise_hu, int spread_voxels)
      : hu_(hu),
        bone_(bone),
        trusted_(trusted),
        normals_(normals),
        tolerance_hu_(std::max(kDeviations * noise_hu, kRounding_hu)),
        search_(spread_voxels * std::sqrt(3.0) + kSearch) {}

  [[nodiscard]] Estimate operator()(const Vec3i& voxel) const {
    const Vec3 normal = normals_.inward(voxel);
    if (normal.isZero()) return {densest_around(voxel), false};
    const Ray ray = make_ray(voxel, normal);
    const std::optional<double> boundary = boundary_on(ray, voxel);
    if (!boundary) return {densest_around(voxel), false};
    const double most = densest_on(ray, *boundary);
    const std::optional<Line> line = trusted_line(ray, std::max(*boundary, 0.0));
    if (!line || measured_exceeds(ray, *boundary, *line)) return {most, false};
    return {std::min(line->at(0), std::max(most, line->value)), true};
  }

 private:
  /// Trusted values as a straight line over the depth along a ray, in steps of the ray.
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
  [[nodiscard]] bool is_bone(const Vec3i& v) const { return bone_[hu_.lattice.index(v)] != 0; }

  /// Where bone begins on the ray: out from a voxel of bone, in from a voxel outside.
  [[nodiscard]] std::optional<double> boundary_on(const Ray& ray, const Vec3i& voxel) const {
    double t = 0;
    if (is_bone(voxel)) {
      while (t > -search_ && is_bone(nearest(ray.at(t - kStep)))) t -= kStep;
      return t;
    }
    while (t < search_ && !is_bone(nearest(ray.at(t)))) t += kStep;
    return t < search_ ? std::optional(t) : std::nullopt;
  }

  /// Calls visit(voxel) for bone on the ray within the window below the boundary, until the ray leaves the bone.
  template <class Visit>
  void visit_window(const Ray& ray, double boundary, const Visit& visit) const {
    for (double t = boundary; t <= boundary + kWindow; t += kStep) {
      const Vec3i voxel = nearest(ray.at(t));
      if (!is_bone(voxel)) return;
      visit(voxel);
    }
  }

  [[nodiscard]] double measured(const Vec3i& v) const { return double{hu_.value[hu_.lattice.index(v)]}; }

  [[nodiscard]] double densest_on(const Ray& ray, double boundary) const {
    double most = -std::numeric_limits<double>::infinity();
    visit_window(ray, boundary, [&](const Vec3i& voxel) { most = std::max(most, measured(voxel)); });
    return most;
  }

  /// Of the bone among the 27 voxels round one; its own value where there is none.
  [[nodiscard]] double densest_around(const Vec3i& voxel) const {
    double most = -std::numeric_limits<double>::infinity();
    for (int n = 0; n < 27; ++n) {
      const Vec3i v = nearest((voxel + Vec3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)).cast<double>());
      if (is_bone(v)) most = std::max(most, measured(v));
    }
    return std::isfinite(most) ? most : measured(voxel);
  }

  /// The scan between voxels that are all trusted.
  [[nodiscard]] std::optional<double> trusted_at(const Vec3& place) const {
    const Vec3i low = place.array().floor().cast<int>();
    const Vec3 fraction = place - low.cast<double>();
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      Vec3i at = low;
      for (int axis = 0; axis < 3; ++axis) {
        const bool upper = (corner >> axis & 1) != 0;
        at[axis] += upper ? 1 : 0;
        weight *= upper ? fraction[axis] : 1 - fraction[axis];
      }
      if (weight < 1e-9) continue;
      if (!hu_.lattice.contains(at)) return std::nullopt;
      const std::size_t index = hu_.lattice.index(at);
      if (trusted_[index] == 0) return std::nullopt;
      sum += weight * double{hu_.value[index]};
    }
    return sum;
  }

  /// The mean over places across the ray, taken in opposite pairs so that a slope across it cancels.
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
      if (!is_bone(nearest(ray.at(t)))) return std::nullopt;
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

  /// Whether bone within the window that is not trusted is denser than the trusted bone lets expect: partial volume
  /// only ever lowers it.
  [[nodiscard]] bool measured_exceeds(const Ray& ray, double boundary, const Line& line) const {
    const Vec3& spacing = hu_.lattice.spacing_mm;
    const Vec3 along = ray.inward.cwiseProduct(spacing).normalized();
    bool exceeds = false;
    visit_window(ray, boundary, [&](const Vec3i& v) {
      if (trusted_[hu_.lattice.index(v)] != 0) return;
      const double depth_mm = along.dot((v.cast<double>() - ray.start).cwiseProduct(spacing));
      exceeds |= measured(v) > line.at(depth_mm / ray.step_mm) + tolerance_hu_;
    });
    return exceeds;
  }

  const AlignedImage& hu_;
  const Mask& bone_;
  const Mask& trusted_;
  const BoundaryNormals& normals_;
  double tolerance_hu_;
  double search_;  ///< steps along a ray
};

Mask bone_mask(const AlignedImage& bone) {
  Mask out(bone.value.size());
  std::transform(bone.value.begin(), bone.value.end(), out.begin(), [](float value) { return value > 0 ? 1 : 0; });
  return out;
}

Vec3i spread_in_voxels(const Lattice& lattice, double psf_mm) {
  constexpr double kWhole = 1e-6;
  return (psf_mm * lattice.spacing_mm.cwiseInverse() - Vec3::Constant(kWhole)).array().ceil().cast<int>().cwiseMax(1);
}

bool has_face_outside(const Mask& bone, const Lattice& lattice, const Vec3i& voxel) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const Vec3i v = voxel + side * Vec3i::Unit(axis);
      if (lattice.contains(v) && bone[lattice.index(v)] == 0) return true;
    }
  }
  return false;
}

/// Part of an image.
AlignedImage cut_out(const AlignedImage& image, const IndexBox& box) {
  const Vec3i& s = box.start;
  AlignedImage out{{box.size, image.lattice.spacing_mm, image.lattice.center_mm(s)}, {}};
  out.value.reserve(static_cast<std::size_t>(box.voxels()));
  for (int k = 0; k < box.size.z(); ++k) {
    for (int j = 0; j < box.size.y(); ++j) {
      const auto row =
          image.value.begin() + static_cast<std::ptrdiff_t>(image.lattice.index({s.x(), s.y() + j, s.z() + k}));
      out.value.insert(out.value.end(), row, row + box.size.x());
    }
  }
  return out;
}

void put_back(const AlignedImage& part, const IndexBox& box, AlignedImage& image) {
  const Vec3i& s = box.start;
  for (int k = 0; k < box.size.z(); ++k) {
    for (int j = 0; j < box.size.y(); ++j) {
      const auto row = part.value.begin() + static_cast<std::ptrdiff_t>(part.lattice.index({0, j, k}));
      std::copy(row, row + box.size.x(),
                image.value.begin() + static_cast<std::ptrdiff_t>(image.lattice.index({s.x(), s.y() + j, s.z() + k})));
    }
  }
}

/// As correct_boundary(), of a whole image.
BoundaryDensity correct(AlignedImage& hu, const Mask& mask, double psf_mm, int reach_voxels) {
  constexpr int kByRay = 2;  // voxels outside that get a value of their own; those beyond take their neighbours'
  const Lattice& lattice = hu.lattice;
  const Vec3i spread = spread_in_voxels(lattice, psf_mm);
  const Mask trusted = eroded(mask, lattice, spread);
  const BoundaryNormals normals(mask, lattice);
  BoundaryDensity out;
  out.noise_hu = noise_between(hu, trusted);
  const BoundaryEstimator estimate(hu, mask, trusted, normals, out.noise_hu, spread.maxCoeff());

  Mask known = dilated(mask, lattice, Vec3i::Constant(kByRay));
  std::vector<std::size_t> places;
  for (std::size_t at = 0; at < known.size(); ++at) {
    if (known[at] != 0 && trusted[at] == 0) places.push_back(at);
  }
  std::vector<Estimate> found(places.size());
  parallel_ranges(places.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) found[i] = estimate(lattice.voxel_at(places[i]));
  });
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

BoundaryDensity correct_boundary(AlignedImage& hu, const BoneField& bone, double psf_mm, int reach_voxels) {
  // Cuts leave bone as far as two voxels beyond the box of what is kept; the trusted part takes another point spread.
  const Vec3i room = spread_in_voxels(hu.lattice, psf_mm) + Vec3i::Constant(reach_voxels + 3);
  IndexBox box;
  box.start = (bone.min - room).cwiseMax(0);
  box.size = (bone.max + room + Vec3i::Ones()).cwiseMin(hu.lattice.dims) - box.start;
  AlignedImage part = cut_out(hu, box);
  const BoundaryDensity out = correct(part, bone_mask(cut_out(bone.field, box)), psf_mm, reach_voxels);
  put_back(part, box, hu);
  return out;
}

}  // namespace reamsim::ct

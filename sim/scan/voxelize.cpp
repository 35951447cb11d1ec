// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/base/parallel.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/sample_voxels.h"
#include "sim/bone/voxmap/sparse_bricks.h"
#include "sim/scan/segment.h"

namespace reamsim::ct {

namespace {

/// Slices that are sampled before they are stored.
constexpr std::size_t kSlicesAtOnce = 4;
/// The field can be above 0 up to the next image voxel outside the bone, and up to the second where a cut passes.
constexpr int kFieldReach = 2;

struct HuStatistics {
  std::int64_t voxels = 0;
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  double sum = 0;

  void add(double hu) {
    ++voxels;
    sum += hu;
    least = std::min(least, hu);
    most = std::max(most, hu);
  }
};

/// An isotropic grid around the bone, with a margin and whole bricks. Its planes start at the lower corner of the
/// image, so that voxels of the image's size coincide with those of the image.
VoxelGrid grid_of(const Lattice& image, const BoneField& bone, const BoneSettings& settings) {
  const std::string& path = settings.ct.path;
  const double voxel_mm = settings.voxel_mm;
  const Vec3 corner = image.bounds_mm().min;
  VoxelGrid grid;
  grid.voxel_mm = voxel_mm;
  for (int axis = 0; axis < 3; ++axis) {
    const int first = bone.min[axis] - kFieldReach, end = bone.max[axis] + kFieldReach + 1;
    const double low = std::floor(first * image.spacing_mm[axis] / voxel_mm + kRounding) - kMarginVoxels;
    const double high = std::ceil(end * image.spacing_mm[axis] / voxel_mm - kRounding) + kMarginVoxels;
    const double bricks = std::ceil((high - low) / FillBricks::kSide);
    if (bricks * FillBricks::kSide > std::numeric_limits<int>::max()) {
      throw InputError({path}, "bone.voxel_mm", "too many voxels", "use larger voxels");
    }
    grid.dims[axis] = static_cast<int>(bricks) * FillBricks::kSide;
    grid.origin_mm[axis] = corner[axis] + low * voxel_mm;
  }
  check_fits_in_memory(grid.dims.cast<double>().prod(), sizeof(std::uint8_t), {path, "bone.voxel_mm"});
  return grid;
}

/// Tests whether at least half of a voxel of a grid lies where `field` > 0. The field is interpolated trilinearly at
/// the centre of the voxel, or at several sample points along axes on which the voxel is larger than the spacing.
class InsideTest {
 public:
  /// Indices from the first to the last; none by default.
  struct Span {
    int first = std::numeric_limits<int>::max();
    int last = -1;
  };

  InsideTest(const AlignedImage& field, const VoxelGrid& grid)
      : field_(field), rows_(static_cast<std::size_t>(field.lattice.dims.y() * field.lattice.dims.z())) {
    const Lattice& image = field.lattice;
    for (int axis = 0; axis < 3; ++axis) {
      const double length = grid.voxel_mm / image.spacing_mm[axis];
      // Two samples per image voxel, up to a limit.
      const double wanted = length > 1 + kRounding ? 2 * std::ceil(length - kRounding) : 1;
      samples_[axis] = static_cast<int>(std::min(wanted, kMaxSamples));
      for (int n = 0; n < grid.dims[axis] * samples_[axis]; ++n) {
        const double mm = grid.origin_mm[axis] + grid.voxel_mm * (n + 0.5) / samples_[axis];
        const double place = std::clamp(faces_from_mm(image, mm, axis) - 0.5, 0.0, image.dims[axis] - 1.0);
        const int low = std::min(static_cast<int>(place), std::max(image.dims[axis] - 2, 0));
        sample_[axis].push_back({low, static_cast<float>(place - low)});
      }
    }
    image.for_each([&](const Vec3i& v, std::size_t at) {
      Span& row = rows_[static_cast<std::size_t>(v.y() + image.dims.y() * v.z())];
      if (field.value[at] > 0) row = {std::min(row.first, v.x()), v.x()};
    });
  }

  /// The voxels of the row (j, k) that may pass the test, first and last: interpolated values are above 0 only beside
  /// voxels of the image above 0.
  [[nodiscard]] Span columns(int j, int k) const {
    Span above;
    const Vec3i& dims = field_.lattice.dims;
    const auto at = [&](int axis, int n) { return sample_[axis][static_cast<std::size_t>(n)].low; };
    const int y = at(1, j * samples_.y()), last_y = at(1, (j + 1) * samples_.y() - 1) + 1;
    const int z = at(2, k * samples_.z()), last_z = at(2, (k + 1) * samples_.z() - 1) + 1;
    for_each_voxel({0, y, z}, {0, std::min(last_y, dims.y() - 1), std::min(last_z, dims.z() - 1)},
                   [&](const Vec3i& row) {
                     const Span& found = rows_[static_cast<std::size_t>(row.y() + dims.y() * row.z())];
                     above = {std::min(above.first, found.first), std::max(above.last, found.last)};
                   });
    if (above.last < 0) return {};
    const auto& x = sample_[0];
    const auto first = std::ranges::lower_bound(x, above.first - 1, {}, &Sample::low);
    const auto end = std::ranges::upper_bound(x, above.last, {}, &Sample::low);
    return {static_cast<int>(first - x.begin()) / samples_.x(), static_cast<int>(end - x.begin() - 1) / samples_.x()};
  }

  [[nodiscard]] bool operator()(const Vec3i& voxel) const {
    const Vec3i first = voxel.cwiseProduct(samples_);
    const auto sample = [this](const Vec3i& s, int axis) { return sample_[axis][static_cast<std::size_t>(s[axis])]; };
    int hits = 0;
    for_each_voxel(first, first + samples_ - Vec3i::Ones(),
                   [&](const Vec3i& s) { hits += inside(sample(s, 0), sample(s, 1), sample(s, 2)); });
    return 2 * hits >= samples_.prod() && hits > 0;
  }

 private:
  struct Sample {
    int low = 0;         ///< lower of the two image voxels along this axis
    float fraction = 0;  ///< weight of the upper one
  };

  [[nodiscard]] bool inside(const Sample& x, const Sample& y, const Sample& z) const {
    const Lattice& image = field_.lattice;
    const std::size_t step_x = image.dims.x() > 1 ? 1 : 0;
    const std::size_t step_y = image.dims.y() > 1 ? static_cast<std::size_t>(image.dims.x()) : 0;
    const std::size_t step_z = image.dims.z() > 1 ? image.index({0, 0, 1}) : 0;
    const float* corner = &field_.value[image.index({x.low, y.low, z.low})];
    const auto along_x = [&](std::size_t at) { return corner[at] + x.fraction * (corner[at + step_x] - corner[at]); };
    const auto along_y = [&](std::size_t at) {
      const float low = along_x(at);
      return low + y.fraction * (along_x(at + step_y) - low);
    };
    const float low = along_y(0);
    return low + z.fraction * (along_y(step_z) - low) > 0;
  }

  static constexpr double kMaxSamples = 16;  ///< of one voxel along one axis

  const AlignedImage& field_;
  std::vector<Span> rows_;         ///< by row of the image: values above 0
  Vec3i samples_ = Vec3i::Ones();  ///< per voxel, along each axis
  std::vector<Sample> sample_[3];  ///< of voxel n: samples_ from n·samples_
};

/// Whether a point lies in the image and outside the cuts. Cuts do not apply to a label map.
bool may_be_bone(const CtSettings& settings, const Aabb& image, const Vec3& point_mm) {
  return image.contains(point_mm) && (settings.label_map || !is_cut_away(settings, point_mm));
}

/// The fraction of a voxel within the image and outside the cuts.
double remaining_fraction(const CtSettings& settings, const Aabb& image, const Vec3& center_mm, double voxel_mm) {
  double fraction = fraction_in_box(image, center_mm, voxel_mm);
  if (settings.label_map) return fraction;
  for (const CutSphereSettings& sphere : settings.cut_spheres) {
    const auto distance = [&](const Vec3& point) { return (point - sphere.center_mm).norm() - sphere.radius_mm; };
    fraction *= 1 - fraction_inside(distance, center_mm, voxel_mm);
  }
  for (const CutPlaneSettings& plane : settings.cut_planes) {
    fraction *= fraction_inside([&](const Vec3& point) { return plane.normal.dot(point - plane.point_mm); }, center_mm,
                                voxel_mm);
  }
  return fraction;
}

/// The fill follows from the zero of the field. The grade follows from the image, whose values were corrected on both
/// sides of the boundary.
void set_fill_at_surface(const BoneField& bone, const SliceResampler& hu, const CtSettings& settings, const Aabb& image,
                         FilledVoxmap& voxmap) {
  const VoxelGrid& grid = voxmap.grid;
  // A voxel is halved until its parts are no larger than the voxels of the image.
  constexpr double kRoundingOfLog = 1e-6;
  constexpr int kMostSplits = 3;
  const double ratio = grid.voxel_mm / bone.field.lattice.spacing_mm.minCoeff();
  const int splits = std::clamp(static_cast<int>(std::ceil(std::log2(ratio) - kRoundingOfLog)), 0, kMostSplits);
  const NegatedField outside(bone.field);
  const auto sample = [&](const Vec3i& voxel, std::uint8_t grade) -> SurfaceVoxel {
    const Vec3 center = grid.center_mm(voxel);
    const double part = fraction_inside(outside, center, grid.voxel_mm, splits);
    if (part == 0) return {0, grade};
    return {part * remaining_fraction(settings, image, center, grid.voxel_mm),
            grade != 0 ? grade : voxmap.mapping.grade_from_hu(hu.at(voxel))};
  };
  set_partial_fill(sample, voxmap);
}

void note_voxmap(const FilledVoxmap& voxmap, const HuStatistics& hu, Diagnostics& report) {
  const VoxelGrid& grid = voxmap.grid;
  report.note(
      fmt::format("voxmap: {}x{}x{} voxels of {:g} mm; bone {} voxels, {:.0f} mm3; HU {:.0f} to {:.0f}, mean {:.0f}",
                  grid.dims.x(), grid.dims.y(), grid.dims.z(), grid.voxel_mm, voxmap.count_bone(), voxmap.bone_mm3(),
                  hu.least, hu.most, hu.sum / static_cast<double>(hu.voxels)));
}

}  // namespace

int resampling_reach(const Lattice& image, double voxel_mm) {
  return kFieldReach + static_cast<int>(std::ceil(voxel_mm / image.spacing_mm.minCoeff()));
}

FilledVoxmap voxelize(const AlignedImage& hu, const BoneField& bone, const BoneSettings& settings,
                      Diagnostics& report) {
  const VoxelGrid grid = grid_of(hu.lattice, bone, settings);
  FilledVoxmap voxmap(grid);
  voxmap.mapping = {settings.density};
  voxmap.frame = "LPS";
  const SliceResampler resampled(hu, grid);
  const InsideTest in_bone(bone.field, grid);
  const Aabb image = hu.lattice.bounds_mm();
  HuStatistics stats;
  DensityLimit limit(voxmap.mapping);
  using Values = std::vector<std::pair<Vec3i, double>>;  // of the bone in a slice
  const auto sample = [&](std::size_t slice, Values& out) {
    const int k = static_cast<int>(slice);
    const std::vector<double> values = resampled.slice(k);
    out.clear();
    for (int j = 0; j < grid.dims.y(); ++j) {
      const auto [first, last] = in_bone.columns(j, k);
      for (int i = first; i <= last; ++i) {
        const Vec3i voxel(i, j, k);
        if (!in_bone(voxel) || !may_be_bone(settings.ct, image, grid.center_mm(voxel))) continue;
        out.emplace_back(voxel, values[index_in(grid.dims, {i, j, 0})]);
      }
    }
  };
  const auto store = [&](std::size_t, const Values& values) {
    for (const auto& [voxel, value] : values) {
      voxmap.grade.set(voxel, voxmap.mapping.grade_from_hu(value));
      stats.add(value);
      limit.add(value, grid.voxel_mm3());
    }
  };
  parallel_in_order<Values>(static_cast<std::size_t>(grid.dims.z()), kSlicesAtOnce, sample, store);
  if (stats.voxels == 0) {
    throw InputError({settings.ct.path}, "bone.voxel_mm", "no bone remains at this voxel size", "use smaller voxels");
  }
  if (settings.surface_voxels == SurfaceVoxels::partial)
    set_fill_at_surface(bone, resampled, settings.ct, image, voxmap);
  note_voxmap(voxmap, stats, report);
  limit.warn(settings.ct.path, report);
  return voxmap;
}

}  // namespace reamsim::ct

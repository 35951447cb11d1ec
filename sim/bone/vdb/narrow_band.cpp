// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>

#include "sim/base/geometry.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/grids.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;
using Point = Eigen::Vector3f;

// Eigen 5 adds these terms in another order than Eigen 3.4. The order of Eigen 3.4 keeps the bytes of the grids.
float dot(const Point& a, const Point& b) {
  return a.x() * b.x() + (a.y() * b.y() + a.z() * b.z());
}
float length_of(const Point& p) {
  return std::sqrt(dot(p, p));
}

constexpr int kSide = static_cast<int>(Leaf::DIM);
constexpr int kMargin = 4;  // voxels around a leaf in which its closest points lie
constexpr int kSamples = kSide + 2 * kMargin + 1;
constexpr int kCells = kSamples - 1;
constexpr int kRefinements = 3;
constexpr float kWithinCell = 0.9F;  // half a cell's diagonal: from the nearest point of a cell to the closest one

/// Offset of a voxel in the leaf that holds it. The axes are in the order z, y, x.
std::ptrdiff_t offset_in_leaf(const Vec3i& v) {
  return (v.z() & (kSide - 1)) * kSide * kSide + (v.y() & (kSide - 1)) * kSide + (v.x() & (kSide - 1));
}

bool inside(float occupancy) {
  return occupancy >= 0.5F;
}

/// The occupancy of a leaf and its margin, by place: voxel centres from (-kMargin, -kMargin, -kMargin) on. Here and
/// below the axes are in the order z, y, x, because z varies fastest in a leaf.
class Block {
 public:
  Block(const openvdb::FloatTree& occupancy, const openvdb::Coord& corner)
      : values_(std::size_t{kSamples} * kSamples * kSamples) {
    for_each_voxel(Vec3i::Constant(-1), Vec3i::Ones(), [&](const Vec3i& step) {
      const openvdb::Coord from = corner.offsetBy(kSide * step.z(), kSide * step.y(), kSide * step.x());
      const Leaf* leaf = occupancy.probeConstLeaf(from);
      const float all = leaf == nullptr ? occupancy.getValue(from) : 0.0F;
      const float* values = leaf == nullptr ? nullptr : leaf->buffer().data();
      const Vec3i first = (kSide * step).cwiseMax(-kMargin),
                  last = (kSide * step.array() + kSide - 1).min(kSide + kMargin);
      for (int z = first.z(); z <= last.z(); ++z) {
        for (int y = first.y(); y <= last.y(); ++y) {
          float* to = &values_[place(first.x() + kMargin, y + kMargin, z + kMargin)];
          const int count = last.x() - first.x() + 1;
          if (values == nullptr) {
            std::fill_n(to, count, all);
          } else {
            std::copy_n(values + offset_in_leaf({first.x(), y, z}), count, to);
          }
        }
      }
    });
    for (std::size_t row = 0; row < inside_.size(); ++row) {
      for (std::size_t x = 0; x < kSamples; ++x) {
        inside_[row] |= std::uint32_t{inside(values_[kSamples * row + x])} << x;
      }
    }
  }

  /// The cells of a row that the surface intersects, a bit each.
  [[nodiscard]] std::uint32_t mixed_cells(int y, int z) const {
    const auto at = static_cast<std::size_t>(y + kSamples * z);
    const std::uint32_t a = inside_[at], b = inside_[at + 1], c = inside_[at + kSamples],
                        d = inside_[at + kSamples + 1];
    const std::uint32_t any = a | b | c | d, all = a & b & c & d;
    return ((any | any >> 1) & ~(all & all >> 1)) & ((1U << kCells) - 1);
  }

  [[nodiscard]] float at(int x, int y, int z) const { return values_[place(x, y, z)]; }

  /// The values at the corners of a cell; x varies fastest.
  using Corners = std::array<float, 8>;
  [[nodiscard]] Corners corners(const Vec3i& cell) const {
    const float* v = values_.data() + place(cell.x(), cell.y(), cell.z());
    constexpr std::size_t kRow = kSamples, kLayer = kRow * kSamples;
    return {v[0], v[1], v[kRow], v[kRow + 1], v[kLayer], v[kLayer + 1], v[kLayer + kRow], v[kLayer + kRow + 1]};
  }

  /// Value, and its gradient, of the trilinear interpolation.
  float interpolate(const Point& p, Point& gradient) const {
    const Eigen::Array3f limited = p.array().max(0.0F).min(static_cast<float>(kCells) - 1e-3F);
    const Eigen::Array3i cell = limited.cast<int>();
    const Eigen::Array3f t = limited - cell.cast<float>(), u = 1.0F - t;
    const Corners v = corners(cell.matrix());
    const float x0 = u.x() * v[0] + t.x() * v[1], x1 = u.x() * v[2] + t.x() * v[3];
    const float x2 = u.x() * v[4] + t.x() * v[5], x3 = u.x() * v[6] + t.x() * v[7];
    const float y0 = u.y() * x0 + t.y() * x1, y1 = u.y() * x2 + t.y() * x3;
    gradient.x() = u.z() * (u.y() * (v[1] - v[0]) + t.y() * (v[3] - v[2])) +
                   t.z() * (u.y() * (v[5] - v[4]) + t.y() * (v[7] - v[6]));
    gradient.y() = u.z() * (x1 - x0) + t.z() * (x3 - x2);
    gradient.z() = y1 - y0;
    return u.z() * y0 + t.z() * y1;
  }

 private:
  static std::size_t place(int x, int y, int z) { return static_cast<std::size_t>(x + kSamples * (y + kSamples * z)); }

  std::vector<float> values_;
  std::array<std::uint32_t, std::size_t{kSamples} * kSamples> inside_{};  ///< of a row along x, a bit per sample
};

/// A point of the surface in a cell that it intersects, with the occupancy there and its gradient.
struct ClosestPoint {
  Point at, gradient;
  float value = 0;
};

ClosestPoint closest_point_at(const Block& block, const Point& p) {
  ClosestPoint out{.at = p, .gradient = {}};
  out.value = block.interpolate(p, out.gradient);
  return out;
}

/// A point moved to the surface along the gradient.
ClosestPoint on_surface(const Block& block, const Point& p) {
  const ClosestPoint from = closest_point_at(block, p);
  const float steepness2 = dot(from.gradient, from.gradient);
  if (steepness2 < 1e-6F) return from;
  const Point step = (0.5F - from.value) / steepness2 * from.gradient;
  const float length = length_of(step), most = 0.5F;
  return closest_point_at(block, length > most ? Point(p + most / length * step) : Point(p + step));
}

/// The mean of the points where the surface intersects the edges of a cell, moved to the surface.
ClosestPoint closest_point_in_cell(const Block& block, const Vec3i& cell) {
  const Block::Corners corner = block.corners(cell);
  int count = 0;
  std::array<float, 3> sum{};
  for (unsigned axis = 0; axis < 3; ++axis) {
    for (unsigned from = 0; from < 8; ++from) {
      const unsigned to = from | 1U << axis;
      if (to == from || inside(corner[from]) == inside(corner[to])) continue;
      for (unsigned i = 0; i < 3; ++i) sum[i] += static_cast<float>(from >> i & 1);
      sum[axis] += (0.5F - corner[from]) / (corner[to] - corner[from]);
      ++count;
    }
  }
  const Point within = Point(sum[0], sum[1], sum[2]) / static_cast<float>(count);
  return on_surface(block, cell.cast<float>() + within);
}

std::vector<ClosestPoint> closest_points_of(const Block& block) {
  std::vector<ClosestPoint> out;
  for (int z = 0; z < kCells; ++z) {
    for (int y = 0; y < kCells; ++y) {
      for (std::uint32_t rest = block.mixed_cells(y, z); rest != 0; rest &= rest - 1) {
        out.push_back(closest_point_in_cell(block, {std::countr_zero(rest), y, z}));
      }
    }
  }
  return out;
}

/// Points by component, with their numbers. The compiler vectorizes searches in it.
class PointSet {
 public:
  PointSet() = default;
  explicit PointSet(const std::vector<ClosestPoint>& closest_points) {
    for (const ClosestPoint& closest : closest_points) {
      x_.push_back(closest.at.x());
      y_.push_back(closest.at.y());
      z_.push_back(closest.at.z());
      number_.push_back(static_cast<std::int32_t>(number_.size()));
    }
  }

  [[nodiscard]] bool empty() const { return number_.empty(); }

  /// Sets `out` to those within `reach` of a box.
  void select_near_box(const Point& first, const Point& last, float reach, PointSet& out) const {
    const Eigen::Array3f low = first.array() - reach, high = last.array() + reach;
    select([&](std::size_t i) { return (point(i).array() >= low).all() && (point(i).array() <= high).all(); }, out);
  }
  /// Sets `out` to those at most `more` further from `p` than the nearest; to none if that is beyond `reach`.
  void select_nearest(const Point& p, float reach, float more, PointSet& out) {
    squares_.resize(number_.size());
    float least = std::numeric_limits<float>::max();
    for (std::size_t i = 0; i < squares_.size(); ++i) {
      const float dx = x_[i] - p.x(), dy = y_[i] - p.y(), dz = z_[i] - p.z();
      squares_[i] = dx * dx + dy * dy + dz * dz;
      least = squares_[i] < least ? squares_[i] : least;
    }
    const float nearest = std::sqrt(least), most = (nearest + more) * (nearest + more);
    if (nearest > reach) return out.resize(0);
    select([&](std::size_t i) { return squares_[i] <= most; }, out);
  }

  /// The nearest of the points, by number, and its distance. Squared distance and place are compared as one integer.
  struct Nearest {
    std::int32_t number = 0;
    float distance = 0;
  };
  [[nodiscard]] Nearest nearest(const Point& p) const {
    constexpr int kPlaceBits = 12;  // there are at most 16³ cells
    static_assert(kCells * kCells * kCells <= 1 << kPlaceBits);
    constexpr float kPerSquare = 1024;
    std::int32_t best = std::numeric_limits<std::int32_t>::max();
    const auto count = static_cast<std::int32_t>(number_.size());
    for (std::int32_t i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const float dx = x_[k] - p.x(), dy = y_[k] - p.y(), dz = z_[k] - p.z();
      const float square = (dx * dx + dy * dy + dz * dz) * kPerSquare;
      const std::int32_t key = static_cast<std::int32_t>(square) << kPlaceBits | i;
      best = key < best ? key : best;
    }
    const auto k = static_cast<std::size_t>(best & ((1 << kPlaceBits) - 1));
    return {number_[k], length_of(point(k) - p)};
  }

  void resize(std::size_t count) {
    for (std::vector<float>* values : {&x_, &y_, &z_}) values->resize(count);
    number_.resize(count);
  }

 private:
  /// Sets `out` to the points that meet a condition, without branches.
  template <class Condition>
  void select(const Condition& condition, PointSet& out) const {
    out.resize(number_.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < number_.size(); ++i) {
      out.x_[count] = x_[i];
      out.y_[count] = y_[i];
      out.z_[count] = z_[i];
      out.number_[count] = number_[i];
      count += condition(i) ? 1 : 0;
    }
    out.resize(count);
  }
  [[nodiscard]] Point point(std::size_t i) const { return {x_[i], y_[i], z_[i]}; }

  std::vector<float> x_, y_, z_;
  std::vector<std::int32_t> number_;
  std::vector<float> squares_;  ///< of select_nearest()
};

/// Distance from the surface near a foot, voxels: steps along the surface to where the gradient leads to `p`.
float refined_distance(const Block& block, const Point& p, ClosestPoint foot) {
  constexpr float kSmallStep = 0.05F;  // a step along the surface moves the distance by its square
  const float nearest = length_of(p - foot.at);
  for (int i = 0; i < kRefinements; ++i) {
    const float steepness2 = dot(foot.gradient, foot.gradient);
    if (steepness2 < 1e-6F) break;
    const Point to_p = p - foot.at;
    const Point along = to_p - (dot(to_p, foot.gradient) - (0.5F - foot.value)) / steepness2 * foot.gradient;
    const float length = length_of(along);
    foot.at += length > 1 ? Point(along / length) : along;
    if (length < kSmallStep) break;
    foot.value = block.interpolate(foot.at, foot.gradient);
  }
  return std::min(nearest, length_of(p - foot.at));
}

/// Distances of a leaf's voxels from the closest points, at most kHalfBandVoxels. Points are first selected for cubes
/// of 4³ voxels, then of 2³: what is nearest to a voxel is hardly further from the cube's centre than the nearest
/// there.
class LeafDistances {
 public:
  LeafDistances(const Block& block, const std::vector<ClosestPoint>& closest_points)
      : block_(block), closest_points_(closest_points) {
    const PointSet all(closest_points);
    constexpr int kPart = kSide / 2;
    for_each_voxel(Vec3i::Constant(2), [&](const Vec3i& part) {
      const Vec3i first = kPart * part;
      all.select_near_box(place(first), place(first + Vec3i::Constant(kPart - 1)), kReach, near_part_);
      for_each_voxel(Vec3i::Constant(kPart / 2), [&](const Vec3i& pair) { set_pair(first + 2 * pair); });
    });
  }

  /// By offset_in_leaf().
  [[nodiscard]] float at(std::ptrdiff_t offset) const { return distances_[static_cast<std::size_t>(offset)]; }

 private:
  static constexpr float kReach = kHalfBandVoxels + kWithinCell;

  static Point place(const Vec3i& v) { return v.cast<float>().array() + static_cast<float>(kMargin); }

  /// Two voxels along each axis.
  void set_pair(const Vec3i& first) {
    constexpr float kFromCentre = 0.867F;  // half the diagonal of the cube of their centres
    const Point centre = place(first).array() + 0.5F;
    near_part_.select_nearest(centre, kReach + kFromCentre, 2 * kFromCentre, near_pair_);
    for_each_voxel(Vec3i::Constant(2), [&](const Vec3i& step) {
      const Vec3i v = first + step;
      float& out = distances_[static_cast<std::size_t>(offset_in_leaf(v))];
      out = kHalfBandVoxels;
      if (near_pair_.empty()) return;
      const PointSet::Nearest found = near_pair_.nearest(place(v));
      if (found.distance > kReach) return;
      out = std::min(out, refined_distance(block_, place(v), closest_points_[static_cast<std::size_t>(found.number)]));
    });
  }

  const Block& block_;
  const std::vector<ClosestPoint>& closest_points_;
  std::array<float, Leaf::SIZE> distances_{};
  PointSet near_part_, near_pair_;
};

/// A leaf of the level set; nullptr where the surface is out of reach.
std::unique_ptr<Leaf> band_leaf(const openvdb::FloatTree& occupancy, const openvdb::Coord& corner, float voxel_mm) {
  const Block block(occupancy, corner);
  const std::vector<ClosestPoint> closest_points = closest_points_of(block);
  if (closest_points.empty()) return nullptr;
  const LeafDistances distances(block, closest_points);
  auto leaf = std::make_unique<Leaf>(corner, 0.0F, false);
  bool any = false;
  for_each_voxel(Vec3i::Constant(kSide), [&](const Vec3i& v) {
    const auto at = static_cast<openvdb::Index>(offset_in_leaf(v));
    const float distance = distances.at(at);
    const bool in = inside(block.at(v.x() + kMargin, v.y() + kMargin, v.z() + kMargin));
    leaf->setValueOnly(at, (in ? -distance : distance) * voxel_mm);
    if (distance < kHalfBandVoxels) leaf->setValueOn(at), any = true;
  });
  return any ? std::move(leaf) : nullptr;
}

/// Corners of the leaves that the surface can reach: leaves where the occupancy varies, and their neighbours.
std::vector<openvdb::Coord> leaves_in_reach(const openvdb::FloatTree& occupancy) {
  std::vector<openvdb::Coord> out;
  for (auto leaf = occupancy.cbeginLeaf(); leaf; ++leaf) {
    for_each_voxel(Vec3i::Constant(-1), Vec3i::Ones(), [&](const Vec3i& step) {
      out.push_back(leaf->origin().offsetBy(kSide * step.x(), kSide * step.y(), kSide * step.z()));
    });
  }
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace

openvdb::FloatGrid::Ptr narrow_band(const openvdb::FloatGrid& occupancy) {
  constexpr std::size_t kAtOnce = 1 << 14;
  const auto voxel_mm = static_cast<float>(occupancy.voxelSize()[0]);
  auto grid = make_float_grid(voxel_mm * kHalfBandVoxels);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->setTransform(occupancy.transform().copy());
  const openvdb::FloatTree& tree = occupancy.tree();
  for (auto tile = tree.cbeginValueAll(); tile; ++tile) {
    if (!tile.isTileValue() || !inside(*tile)) continue;
    const openvdb::CoordBBox box = tile.getBoundingBox();
    grid->tree().sparseFill(box, -voxel_mm * kHalfBandVoxels, false);
  }
  const std::vector<openvdb::Coord> corners = leaves_in_reach(tree);
  parallel_in_order<std::unique_ptr<Leaf>>(
      corners.size(), kAtOnce,
      [&](std::size_t i, std::unique_ptr<Leaf>& leaf) { leaf = band_leaf(tree, corners[i], voxel_mm); },
      [&](std::size_t i, std::unique_ptr<Leaf>& leaf) {
        if (leaf) {
          grid->tree().addLeaf(leaf.release());
        } else if (inside(tree.getValue(corners[i]))) {
          grid->tree().addTile(1, corners[i], -voxel_mm * kHalfBandVoxels, false);
        }
      });
  return grid;
}

}  // namespace reamsim

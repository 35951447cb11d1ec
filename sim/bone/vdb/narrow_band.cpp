#include "sim/bone/vdb/narrow_band.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/vdb_archive.h"
#include "sim/bone/voxmap/voxel_grid.h"

namespace reamsim {

namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;
using Point = Eigen::Vector3f;

constexpr int kSide = static_cast<int>(Leaf::DIM);
constexpr int kMargin = 4;  // voxels around a leaf in which its closest points lie
constexpr int kSamples = kSide + 2 * kMargin + 1;
constexpr int kCells = kSamples - 1;
constexpr int kRefinements = 3;
constexpr float kWithinCell = 0.9F;  // half a cell's diagonal: from the nearest point of a cell to the closest one

bool inside(float occupancy) {
  return occupancy >= 0.5F;
}

/// The occupancy of a leaf and its margin, by place: voxel centres from (-kMargin, -kMargin, -kMargin) on.
class Block {
 public:
  Block(const openvdb::FloatTree& occupancy, const openvdb::Coord& corner) : values_(kSamples * kSamples * kSamples) {
    for_each_voxel(Vec3i::Constant(-1), Vec3i::Ones(), [&](const Vec3i& step) {
      const openvdb::Coord from = corner.offsetBy(kSide * step.x(), kSide * step.y(), kSide * step.z());
      const Leaf* leaf = occupancy.probeConstLeaf(from);
      const float all = leaf == nullptr ? occupancy.getValue(from) : 0.0F;
      const Vec3i first = (kSide * step).cwiseMax(-kMargin),
                  last = (kSide * step.array() + kSide - 1).min(kSide + kMargin);
      for (int z = first.z(); z <= last.z(); ++z) {
        for (int y = first.y(); y <= last.y(); ++y) {
          for (int x = first.x(); x <= last.x(); ++x) {
            values_[place(x + kMargin, y + kMargin, z + kMargin)] =
                leaf == nullptr ? all : leaf->getValue(Leaf::coordToOffset({x, y, z}));
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

  /// Value, and its gradient, of the trilinear interpolation.
  float interpolate(const Point& p, Point& gradient) const {
    const Eigen::Array3f limited = p.array().max(0.0F).min(static_cast<float>(kCells) - 1e-3F);
    const Eigen::Array3i cell = limited.cast<int>();
    const Eigen::Array3f t = limited - cell.cast<float>(), u = 1.0F - t;
    std::array<float, 8> v{};
    for (int i = 0; i < 8; ++i) {
      v[static_cast<std::size_t>(i)] = at(cell.x() + (i & 1), cell.y() + (i >> 1 & 1), cell.z() + (i >> 2));
    }
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
  std::array<std::uint32_t, kSamples * kSamples> inside_{};  ///< of a row along x, a bit per sample
};

/// Moves a point to the surface along the gradient.
Point on_surface(const Block& block, const Point& p) {
  Point gradient;
  const float value = block.interpolate(p, gradient);
  const float steepness2 = gradient.squaredNorm();
  if (steepness2 < 1e-6F) return p;
  const Point step = (0.5F - value) / steepness2 * gradient;
  const float length = step.norm(), most = 0.5F;
  return length > most ? Point(p + most / length * step) : Point(p + step);
}

/// A point of the surface in every cell that it intersects, by component.
struct SurfacePoints {
  std::vector<float> x, y, z;
};

/// The mean of the points where the surface intersects the edges of a cell, moved to the surface.
Point point_in_cell(const Block& block, const Vec3i& cell) {
  int count = 0;
  Point sum = Point::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 4; ++i) {
      Vec3i begin = cell;
      begin[(axis + 1) % 3] += i & 1;
      begin[(axis + 2) % 3] += i >> 1;
      Vec3i end = begin;
      ++end[axis];
      const float a = block.at(begin.x(), begin.y(), begin.z()), b = block.at(end.x(), end.y(), end.z());
      if (inside(a) == inside(b)) continue;
      Point p = begin.cast<float>();
      p[axis] += (0.5F - a) / (b - a);
      sum += p;
      ++count;
    }
  }
  return on_surface(block, sum / static_cast<float>(count));
}

SurfacePoints surface_points(const Block& block) {
  SurfacePoints out;
  for (int z = 0; z < kCells; ++z) {
    for (int y = 0; y < kCells; ++y) {
      for (std::uint32_t rest = block.mixed_cells(y, z); rest != 0; rest &= rest - 1) {
        const Point p = point_in_cell(block, {std::countr_zero(rest), y, z});
        out.x.push_back(p.x());
        out.y.push_back(p.y());
        out.z.push_back(p.z());
      }
    }
  }
  return out;
}

/// Those of the points within the reach of a box of voxels.
SurfacePoints near_box(const SurfacePoints& points, const Point& first, const Point& last) {
  constexpr float kReach = kHalfBandVoxels + kWithinCell;
  const Eigen::Array3f low = first.array() - kReach, high = last.array() + kReach;
  SurfacePoints out;
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    const Eigen::Array3f p(points.x[i], points.y[i], points.z[i]);
    if ((p < low).any() || (p > high).any()) continue;
    out.x.push_back(points.x[i]);
    out.y.push_back(points.y[i]);
    out.z.push_back(points.z[i]);
  }
  return out;
}

/// The nearest of the points. Squared distance and number are compared as one integer, which the compiler vectorizes.
Point nearest(const SurfacePoints& points, const Point& p) {
  constexpr int kNumberBits = 12;  // there are at most 16³ cells
  static_assert(kCells * kCells * kCells <= 1 << kNumberBits);
  constexpr float kPerSquare = 1024;
  std::int32_t best = std::numeric_limits<std::int32_t>::max();
  const auto count = static_cast<std::int32_t>(points.x.size());
  for (std::int32_t i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const float dx = points.x[k] - p.x(), dy = points.y[k] - p.y(), dz = points.z[k] - p.z();
    const float square = (dx * dx + dy * dy + dz * dz) * kPerSquare;
    const std::int32_t key = static_cast<std::int32_t>(square) << kNumberBits | i;
    best = key < best ? key : best;
  }
  const auto k = static_cast<std::size_t>(best & ((1 << kNumberBits) - 1));
  return {points.x[k], points.y[k], points.z[k]};
}

/// Distance from the surface near `start`, voxels: steps to the surface and along it, to where the gradient leads to
/// `p`.
float refined_distance(const Block& block, const Point& p, Point start) {
  const float nearest = (p - start).norm();
  if (nearest > kHalfBandVoxels + kWithinCell) return kHalfBandVoxels;
  for (int i = 0; i < kRefinements; ++i) {
    Point gradient;
    const float value = block.interpolate(start, gradient);
    const float steepness2 = gradient.squaredNorm();
    if (steepness2 < 1e-6F) break;
    const Point to_p = p - start;
    const Point along = to_p - (to_p.dot(gradient) - (0.5F - value)) / steepness2 * gradient;
    const float length = along.norm();
    start += length > 1 ? Point(along / length) : along;
  }
  return std::min(nearest, (p - start).norm());
}

/// A leaf of the level set; nullptr where the surface is out of reach.
std::unique_ptr<Leaf> band_leaf(const openvdb::FloatTree& occupancy, const openvdb::Coord& corner, float voxel_mm) {
  const Block block(occupancy, corner);
  const SurfacePoints all = surface_points(block);
  if (all.x.empty()) return nullptr;
  auto leaf = std::make_unique<Leaf>(corner, 0.0F, false);
  bool any = false;
  constexpr int kPart = kSide / 2;
  for (int part = 0; part < 8; ++part) {
    const Vec3i first = kPart * Vec3i(part & 1, part >> 1 & 1, part >> 2);
    const auto place = [](const Vec3i& v) { return Point(v.cast<float>().array() + static_cast<float>(kMargin)); };
    const SurfacePoints points = near_box(all, place(first), place(first + Vec3i::Constant(kPart - 1)));
    for_each_voxel(first, first + Vec3i::Constant(kPart - 1), [&](const Vec3i& v) {
      const Point p = place(v);
      const bool in = inside(block.at(v.x() + kMargin, v.y() + kMargin, v.z() + kMargin));
      float distance = kHalfBandVoxels;
      if (!points.x.empty()) distance = std::min(distance, refined_distance(block, p, nearest(points, p)));
      const auto at = Leaf::coordToOffset({v.x(), v.y(), v.z()});
      leaf->setValueOnly(at, (in ? -distance : distance) * voxel_mm);
      if (distance < kHalfBandVoxels) leaf->setValueOn(at), any = true;
    });
  }
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
  out.erase(std::ranges::unique(out).begin(), out.end());
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
  std::vector<std::unique_ptr<Leaf>> leaves(std::min(kAtOnce, corners.size()));
  for (std::size_t first = 0; first < corners.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, corners.size() - first);
    parallel_items(count, [&](std::size_t i) { leaves[i] = band_leaf(tree, corners[first + i], voxel_mm); });
    for (std::size_t i = 0; i < count; ++i) {
      const openvdb::Coord& corner = corners[first + i];
      if (leaves[i]) {
        grid->tree().addLeaf(leaves[i].release());
      } else if (inside(tree.getValue(corner))) {
        grid->tree().addTile(1, corner, -voxel_mm * kHalfBandVoxels, false);
      }
    }
  }
  return grid;
}

}  // namespace reamsim

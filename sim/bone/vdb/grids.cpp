// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/vdb/grids.h"

#include <openvdb/tools/MeshToVolume.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "sim/base/parallel.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

namespace {

using Tree = openvdb::FloatTree;
using Leaf = Tree::LeafNodeType;

/// A region of one value, 8, 128 or 4096 voxels wide.
struct PlainTile {
  std::array<std::int32_t, 3> corner;
  std::uint32_t level;
  float value;
  std::uint32_t active;
};

struct PlainLeaf {
  std::array<std::int32_t, 3> corner;
  std::array<std::uint64_t, Leaf::NUM_VALUES / 64> active;
  std::array<float, Leaf::NUM_VALUES> value;
};

void put_metadata(ResultWriter& out, const openvdb::MetaMap& metadata) {
  std::ostringstream bytes;
  metadata.writeMeta(bytes);
  out.put(bytes.str());
}

void take_metadata(ResultReader& in, openvdb::MetaMap& metadata) {
  std::istringstream bytes(in.text());
  bytes.exceptions(std::ios::failbit | std::ios::badbit);  // OpenVDB does not check whether it reads anything
  try {
    metadata.readMeta(bytes);
  } catch (const std::exception&) {  // also a length that memory has no room for
    in.fail();
  }
}

/// A transform that is not linear cannot be handed back: the reader refuses it.
void put_transform(ResultWriter& out, const openvdb::math::Transform& transform) {
  out.put(transform.isLinear());
  if (!transform.isLinear()) return;
  const openvdb::math::Mat4d matrix = transform.baseMap()->getAffineMap()->getMat4();
  for (int i = 0; i < 16; ++i) out.put(matrix.asPointer()[i]);
}

openvdb::math::Transform::Ptr take_transform(ResultReader& in) {
  using openvdb::math::Transform;
  if (!in.take<bool>()) {
    return Transform::createFrustumTransform(openvdb::BBoxd({0, 0, 0}, {1, 1, 1}), 0.5, 1);
  }
  openvdb::math::Mat4d matrix;
  for (int i = 0; i < 16; ++i) {
    matrix.asPointer()[i] = in.take<double>();
    if (!std::isfinite(matrix.asPointer()[i])) in.fail();
  }
  try {
    return Transform::createLinearTransform(matrix);
  } catch (const openvdb::Exception&) {  // a singular matrix
    in.fail();
  }
}

void put_tiles(ResultWriter& out, const Tree& tree) {
  std::vector<PlainTile> tiles;
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (!tile.isValueOn() && tile.getValue() == tree.background()) continue;
    const openvdb::Coord c = tile.getCoord();
    tiles.push_back({{c.x(), c.y(), c.z()}, tile.getLevel(), tile.getValue(), tile.isValueOn() ? 1U : 0U});
  }
  out.put(tiles);
}

void put_leaves(ResultWriter& out, Tree& tree) {
  auto* place = out.array<PlainLeaf>(tree.leafCount());
  for (auto leaf = tree.beginLeaf(); leaf; ++leaf, ++place) {
    const openvdb::Coord c = leaf->origin();
    place->corner = {c.x(), c.y(), c.z()};
    for (openvdb::Index word = 0; word < place->active.size(); ++word) {
      place->active[word] = leaf->valueMask().getWord<std::uint64_t>(word);
    }
    std::copy_n(leaf->buffer().data(), Leaf::NUM_VALUES, place->value.begin());
    Leaf::Buffer none;
    leaf->swap(none);
  }
}

void add_tiles(ResultReader& in, Tree& tree) {
  for (const PlainTile& tile : in.take<std::vector<PlainTile>>()) {
    if (tile.level < 1 || tile.level >= Tree::DEPTH) in.fail();
    tree.addTile(tile.level, {tile.corner[0], tile.corner[1], tile.corner[2]}, tile.value, tile.active != 0);
  }
}

void add_leaves(ResultReader& in, Tree& tree) {
  in.for_each_in_array<PlainLeaf>([&](const PlainLeaf& plain) {
    auto leaf = std::make_unique<Leaf>(openvdb::Coord(plain.corner[0], plain.corner[1], plain.corner[2]));
    std::copy(plain.value.begin(), plain.value.end(), leaf->buffer().data());
    Leaf::NodeMaskType active;
    for (openvdb::Index word = 0; word < plain.active.size(); ++word) {
      active.getWord<std::uint64_t>(word) = plain.active[word];
    }
    leaf->setValueMask(active);
    tree.addLeaf(leaf.release());
  });
}

/// The distance of a mesh in spacings. `flags`: of openvdb::tools::meshToVolume().
openvdb::FloatGrid::Ptr distance_of(const TriangleMesh& mesh, const DistanceSampling& sampling, double outer,
                                    double inner, int flags) {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  for (const Vec3& vertex : mesh.vertices) {
    const Eigen::Vector3f index = ((vertex - sampling.first_mm) / sampling.spacing_mm).cast<float>();
    points.emplace_back(index.data());
  }
  for (const MeshTriangle& triangle : mesh.triangles) triangles.emplace_back(triangle.data());
  openvdb::initialize();
  // OpenVDB's library contains the instance for this adapter and interrupter; others take minutes to compile.
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> adapter(points, triangles);
  openvdb::util::NullInterrupter never;
  return openvdb::tools::meshToVolume<openvdb::FloatGrid>(never, adapter,
                                                          *openvdb::math::Transform::createLinearTransform(1.0),
                                                          static_cast<float>(outer), static_cast<float>(inner), flags);
}

/// Sets the sign of the distances in a brick of 8×8×8 samples; those beyond the band become constant.
void sign_leaf(Leaf& leaf, const InsideTest& inside, float outer, float inner) {
  for (openvdb::Index n = 0; n < Leaf::SIZE; ++n) {
    const openvdb::Coord at = leaf.offsetToGlobalCoord(n);
    const float away = leaf.isValueOn(n) ? std::abs(leaf.getValue(n)) : std::max(inner, outer);
    const bool is_inside = inside({at.x(), at.y(), at.z()});
    leaf.setValueOnly(n, is_inside ? -std::min(away, inner) : std::min(away, outer));
  }
}

}  // namespace

void put_grid(ResultWriter& out, openvdb::FloatGrid& grid) {
  out.put(grid.getName());
  put_metadata(out, grid);
  put_transform(out, grid.transform());
  out.put(grid.background());
  put_tiles(out, grid.tree());
  put_leaves(out, grid.tree());
}

openvdb::FloatGrid::Ptr take_grid(ResultReader& in) {
  const std::string name = in.text();
  const openvdb::FloatGrid::Ptr grid = make_float_grid(0);
  take_metadata(in, *grid);
  grid->setName(name);
  grid->setTransform(take_transform(in));
  grid->setTree(std::make_shared<Tree>(in.take<float>()));
  add_tiles(in, grid->tree());
  add_leaves(in, grid->tree());
  return grid;
}

openvdb::FloatGrid::Ptr make_float_grid(float background) {
  return openvdb::FloatGrid::create(background);
}

openvdb::BoolGrid::Ptr make_bool_grid(bool background) {
  return openvdb::BoolGrid::create(background);
}

openvdb::FloatGrid::Ptr mesh_distance(const TriangleMesh& mesh, const DistanceSampling& sampling) {
  return distance_of(mesh, sampling, sampling.outer_spacings, sampling.inner_spacings,
                     sampling.exact ? openvdb::tools::DISABLE_RENORMALIZATION : 0);
}

openvdb::FloatGrid::Ptr mesh_distance(const TriangleMesh& mesh, const DistanceSampling& sampling, const Vec3i& dims,
                                      const InsideTest& inside) {
  const auto outer = static_cast<float>(sampling.outer_spacings), inner = static_cast<float>(sampling.inner_spacings);
  const double band = std::max(sampling.outer_spacings, sampling.inner_spacings);
  const openvdb::FloatGrid::Ptr grid =
      distance_of(mesh, sampling, band, band, static_cast<int>(openvdb::tools::UNSIGNED_DISTANCE_FIELD));
  Tree& tree = grid->tree();
  tree.root().setBackground(outer, true);  // before the signs: it would change inner distances too
  std::vector<Leaf*> leaves;
  tree.getNodes(leaves);
  parallel_items(leaves.size(), [&](std::size_t n) { sign_leaf(*leaves[n], inside, outer, inner); });
  for_each_voxel(BrickLattice::over(dims).dims, [&](const Vec3i& brick) {  // leaves and bricks are the same blocks
    const Vec3i first = BrickLattice::kSide * brick;
    const openvdb::Coord corner = vdb_coord(first);
    if (tree.probeConstLeaf(corner) == nullptr && inside(first)) tree.addTile(1, corner, -inner, false);
  });
  return grid;
}

}  // namespace reamsim

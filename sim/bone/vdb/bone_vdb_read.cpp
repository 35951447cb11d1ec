// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <openvdb/openvdb.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <locale>
#include <sstream>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/vdb/grids.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

namespace {

template <class T>
std::optional<T> value_of(const openvdb::FloatGrid& grid, const char* name) {
  const auto entry = grid.getMetadata<openvdb::TypedMetadata<T>>(name);
  return entry ? std::optional<T>(entry->value()) : std::nullopt;
}

std::string text_in(const openvdb::FloatGrid& grid, const char* name) {
  return value_of<std::string>(grid, name).value_or("");
}

/// Edge length of a voxel, mm. Throws InputError unless voxels are cubes along the axes.
double checked_voxel(const std::string& path, const openvdb::FloatGrid& grid) {
  const std::string expected = "expected cubic voxels along the axes (a uniform scale and a translation)";
  if (!grid.transform().isLinear()) refuse_file(path, "a grid with a perspective transform", expected);
  const openvdb::math::Mat4d matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
  const double voxel_mm = matrix(0, 0);
  if (!std::isfinite(voxel_mm) || voxel_mm <= 0)
    refuse_file(path, "a grid that is mirrored, rotated or without size", expected);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const double wanted = row == column ? voxel_mm : 0;
      if (std::abs(matrix(row, column) - wanted) <= 1e-6 * voxel_mm) continue;
      refuse_file(path, row == column ? "a grid with non-cubic voxels" : "a grid that is rotated or sheared", expected);
    }
    if (!std::isfinite(matrix(3, row))) refuse_file(path, "a grid without a finite position", expected);
  }
  // As bone.voxel_mm, which the scenario of the results holds.
  if (voxel_mm < BoneSettings::kLeastVoxel_mm || voxel_mm > BoneSettings::kMostVoxel_mm) {
    refuse_file(path, fmt::format("voxels of {:g} mm", voxel_mm),
                fmt::format("expected {:g} to {:g} mm: is the grid in another unit?", BoneSettings::kLeastVoxel_mm,
                            BoneSettings::kMostVoxel_mm));
  }
  return voxel_mm;
}

/// A lattice and the grid coordinates of its voxel (0,0,0).
struct Placement {
  VoxelGrid lattice;
  openvdb::Coord first;
};

/// Upper bound of the fraction of a lattice of `voxels` in bricks with bone.
double bone_fraction(const openvdb::FloatGrid& density, double voxels) {
  constexpr double kAcross = 8;  // bricks that a leaf may overlap
  const double in_leaves = static_cast<double>(density.tree().leafCount()) * GradeBricks::kVoxels;
  const double in_tiles = static_cast<double>(density.activeVoxelCount());
  return std::min(1.0, (kAcross * in_leaves + in_tiles) / voxels);
}

/// Checks the size before anything is allocated.
Placement checked_placement(const std::string& path, const openvdb::FloatGrid& density) {
  const double voxel_mm = checked_voxel(path, density);
  const openvdb::CoordBBox active = density.evalActiveVoxelBoundingBox();
  if (active.empty()) refuse_file(path, "a grid \"density\" without active voxels", "expected bone");
  Eigen::Array3d extent;
  for (int axis = 0; axis < 3; ++axis) extent[axis] = 1.0 + active.max()[axis] - 1.0 * active.min()[axis];
  check_lattice(path, extent, voxel_mm, {.bone_fraction = bone_fraction(density, extent.prod())});

  const auto dims = value_of<openvdb::Vec3i>(density, vdb_keys::kDims);
  const auto origin = value_of<openvdb::Vec3d>(density, vdb_keys::kOrigin);
  const auto written_mm = value_of<double>(density, vdb_keys::kVoxel);
  if (!dims || !origin || !written_mm) {  // a grid of another program
    const openvdb::Coord size = active.dim();
    const openvdb::Vec3d corner = density.indexToWorld(active.min().asVec3d() - openvdb::Vec3d(0.5));
    return {{{size.x(), size.y(), size.z()}, voxel_mm, {corner.x(), corner.y(), corner.z()}}, active.min()};
  }
  const VoxelGrid lattice{{dims->x(), dims->y(), dims->z()}, *written_mm, {origin->x(), origin->y(), origin->z()}};
  const Eigen::Array3d size = lattice.dims.cast<double>().array();
  check_lattice(path, size, voxel_mm, {.bone_fraction = bone_fraction(density, size.prod())});
  const openvdb::Vec3d corner = density.indexToWorld(openvdb::Vec3d(-0.5));
  const double shift_mm = (lattice.origin_mm - Vec3(corner.x(), corner.y(), corner.z())).norm();
  const openvdb::CoordBBox whole({0, 0, 0}, {lattice.dims.x() - 1, lattice.dims.y() - 1, lattice.dims.z() - 1});
  const bool same = std::abs(lattice.voxel_mm - voxel_mm) <= 1e-6 * voxel_mm && shift_mm <= 1e-3 * voxel_mm;
  if ((lattice.dims.array() < 1).any() || !whole.isInside(active) || !same) {
    refuse_file(path, "a lattice in the metadata that contradicts the grid",
                "expected the metadata that reamsim wrote");
  }
  return {lattice, {}};
}

/// Returns the densest voxel, g/cm³.
double read_grades(const std::string& path, const openvdb::FloatGrid& density, const openvdb::Coord& first,
                   FilledVoxmap& voxmap) {
  double densest = 0;
  for (auto value = density.cbeginValueOn(); value; ++value) {
    if (!std::isfinite(*value)) refuse_file(path, "a density that is NaN or infinite", "expected g/cm^3");
    if (*value <= 0) continue;
    densest = std::max(densest, double{*value});
    const std::uint8_t grade =
        DensityMapping::grade_from_density(std::min(double{*value}, DensityMapping::kMaxDensity_g_cm3));
    openvdb::CoordBBox box;
    value.getBoundingBox(box);
    box.translate(openvdb::Coord() - first);
    for (auto c = box.begin(); c; ++c) {
      voxmap.grade.set({(*c).x(), (*c).y(), (*c).z()}, grade);
    }
  }
  return densest;
}

void read_fill(const std::string& path, const openvdb::FloatGrid& fill, const openvdb::Coord& first,
               FilledVoxmap& voxmap) {
  auto read = fill.getConstAccessor();
  for_each_bone_voxel(voxmap, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t) {
    const float value = read.getValue(first.offsetBy(voxel.x(), voxel.y(), voxel.z()));
    if (!(value >= 0 && value <= 1)) refuse_file(path, "a fill outside 0 to 1", "expected the fraction that is bone");
    voxmap.fill.set(voxel, static_cast<std::uint16_t>(std::lround(double{value} * FillBricks::kWhole)));
  });
}

/// The frame for messages and pictures; "unknown" unless it is short and printable.
std::string frame_name(const openvdb::FloatGrid& density) {
  const std::string name = value_of<std::string>(density, vdb_keys::kFrame).value_or("unknown");
  const bool plain =
      name.size() <= 64 && std::all_of(name.begin(), name.end(), [](unsigned char c) { return c >= 0x20 && c < 0x7F; });
  return plain ? name : "unknown";
}

DensityMapping mapping_of(const openvdb::FloatGrid& density) {
  const auto slope = value_of<double>(density, vdb_keys::kAshSlope);
  const auto offset = value_of<double>(density, vdb_keys::kAshOffset);
  const auto fraction = value_of<double>(density, vdb_keys::kAshFraction);
  const bool valid = slope && offset && fraction && *slope > 0 && *fraction > 0;
  return valid ? DensityMapping{*slope, *offset, *fraction} : DensityMapping{};
}

constexpr const char* kRemedy = "; remove it with a VDB tool, or write the file again";

/// Exactly N finite numbers.
template <std::size_t N>
bool read_numbers(const std::string& text, std::array<double, N>& numbers) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  for (double& number : numbers) {
    if (!(in >> number) || !std::isfinite(number)) return false;
  }
  std::string rest;
  return !(in >> rest);
}

/// The beginning of a text from a file.
std::string excerpt(const std::string& text) {
  return "found '" + printable(text.substr(0, 60)) + "'";
}

/// The glenoid frame from 16 numbers of a rigid transform, row by row; nullopt for an empty text.
std::optional<GlenoidFrame> parse_stored_glenoid(const std::string& path, const std::string& text) {
  if (text.empty()) return std::nullopt;
  const InputError wrong({path, 0, 0}, vdb_keys::kGlenoid, excerpt(text),
                         std::string("expected 16 numbers of a rigid transform, row by row") + kRemedy);
  std::array<double, 16> n{};
  if (!read_numbers(text, n)) throw wrong;
  GlenoidFrame frame;
  frame.bone_from_glenoid.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(n.data());
  const Mat3 turn = frame.bone_from_glenoid.linear();
  const Eigen::Vector4d last = frame.bone_from_glenoid.matrix().row(3);
  const bool rigid = (turn * turn.transpose()).isApprox(Mat3::Identity(), 1e-4) && turn.determinant() > 0 &&
                     last.isApprox(Eigen::Vector4d(0, 0, 0, 1), 1e-9);
  if (!rigid) throw wrong;
  return frame;
}

std::optional<LandmarkSettings> parse_stored_landmarks(const std::string& path, const std::string& text) {
  if (text.empty()) return std::nullopt;
  std::array<double, 9> n{};
  if (!read_numbers(text, n)) {
    throw InputError({path, 0, 0}, vdb_keys::kLandmarks, excerpt(text),
                     std::string("expected 9 numbers: glenoid centre, trigonum spinae, inferior angle") + kRemedy);
  }
  return LandmarkSettings{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]}};
}

/// Depth of the cortical layer (mm), its density and that below (g/cm³), for pictures; nullopt for any other text.
std::optional<BoneLayers> parse_stored_layers(const std::string& text) {
  std::array<double, 3> n{};
  if (!read_numbers(text, n) || n[0] < 0 || n[1] < 0 || n[2] < 0) return std::nullopt;
  return BoneLayers{n[0], n[1], n[2]};
}

BodySide checked_stored_side(const std::string& path, const std::string& text) {
  if (const auto side = from_name<BodySide>(text)) return *side;
  throw InputError({path, 0, 0}, vdb_keys::kSide, excerpt(text), std::string("expected left or right") + kRemedy);
}

StoredBone read_grids(const std::string& path) {
  const VdbGrids file = read_vdb_file(path, {vdb_keys::kDensity, vdb_keys::kFill});
  if (!file.grids.contains(vdb_keys::kDensity)) {
    refuse_file(path, "no grid \"density\" (found: " + file.names + ")", "expected a FloatGrid in g/cm^3");
  }
  const openvdb::FloatGrid::Ptr density = file.grids.at(vdb_keys::kDensity);
  const Placement placement = checked_placement(path, *density);
  StoredBone out;
  out.anatomy = {.glenoid = parse_stored_glenoid(path, text_in(*density, vdb_keys::kGlenoid)),
                 .landmarks = parse_stored_landmarks(path, text_in(*density, vdb_keys::kLandmarks)),
                 .side = checked_stored_side(path, text_in(*density, vdb_keys::kSide))};
  out.erosion = text_in(*density, vdb_keys::kErosion);
  out.voxmap = FilledVoxmap(placement.lattice);
  FilledVoxmap& voxmap = out.voxmap;
  voxmap.frame = frame_name(*density);
  voxmap.mapping = mapping_of(*density);
  voxmap.layers = parse_stored_layers(text_in(*density, vdb_keys::kLayers));
  out.densest_g_cm3 = read_grades(path, *density, placement.first, voxmap);
  if (const auto found = file.grids.find(vdb_keys::kFill); found != file.grids.end()) {
    const openvdb::FloatGrid::Ptr fill = found->second;
    if (fill->transform() != density->transform()) {
      refuse_file(path, "the grids \"fill\" and \"density\" have different transforms", "expected the same transform");
    }
    read_fill(path, *fill, placement.first, voxmap);
  }
  return out;
}

}  // namespace

StoredBone read_stored_bone(const std::string& path) {
  try {
    return read_grids(path);
  } catch (const std::bad_alloc&) {
    refuse_file(path, "the VDB does not fit into memory", "use a smaller grid");
  } catch (const openvdb::Exception&) {
    refuse_file(path, "a truncated or damaged VDB file", "expected a complete file");
  }
}

}  // namespace reamsim

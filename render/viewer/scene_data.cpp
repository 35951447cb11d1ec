// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The data of the 3D view: bone, reaming, reamer.
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "render/gl/camera.h"
#include "render/pictures/run_view.h"
#include "render/surface/solid_field.h"
#include "render/viewer/page.h"
#include "sim/anatomy/column_map.h"
#include "sim/base/error.h"
#include "sim/base/parallel.h"
#include "sim/record/recorder.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kMaxDensityCells = 2'500'000;
constexpr std::size_t kVertexBytes = BoneSurface::kStride * sizeof(float);  // of a vertex
constexpr int kNormalSteps = 254, kAttributeSteps = 255;

/// Appends the triangles of `indices` to `out`, simplified to at most `most`.
void simplify(const BoneSurface& surface, const std::vector<std::uint32_t>& indices, std::size_t most,
              std::vector<std::uint32_t>& out) {
  if (indices.size() <= 3 * most) {
    out.insert(out.end(), indices.begin(), indices.end());
    return;
  }
  constexpr float kAnyError = 1;  // only the number of triangles limits
  std::vector<std::uint32_t> kept(indices.size());
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), surface.vertices.data(), surface.count(),
                               kVertexBytes, 3 * most, kAnyError, meshopt_SimplifyLockBorder, nullptr));
  out.insert(out.end(), kept.begin(), kept.end());
}

/// Maps 0, −1, 1, −2 … to 0, 1, 2, 3 …
std::uint16_t zigzag(std::uint16_t difference) {
  return static_cast<std::uint16_t>((difference << 1) ^ (difference & 0x8000 ? 0xFFFF : 0));
}

void append_indices(const std::vector<std::uint32_t>& indices, std::vector<std::uint8_t>& out) {
  std::uint32_t next = 0;
  for (const std::uint32_t index : indices) {
    std::uint32_t below = next - index;
    if (below == 0) ++next;
    for (; below > 127; below >>= 7) out.push_back(static_cast<std::uint8_t>(128 | (below & 127)));
    out.push_back(static_cast<std::uint8_t>(below));
  }
}

constexpr int kSteps16 = 65535;

/// Appends value_of(i) of each i < `count` as numbers 0…`steps` from `low` to `low` + `size`, 16 bits each, as zigzag
/// differences to the one before: first all low bytes, then all high bytes.
template <class ValueOf>
void append_numbers16(std::size_t count, const ValueOf& value_of, double low, double size,
                      std::vector<std::uint8_t>& out, int steps = kSteps16) {
  std::vector<std::uint8_t> high;
  std::uint16_t before = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double fraction = (value_of(i) - low) / std::max(size, 1e-6);
    const auto now = static_cast<std::uint16_t>(std::lround(steps * std::clamp(fraction, 0.0, 1.0)));
    const std::uint16_t code = zigzag(static_cast<std::uint16_t>(now - before));
    before = now;
    out.push_back(static_cast<std::uint8_t>(code & 255));
    high.push_back(static_cast<std::uint8_t>(code >> 8));
  }
  out.insert(out.end(), high.begin(), high.end());
}

/// Whether mesh_bytes() writes a vertex as reamed.
bool counts_as_reamed(const float* vertex) {
  return std::lround(kAttributeSteps * std::clamp(double{vertex[BoneSurface::kReamed]}, 0.0, 1.0)) > 0;
}

/// A surface for the page's JSON: `vertices`, `triangles`, and mesh_bytes() compressed as `bytes`.
Json mesh_json(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm) {
  return {{"vertices", surface.count()},
          {"triangles", surface.indices.size() / 3},
          {"bytes", compressed_base64(mesh_bytes(surface, box, depth_max_mm))}};
}

/// The surface of the bone after the run.
BoneTiles last_tiles(const RunData& run) {
  BoneTiles out = run.unreamed_tiles();
  out.update(BoneFields(run.voxmap(), run.last_fill(), run.unreamed()),
             differing_bricks(run.unreamed().before, run.last_fill()));
  return out;
}

Json colors_json(const ColorMap& map, const Scale& scale) {
  Json json{{"stops", Json::array()}, {"max", scale.max}, {"step", scale.step}, {"ticks", Json::array()}};
  for (const Eigen::Vector3f& stop : map.stops) json["stops"].push_back(vector_json(stop));
  for (int tick = 0; tick < scale.ticks(); ++tick) json["ticks"].push_back(scale.label(tick));
  return json;
}

/// Directions are unit vectors; unknown ones are null.
Json view_json(const ViewTarget& target) {
  const Camera oblique = make_camera(CameraView::oblique, target, 1000, 1000);
  const Camera section = make_camera(CameraView::section, target, 1000, 1000);
  const Mat3 bone_from_eye = oblique.eye_from_bone.linear().transpose();
  return {{"focus_mm", vector_json(target.focus_mm)},
          {"reach_mm", short_number(target.radius_mm)},
          {"height_mm", short_number(1000 * oblique.mm_per_px)},
          {"towards_viewer", vector_json(bone_from_eye.col(2))},
          {"outward", vector_json(target.outward)},
          {"superior", vector_json(target.superior)},
          {"anterior", target.anterior ? vector_json(*target.anterior) : Json()},
          {"anatomical", target.anatomical},
          {"axis", vector_json(target.bone_from_tool.linear().col(2))},
          {"axis_point_mm", vector_json(target.bone_from_tool.translation())},
          {"front", vector_json(-section.cut_plane->head<3>())}};
}

constexpr int kPadding_cells = 2;  // extrapolated into the air

/// Sets air cells next to bone to the mean of their bone neighbours.
void extrapolate(const BrickLattice& cells, std::vector<std::uint8_t>& grades) {
  const std::vector<std::uint8_t> before = grades;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i] != 0) continue;
    int sum = 0, count = 0;
    for (int side = 0; side < 6; ++side) {
      const Vec3i near = cells.coord(i) + (side % 2 == 0 ? 1 : -1) * Vec3i::Unit(side / 2);
      if (!cells.contains(near)) continue;
      const int grade = before[cells.index(near)];
      sum += grade;
      count += grade != 0 ? 1 : 0;
    }
    if (count > 0) grades[i] = static_cast<std::uint8_t>((sum + count / 2) / count);
  }
}

constexpr std::size_t kMaxStates = 12;
constexpr double kStep_voxels = 0.5;

/// The rays along which bone was removed from the reamed vertices of a surface.
struct Columns {
  std::vector<Vec3> feet;
  std::vector<std::pair<std::size_t, std::size_t>> edges;  ///< of the surface, between these vertices
  Vec3 axis = Vec3::UnitZ();
  double length_mm = 0;
};

Columns columns_over(const BoneSurface& surface, const Vec3& axis, double voxel_mm) {
  Columns out{.feet = {}, .edges = {}, .axis = axis, .length_mm = 1.5 * surface.deepest_mm + 2 * voxel_mm};
  constexpr std::size_t kNone = -1;
  std::vector<std::size_t> slots(surface.count(), kNone);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (!counts_as_reamed(surface.position_mm(i).data())) continue;
    slots[i] = out.feet.size();
    out.feet.push_back(surface.position_mm(i).cast<double>());
  }
  for (std::size_t i = 0; i < surface.indices.size(); ++i) {
    // Inner edges belong to two triangles that pass them in opposite directions.
    const std::size_t from = slots[surface.indices[i]], to = slots[surface.indices[i % 3 == 2 ? i - 2 : i + 1]];
    if (from != kNone && to != kNone && from < to) out.edges.emplace_back(from, to);
  }
  return out;
}

/// Averages neighbours that differ by less than a voxel: the steps of whole voxels go, the edges of the tool stay.
std::vector<double> smoothed(std::vector<double> heights_mm, const Columns& columns, double voxel_mm) {
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> sums = heights_mm;
    std::vector<int> counts(sums.size(), 1);
    for (const auto& [a, b] : columns.edges) {
      if (std::abs(heights_mm[a] - heights_mm[b]) > voxel_mm) continue;
      sums[a] += heights_mm[b];
      sums[b] += heights_mm[a];
      ++counts[a];
      ++counts[b];
    }
    for (std::size_t i = 0; i < sums.size(); ++i) heights_mm[i] = sums[i] / counts[i];
  }
  return heights_mm;
}

/// Bone in each column, mm.
std::vector<double> bone_in(const Columns& columns, const Voxmap& voxmap, const FillBricks& fill) {
  std::vector<double> out(columns.feet.size());
  const double step_mm = kStep_voxels * voxmap.grid.voxel_mm;
  parallel_items(out.size(), [&](std::size_t i) {
    BoneFractions fractions({voxmap, fill, fill}, 0);
    for (double s = -voxmap.grid.voxel_mm; s < columns.length_mm; s += step_mm) {
      out[i] += step_mm * fractions.at(columns.feet[i] + s * columns.axis).after;
    }
  });
  return out;
}

/// The reaming between the two surfaces of bone_data(): at each of `time_s`, how much bone stood over each vertex of
/// `after` that counts_as_reamed() along the axis of the tool, 0…`most_mm`, as of append_numbers16(). null without
/// snapshots or reamed vertices. Throws as apply_snapshot() does.
Json reaming_data(const RunData& run, const BoneSurface& after) {
  const std::vector<std::int64_t>& frames = run.inputs().frames;
  const Voxmap& voxmap = run.voxmap();
  const Columns columns = columns_over(after, run.target().bone_from_tool.linear().col(2), voxmap.grid.voxel_mm);
  if (frames.size() < 2 || columns.feet.empty()) return nullptr;
  const FillBricks& last = run.last_fill();
  const std::vector<double> last_mm = bone_in(columns, voxmap, last);
  FillBricks fill = fill_at(run.inputs(), frames.front());
  Json times = Json::array();
  std::vector<std::vector<double>> states;
  std::size_t applied = 0;
  for (const std::size_t chosen : evenly_spaced(frames.size(), kMaxStates)) {
    while (applied < chosen) apply_snapshot(run.dir(), frames[++applied], fill);
    times.push_back(short_number(run.row_of(frames[chosen]).time_s));
    std::vector<double> heights_mm =  // over the final surface
        differing_bricks(fill, last).empty() ? last_mm : bone_in(columns, voxmap, fill);
    for (std::size_t i = 0; i < last_mm.size(); ++i) heights_mm[i] -= last_mm[i];
    states.push_back(smoothed(std::move(heights_mm), columns, voxmap.grid.voxel_mm));
  }
  double most_mm = 0;
  for (const auto& state : states) most_mm = std::max(most_mm, *std::ranges::max_element(state));
  std::vector<std::uint8_t> bytes;
  for (const auto& state : states) {
    append_numbers16(
        state.size(), [&](std::size_t i) { return state[i]; }, 0, most_mm, bytes);
  }
  return {{"time_s", std::move(times)},
          {"vertices", columns.feet.size()},
          {"most_mm", most_mm},
          {"bytes", compressed_base64(bytes)}};
}

constexpr std::size_t kMaxToolTriangles = 12'000;

/// The tool with shared vertices, as a surface without attributes: zeros take no room when compressed.
BoneSurface tool_surface(const TriangleMesh& mesh) {
  const ToolSurface split = make_tool_surface(mesh);
  const std::size_t corners = split.indices.size();
  constexpr std::size_t kBytes = ToolSurface::kStride * sizeof(float);
  std::vector<std::uint32_t> remap(corners);
  const std::size_t count =
      meshopt_generateVertexRemap(remap.data(), nullptr, corners, split.vertices.data(), corners, kBytes);
  BoneSurface out;
  out.vertices.resize(count * BoneSurface::kStride);
  for (std::size_t corner = 0; corner < corners; ++corner) {
    for (std::size_t part = 0; part < ToolSurface::kStride; ++part) {
      out.vertices[remap[corner] * BoneSurface::kStride + part] = split.vertices[corner * ToolSurface::kStride + part];
    }
  }
  out.indices = std::move(remap);
  return out;
}

/// `poses` of tool_data().
Json poses_json(const ForceLog& log, const std::vector<std::size_t>& rows) {
  Aabb box = Aabb::none();
  for (const std::size_t row : rows) box.extend(log.rows[row].pose.position_mm);
  std::vector<std::uint8_t> bytes;
  const auto append = [&](double low, double size, const auto& number_of) {
    const auto value_of = [&](std::size_t i) { return number_of(log.rows[rows[i]].pose); };
    append_numbers16(rows.size(), value_of, low, size, bytes);
  };
  for (int axis = 0; axis < 3; ++axis) {
    append(box.min[axis], box.max[axis] - box.min[axis], [&](const ToolPose& pose) { return pose.position_mm[axis]; });
  }
  for (int part = 0; part < 4; ++part) {
    append(-1, 2, [&](const ToolPose& pose) { return pose.orientation.coeffs()[part]; });
  }
  constexpr double kTurn = 2 * std::numbers::pi;
  append(0, kTurn,
         [&](const ToolPose& pose) { return pose.spin_angle_rad - kTurn * std::floor(pose.spin_angle_rad / kTurn); });
  return {{"count", rows.size()}, {"box_mm", box_json(box.min, box.max)}, {"bytes", compressed_base64(bytes)}};
}

}  // namespace

BoneSurface simplified(const BoneSurface& surface, const MeshBudget& budget) {
  std::vector<std::uint32_t> unreamed, reamed;
  const auto is_reamed = [&](std::uint32_t vertex) {
    return surface.vertices[vertex * BoneSurface::kStride + BoneSurface::kReamed] > 0;
  };
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    const auto triangle = std::span(surface.indices).subspan(i, 3);
    auto& part = std::ranges::any_of(triangle, is_reamed) ? reamed : unreamed;
    part.insert(part.end(), triangle.begin(), triangle.end());
  }
  BoneSurface out;
  out.deepest_mm = surface.deepest_mm;
  simplify(surface, unreamed, budget.unreamed_triangles, out.indices);
  simplify(surface, reamed, budget.reamed_triangles, out.indices);
  if (out.indices.empty()) return out;
  meshopt_optimizeVertexCache(out.indices.data(), out.indices.data(), out.indices.size(), surface.count());
  out.vertices.resize(surface.vertices.size());
  const std::size_t used = meshopt_optimizeVertexFetch(out.vertices.data(), out.indices.data(), out.indices.size(),
                                                       surface.vertices.data(), surface.count(), kVertexBytes);
  out.vertices.resize(used * BoneSurface::kStride);
  return out;
}

std::vector<std::uint8_t> mesh_bytes(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm) {
  std::vector<std::uint8_t> out;
  const auto append = [&](std::size_t component, double low, double size, int steps) {
    const auto value_of = [&](std::size_t i) { return double{surface.vertices[i * BoneSurface::kStride + component]}; };
    append_numbers16(surface.count(), value_of, low, size, out, steps);
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    append(axis, box.min()[static_cast<int>(axis)], box.sizes()[static_cast<int>(axis)], kSteps16);
  }
  append(BoneSurface::kDepth, 0, depth_max_mm, kSteps16);
  for (std::size_t axis = 0; axis < 3; ++axis) append(BoneSurface::kNormal + axis, -1, 2, kNormalSteps);
  append(BoneSurface::kReamed, 0, 1, kAttributeSteps);
  append(BoneSurface::kDensity, 0, DensityMapping::kMaxDensity_g_cm3, kAttributeSteps);
  append(BoneSurface::kAccessibility, 0, 1, kAttributeSteps);
  append_indices(surface.indices, out);
  return out;
}

Eigen::AlignedBox3f bounds_of(const BoneSurface& surface) {
  Eigen::AlignedBox3f box;
  for (std::size_t i = 0; i < surface.count(); ++i) box.extend(surface.position_mm(i));
  return box;
}

DensityVolume density_volume(const Voxmap& voxmap, std::int64_t most_cells) {
  const VoxelBox bone = bone_extent(voxmap);
  if (bone.empty()) throw InputError({"reamed.vdb", 0, 0}, "density", "contains no bone", "the bone of a run");
  DensityVolume out;
  const auto cells_of = [&](int n) -> BrickLattice { return {(bone.size().array() + n - 1) / n + 2 * kPadding_cells}; };
  const auto is_coarsest = [](const BrickLattice& cells) { return cells.dims.maxCoeff() <= 1 + 2 * kPadding_cells; };
  int n = 1;  // voxels along an edge of a cell
  while (static_cast<std::int64_t>(cells_of(n).count()) > most_cells && !is_coarsest(cells_of(n))) ++n;
  const BrickLattice cells = cells_of(n);
  out.dims = cells.dims;
  out.cell_mm = n * voxmap.grid.voxel_mm;
  const Vec3i first = bone.first - Vec3i::Constant(n * kPadding_cells);
  out.origin_mm = voxmap.grid.origin_mm + voxmap.grid.voxel_mm * first.cast<double>();
  std::vector<std::uint32_t> sums(cells.count()), counts(sums.size());
  const FillBricks whole(voxmap.grid.dims);
  for_each_bone_voxel({voxmap, whole}, [&](const Vec3i& voxel, std::uint8_t grade, std::uint16_t) {
    const std::size_t cell = cells.index((voxel - first) / n);
    sums[cell] += grade;
    ++counts[cell];
  });
  out.grades.resize(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (counts[i] > 0) out.grades[i] = static_cast<std::uint8_t>((sums[i] + counts[i] / 2) / counts[i]);
  }
  for (int round = 0; round < kPadding_cells; ++round) extrapolate(cells, out.grades);
  return out;
}

Json bone_data(const RunData& run, const RenderSettings& settings) {
  const Voxmap& voxmap = run.voxmap();
  const BoneSurface after = simplified(last_tiles(run).whole(), MeshBudget());
  const BoneSurface before = simplified(run.unreamed_tiles().whole(), MeshBudget());
  const Scale depth = depth_scale(run, settings.depth_max_mm);
  const Eigen::AlignedBox3f box = bounds_of(before).merged(bounds_of(after));
  const DensityVolume volume = density_volume(voxmap, kMaxDensityCells);
  return {{"look", view_json(run.target())},
          {"box_mm", box_json(box.min(), box.max())},
          {"grade_per_g_cm3", DensityMapping::kMaxGrade / DensityMapping::kMaxDensity_g_cm3},
          {"deepest_mm", short_number(after.deepest_mm)},
          {"depth_colors", colors_json(depth_colors(), depth)},
          {"density_colors", colors_json(density_colors(), scale_up_to(DensityMapping::kMaxDensity_g_cm3))},
          {"before", mesh_json(before, box, depth.max)},
          {"after", mesh_json(after, box, depth.max)},
          {"reaming", reaming_data(run, after)},
          {"density",
           {{"dims", {volume.dims.x(), volume.dims.y(), volume.dims.z()}},
            {"origin_mm", vector_json(volume.origin_mm)},
            {"cell_mm", volume.cell_mm},
            {"bytes", compressed_base64(volume.grades)}}}};
}

Json tool_data(const std::vector<ToolPass>& passes, const ForceLog& log, const RenderSettings& settings) {
  const std::vector<std::size_t> rows = shown_rows(log.rows);
  Json tools = Json::array();
  for (int pass = 1; const ToolPass& each : passes) {
    if (each.tool.triangles.empty()) return nullptr;
    const BoneSurface surface = simplified(tool_surface(each.tool), {.unreamed_triangles = kMaxToolTriangles});
    const Eigen::AlignedBox3f box = bounds_of(surface);
    const auto first = std::ranges::find_if(rows, [&](std::size_t row) { return log.rows[row].pass >= pass; });
    tools.push_back({{"row", first - rows.begin()},
                     {"box_mm", box_json(box.min(), box.max())},
                     {"mesh", mesh_json(surface, box, 1)}});
    ++pass;
  }
  return {{"shown", settings.tool},
          {"look", name_of(settings.tool_material)},
          {"passes", std::move(tools)},
          {"poses", poses_json(log, rows)}};
}

}  // namespace reamsim

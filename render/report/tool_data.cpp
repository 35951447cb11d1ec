// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/report/markup.h"
#include "render/report/mesh_data.h"
#include "render/report/page_data.h"
#include "render/surface/tool_surface.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

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

/// The poses as bytes: x, y, z over `box`, the quaternion's x, y, z, w over −1…1, and the spin angle over a turn.
std::vector<std::uint8_t> pose_bytes(const ForceLog& log, const std::vector<std::size_t>& rows, const Aabb& box) {
  std::vector<std::uint8_t> out;
  const auto append = [&](double low, double size, const auto& number_of) {
    std::vector<double> numbers;
    for (const std::size_t row : rows) numbers.push_back(number_of(log.rows[row].pose));
    append_numbers16(numbers, low, size, out);
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
  return out;
}

Json poses_json(const ForceLog& log) {
  const std::vector<std::size_t> rows = shown_rows(log.rows);
  Aabb box = Aabb::none();
  for (const std::size_t row : rows) box.extend(log.rows[row].pose.position_mm);
  return {{"count", rows.size()},
          {"box_mm", box_json(box.min, box.max)},
          {"bytes", compressed_base64(pose_bytes(log, rows, box))}};
}

/// The first of the shown rows that has the tool of this pass.
std::size_t first_row(const ForceLog& log, int pass) {
  const std::vector<std::size_t> rows = shown_rows(log.rows);
  const auto found = std::ranges::find_if(rows, [&](std::size_t row) { return log.rows[row].pass >= pass; });
  return static_cast<std::size_t>(found - rows.begin());
}

Json pass_json(const TriangleMesh& tool, std::size_t row) {
  const BoneSurface surface = simplified(tool_surface(tool), {.unreamed_triangles = kMaxToolTriangles});
  const Eigen::AlignedBox3f box = bounds_of(surface);
  return {{"row", row}, {"box_mm", box_json(box.min(), box.max())}, {"mesh", mesh_json(surface, box, 1)}};
}

}  // namespace

Json tool_data(const std::vector<ToolPass>& passes, const ForceLog& log, const RenderSettings& settings) {
  Json tools = Json::array();
  for (std::size_t i = 0; i < passes.size(); ++i) {
    if (passes[i].tool.triangles.empty()) return nullptr;
    tools.push_back(pass_json(passes[i].tool, first_row(log, static_cast<int>(i) + 1)));
  }
  return {{"shown", settings.tool},
          {"look", name_of(settings.tool_material)},
          {"passes", std::move(tools)},
          {"poses", poses_json(log)}};
}

}  // namespace reamsim

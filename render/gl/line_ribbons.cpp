// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/line_ribbons.h"

namespace reamsim {
namespace {

/// Eye coordinates: unit vector from a point towards the viewer, and the millimetres of a pixel there.
Vec3 view_at(const Camera& camera, const Vec3& eye) {
  return camera.eye_mm ? Vec3((Vec3(0, 0, *camera.eye_mm) - eye).normalized()) : Vec3(Vec3::UnitZ());
}

double mm_per_px_at(const Camera& camera, const Vec3& eye) {
  return camera.mm_per_px * (camera.eye_mm ? 1 - eye.z() / *camera.eye_mm : 1);
}

}  // namespace

LineRibbons make_line_ribbons(const std::vector<SurfaceLine>& lines, const Camera& camera, double width_px,
                              double lift_mm) {
  LineRibbons out;
  const Rigid bone_from_eye = camera.eye_from_bone.inverse();
  for (const SurfaceLine& line : lines) {
    const std::size_t count = line.points_mm.size();
    const auto first = static_cast<std::uint32_t>(out.vertices.size() / 5);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 eye = camera.eye_from_bone * line.points_mm[i];
      const Vec3 before = camera.eye_from_bone * line.points_mm[(i + count - 1) % count];
      const Vec3 after = camera.eye_from_bone * line.points_mm[(i + 1) % count];
      const Vec3 view = view_at(camera, eye);
      const Vec3 side = (after - before).cross(view).normalized();  // 0 where the line points at the viewer
      for (const double across : {-1.0, 1.0}) {
        const Vec3 corner =
            bone_from_eye * (eye + across * 0.5 * width_px * mm_per_px_at(camera, eye) * side + lift_mm * view);
        for (const double value : corner) out.vertices.push_back(static_cast<float>(value));
        out.vertices.push_back(static_cast<float>(across));
        out.vertices.push_back(line.light ? 1.0F : 0.0F);
      }
      const auto a = static_cast<std::uint32_t>(2 * i), b = static_cast<std::uint32_t>(2 * ((i + 1) % count));
      for (const std::uint32_t corner : {a, a + 1, b, b, a + 1, b + 1}) out.indices.push_back(first + corner);
    }
  }
  return out;
}

}  // namespace reamsim

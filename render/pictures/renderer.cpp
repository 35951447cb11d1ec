// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "render/pictures/contour_lines.h"
#include "sim/record/recorder.h"

namespace reamsim {
namespace {

constexpr float kReamedFrom = 0.5F;      // certainty of removal
constexpr int kBorder = 3;               // columns around the reamed face
constexpr double kMaxColumns = 4e6;      // against a huge face with small voxels
constexpr double kClear_voxels = 2;      // bone this near the face does not hide a line
constexpr double kCutMargin_mm = 0.8;    // nearer to the cut a line has no number
constexpr std::size_t kHeightReach = 4;  // points of a line over which its height is smoothed, to each side
constexpr int kHeightRounds = 2;
constexpr std::size_t kTestedPoints = 4;  // one of so many points of a line, two voxels apart, is tested for hiding
constexpr double kMaxHiding_mm = 60;      // bone farther in front of the face is not looked for

/// A vertex in the map, mm, with its depth and the certainty of its removal.
struct MapVertex {
  Vec3 place;
  double depth_mm;
  double reamed;
};
using MapTriangle = std::array<MapVertex, 3>;

/// The face on a raster: the depth and height of its highest point in each column.
struct FaceRaster {
  RasterField depth_mm;
  RasterField height_mm;
  std::vector<std::uint8_t> reamed;
};

/// The triangles with a reamed corner.
std::vector<MapTriangle> reamed_triangles(const BoneTiles::Surfaces& tiles, const Rigid& map_from_bone) {
  std::vector<MapTriangle> out;
  for (const auto& surface : tiles) {
    const BoneSurface& tile = *surface;
    const auto vertex = [&](std::size_t i) { return tile.vertices.data() + tile.indices[i] * BoneSurface::kStride; };
    const auto mapped = [&](std::size_t i) -> MapVertex {
      const Vec3 bone = Eigen::Map<const Eigen::Vector3f>{vertex(i)}.cast<double>();
      return {map_from_bone * bone, vertex(i)[BoneSurface::kDepth], vertex(i)[BoneSurface::kReamed]};
    };
    for (std::size_t i = 0; i + 2 < tile.indices.size(); i += 3) {
      const auto reamed = [&](std::size_t k) { return vertex(i + k)[BoneSurface::kReamed] > kReamedFrom; };
      if (reamed(0) || reamed(1) || reamed(2)) out.push_back({mapped(i), mapped(i + 1), mapped(i + 2)});
    }
  }
  return out;
}

/// Enters the columns below a triangle where it is the highest so far.
void rasterize(const MapTriangle& t, FaceRaster& face) {
  const Vec2 a = t[0].place.head<2>(), b = t[1].place.head<2>(), c = t[2].place.head<2>();
  const double twice_area = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  if (twice_area <= 1e-12) return;  // seen from below
  const RasterField& raster = face.depth_mm;
  const Vec2 low = (a.cwiseMin(b).cwiseMin(c) - raster.corner_mm) / raster.spacing_mm;
  const Vec2 high = (a.cwiseMax(b).cwiseMax(c) - raster.corner_mm) / raster.spacing_mm;
  for (int j = static_cast<int>(std::ceil(low.y())); j <= static_cast<int>(std::floor(high.y())); ++j) {
    for (int i = static_cast<int>(std::ceil(low.x())); i <= static_cast<int>(std::floor(high.x())); ++i) {
      const Vec2 p = raster.place_mm(i, j);
      const double wb = ((p - a).x() * (c - a).y() - (p - a).y() * (c - a).x()) / twice_area;
      const double wc = ((b - a).x() * (p - a).y() - (b - a).y() * (p - a).x()) / twice_area;
      const double wa = 1 - wb - wc;
      if (std::min({wa, wb, wc}) < -1e-9) continue;
      const std::size_t n = raster.raster.index(i, j);
      const double height = wa * t[0].place.z() + wb * t[1].place.z() + wc * t[2].place.z();
      if (height <= face.height_mm.values[n]) continue;
      face.height_mm.values[n] = height;
      face.depth_mm.values[n] = wa * t[0].depth_mm + wb * t[1].depth_mm + wc * t[2].depth_mm;
      face.reamed[n] = wa * t[0].reamed + wb * t[1].reamed + wc * t[2].reamed > double{kReamedFrom} ? 1 : 0;
    }
  }
}

FaceRaster rasterized(const BoneTiles::Surfaces& tiles, const Rigid& map_from_bone, double spacing_mm) {
  const std::vector<MapTriangle> triangles = reamed_triangles(tiles, map_from_bone);
  Eigen::AlignedBox2d bounds;
  for (const MapTriangle& triangle : triangles) {
    for (const MapVertex& v : triangle) bounds.extend(Vec2(v.place.head<2>()));
  }
  FaceRaster out;
  if (bounds.isEmpty()) return out;
  const double spacing = std::max(spacing_mm, std::sqrt(bounds.volume() / kMaxColumns));
  RasterField& field = out.depth_mm;
  field.spacing_mm = spacing;
  field.corner_mm = bounds.min() - Vec2::Constant(kBorder * spacing);
  const Vec2 size = bounds.sizes() / spacing;
  field.raster = {static_cast<int>(std::ceil(size.x())) + 2 * kBorder + 1,
                  static_cast<int>(std::ceil(size.y())) + 2 * kBorder + 1};
  field.values.assign(field.raster.count(), 0);
  out.height_mm = field;
  out.height_mm.values.assign(field.raster.count(), -std::numeric_limits<double>::infinity());
  out.reamed.assign(field.raster.count(), 0);
  for (const MapTriangle& triangle : triangles) rasterize(triangle, out);
  return out;
}

bool is_kept(const Vec3& point_mm, const Camera& camera) {
  return !camera.cut_plane || camera.cut_plane->dot(point_mm.homogeneous()) >= 0;
}

/// Is there no bone in front of a point on the face?
bool is_visible(const Vec3& point_mm, const Camera& camera, const BoneFields& bone) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const Vec3 way = camera.eye_from_bone.linear().transpose() * camera.towards_viewer(camera.eye_from_bone * point_mm);
  std::vector<Vec3> points;
  for (double mm = kClear_voxels * grid.voxel_mm; mm < kMaxHiding_mm; mm += grid.voxel_mm) {
    const Vec3 p = point_mm + mm * way;
    if (!is_kept(p, camera)) break;
    points.emplace_back((p - grid.origin_mm) / grid.voxel_mm - Vec3::Constant(0.5));
  }
  const std::vector<float> fields = bone.solid.at(points);
  return std::ranges::none_of(fields, [](float field) { return field < 0; });
}

/// Smooths the heights of a closed line. On a steep wall those of neighbouring columns differ by many voxels.
void smooth_heights(std::vector<Vec3>& line) {
  const std::size_t count = line.size();
  if (count <= 2 * kHeightReach) return;
  for (int round = 0; round < kHeightRounds; ++round) {
    std::vector<double> heights(count, 0);
    for (std::size_t n = 0; n < count; ++n) {
      for (std::size_t k = 0; k <= 2 * kHeightReach; ++k)
        heights[n] += line[(n + count + k - kHeightReach) % count].z();
    }
    for (std::size_t n = 0; n < count; ++n) line[n].z() = heights[n] / (2 * kHeightReach + 1);
  }
}

/// Marks the columns around the points of lines.
std::vector<std::uint8_t> columns_at(const std::vector<ContourLine>& lines, const RasterField& field) {
  std::vector<std::uint8_t> out(field.raster.count(), 0);
  for (const ContourLine& line : lines) {
    for (const Vec2& p : line.points_mm) {
      const Vec2 at = ((p - field.corner_mm) / field.spacing_mm).array().round();
      const int i = static_cast<int>(at.x()), j = static_cast<int>(at.y());
      if (field.raster.contains(i, j))
        field.raster.for_each_near(field.raster.index(i, j), 1, [&](std::size_t n) { out[n] = 1; });
    }
  }
  return out;
}

/// The contours of the depth of a reamed surface at the ticks of a legend, as in the depth map: the depth of the
/// vertices is sampled on a raster across +z of the map, from above, smoothed, and its lines are laid on the face.
std::vector<SurfaceLine> face_contours(const BoneTiles::Surfaces& tiles, const Rigid& map_from_bone, double spacing_mm,
                                       const Scale& scale) {
  const FaceRaster face = rasterized(tiles, map_from_bone, spacing_mm);
  std::vector<SurfaceLine> out;
  if (std::ranges::count(face.reamed, std::uint8_t{1}) == 0) return out;
  const std::vector<ContourLine> lines = depth_contours(signed_depth(face.depth_mm, face.reamed), scale);
  const RasterField height = local_fit(face.height_mm, face.reamed, columns_at(lines, face.height_mm));
  const Rigid bone_from_map = map_from_bone.inverse();
  for (const ContourLine& line : lines) {
    SurfaceLine& contour = out.emplace_back(SurfaceLine{{}, contour_style(line.value, scale).light, line.value});
    for (const Vec2& p : line.points_mm) {
      const double z = height.at(p);
      if (std::isfinite(z)) contour.points_mm.emplace_back(p.x(), p.y(), z);
    }
    smooth_heights(contour.points_mm);
    for (Vec3& p : contour.points_mm) p = bone_from_map * p;
  }
  return out;
}

}  // namespace

Renderer::Renderer(const RunView& view)
    : view_(view),
      context_(make_context(view.settings().context, warning_)),
      fields_(view.run().voxmap(), fill_at(view.run().inputs(), view.frames().front()), view.run().unreamed()),
      tiles_(view.run().unreamed_tiles()),
      scene_(context_->gl()) {
  tiles_.update(fields_, differing_bricks(view.run().unreamed().before, fields_.fill));
  for (const ToolPass& pass : view.run().inputs().passes) scene_.add_tool(make_tool_surface(pass.tool));
  std::vector<std::size_t> all(tiles_.surfaces().size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  scene_.set_bone(tiles_.surfaces(), all);
}

void Renderer::advance_to(std::int64_t frame) {
  const std::vector<std::int64_t>& frames = view_.frames();
  while (shown_ + 1 < frames.size() && frames[shown_ + 1] <= frame) {
    apply_snapshot(view_.run().dir(), frames[++shown_], fields_.fill);
  }
  update_bone();
}

void Renderer::show(const FillBricks& fill) {
  fields_.fill = fill;
  update_bone();
}

void Renderer::update_bone() {
  const auto changed = tiles_.update(fields_, fields_.update());
  scene_.set_bone(tiles_.surfaces(), changed);
  contours_ =
      face_contours(tiles_.surfaces(), view_.map_from_bone(), fields_.voxmap.grid.voxel_mm, view_.depth_scale());
}

std::vector<SeenContour> Renderer::contours(const Camera& camera) const {
  std::vector<SeenContour> out;
  const Vec3 beside_cut_mm =
      camera.cut_plane ? Vec3(kCutMargin_mm * camera.cut_plane->head<3>().normalized()) : Vec3(Vec3::Zero());
  for (const SurfaceLine& contour : contours_) {
    SeenContour& seen = out.emplace_back(contour_style(contour.value, view_.depth_scale()));
    bool visible = false;
    for (const Vec3& p : contour.points_mm) {
      if (seen.points_px.size() % kTestedPoints == 0) visible = is_visible(p, camera, fields_);
      seen.points_px.push_back(camera.pixel(p));
      seen.visible.push_back(visible && is_kept(p - beside_cut_mm, camera));
    }
  }
  return out;
}

PixelImage Renderer::render(const Camera& camera, const std::optional<PlacedTool>& tool, bool filtered) {
  DrawCall call{.camera = camera,
                .settings = view_.settings(),
                .depth_max_mm = view_.depth_scale().max,
                .density_max_g_cm3 = view_.density_scale().max,
                .lines = contours_,
                .tool = tool,
                .filtered = filtered};
  if (camera.cut_plane) call.cut_face = sample_cut_face(fields_, camera);
  return scene_.draw(call);
}

}  // namespace reamsim

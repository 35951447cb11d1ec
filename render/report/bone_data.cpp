#include "render/report/page_data.h"

#include "render/pictures/run_view.h"
#include "render/report/markup.h"
#include "render/report/mesh_data.h"
#include "render/surface/color_map.h"
#include "render/surface/unreamed_surface.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kMostDensityCells = 2'500'000;

template <class Vector>
Json vector_json(const Vector& v) {
  return {short_number(v.x()), short_number(v.y()), short_number(v.z())};
}

BoneSurface surface_of(const Voxmap& voxmap, const FillBricks& fill, const UnreamedSurface& unreamed) {
  return simplified(make_bone_surface(BoneFields(voxmap, fill, unreamed)), MeshBudget());
}

Json mesh_json(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm) {
  return {{"vertices", surface.vertices.size() / BoneSurface::kStride},
          {"triangles", surface.indices.size() / 3},
          {"bytes", compressed_base64(mesh_bytes(surface, box, depth_max_mm))}};
}

Json volume_json(const DensityVolume& volume) {
  return {{"dims", {volume.dims.x(), volume.dims.y(), volume.dims.z()}},
          {"origin_mm", vector_json(volume.origin_mm)},
          {"cell_mm", volume.cell_mm},
          {"bytes", compressed_base64(volume.grades)}};
}

Json colors_json(const ColorMap& map, const Scale& scale) {
  Json json{{"stops", Json::array()}, {"max", scale.max}, {"step", scale.step}, {"ticks", Json::array()}};
  for (const Eigen::Vector3f& stop : map.stops) json["stops"].push_back(vector_json(stop));
  for (int tick = 0; tick < scale.ticks(); ++tick) json["ticks"].push_back(scale.label(tick));
  return json;
}

/// Directions are of length 1; a direction that nobody knows is null.
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

}  // namespace

Json bone_data(const RunData& run, const RenderSettings& settings) {
  const Voxmap& voxmap = run.voxmap();
  const UnreamedSurface& unreamed = run.unreamed();
  const BoneSurface after = surface_of(voxmap, run.last_fill(), unreamed);
  const BoneSurface before = surface_of(voxmap, unreamed.before(), unreamed);
  const Scale depth = depth_scale(run, settings.depth_max_mm);
  const Eigen::AlignedBox3f box = bounds_of(before).merged(bounds_of(after));
  Json json;
  json["look"] = view_json(run.target());
  json["box_mm"] = {vector_json(box.min()), vector_json(box.max())};
  json["grade_per_g_cm3"] = DensityMapping::kMaxGrade / DensityMapping::kMaxDensity_g_cm3;
  json["deepest_mm"] = short_number(after.deepest_mm);
  json["depth_colors"] = colors_json(depth_colors(), depth);
  json["density_colors"] = colors_json(density_colors(), scale_up_to(DensityMapping::kMaxDensity_g_cm3));
  json["before"] = mesh_json(before, box, depth.max);
  json["after"] = mesh_json(after, box, depth.max);
  json["density"] = volume_json(density_volume(voxmap, kMostDensityCells));
  return json;
}

}  // namespace reamsim

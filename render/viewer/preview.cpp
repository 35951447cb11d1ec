// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/viewer/page.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <optional>

#include "sim/anatomy/find_glenoid.h"
#include "sim/base/file.h"
#include "sim/bone/bone.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/paths.h"
#include "sim/scene/load_bone.h"
#include "sim/tool/motion.h"
#include "sim/tool/tool.h"

namespace reamsim {
namespace {

/// The bone of a preview.
struct PreviewBone {
  SegmentedScan scan;                   ///< of a CT
  std::optional<Bone> bone;             ///< of another source
  std::optional<GlenoidFrame> glenoid;  ///< of the scenario, the phantom or the VDB
  std::optional<LandmarkSettings> landmarks;
  std::vector<Vec3> rim_mm;
  BodySide side = BodySide::unknown;
  std::string frame = "LPS";  ///< of B
  MistakeList mistakes;       ///< those that stop a run
};

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxPoses = 240;
constexpr std::size_t kMaxBytes = 14'500'000;
/// A CT cropped to a shoulder. The page opens within three seconds on two cores (docs/preview.md).
constexpr std::int64_t kMaxVoxels = 8'000'000;
constexpr const char* kMark = "<meta name=\"generator\" content=\"reamsim preview";

Json optional_json(const std::optional<Vec3>& v) {
  return v ? vector_json(*v) : Json();
}

Json spheres_json(std::span<const CutSphereSettings> spheres) {
  Json out = Json::array();
  for (const CutSphereSettings& sphere : spheres) {
    out.push_back({{"center_mm", vector_json(sphere.center_mm)}, {"radius_mm", sphere.radius_mm}});
  }
  return out;
}

std::string filter_text(const CtSettings& settings) {
  const std::string name = name_of(settings.filter);
  if (settings.filter == CtFilter::median)
    return fmt::format("{}, radius {} voxels", name, settings.median_radius_voxels);
  if (settings.filter == CtFilter::none) return name;
  return fmt::format("{}, {} iterations, conductance {:g}", name, settings.anisotropic_iterations,
                     settings.anisotropic_conductance);
}

/// `used`: with the cut and the seed of `separate`, which the page uses and does not write.
Json ct_json(const CtSettings& settings, const CtSettings& used) {
  Json planes = Json::array();
  for (const CutPlaneSettings& plane : settings.cut_planes) {
    planes.push_back({{"point_mm", vector_json(plane.point_mm)}, {"normal", vector_json(plane.normal)}});
  }
  return {{"threshold_hu", settings.threshold_hu},
          {"closing_mm", settings.closing_mm},
          {"fill_holes", settings.fill_holes},
          {"label_map", settings.label_map.has_value()},
          {"seed_mm", optional_json(settings.seed_mm)},
          {"cut_spheres", spheres_json(settings.cut_spheres)},
          {"separated", spheres_json(std::span(used.cut_spheres).subspan(settings.cut_spheres.size()))},
          {"separated_seed_mm", optional_json(used.seed_mm)},
          {"cut_planes", planes},
          {"crop_min_mm", optional_json(settings.crop_min_mm)},
          {"crop_max_mm", optional_json(settings.crop_max_mm)},
          {"filter", filter_text(settings)}};
}

/// `given`: by a point near the face, the landmarks or the face of the scenario; else the bone has it, or nothing.
Json glenoid_json(const PreviewBone& bone, const GlenoidSettings& given) {
  // As they are written, so that a direction that does not change keeps its digits; else a column of the frame.
  const auto shown = [&](const std::optional<Vec3>& written, int column) {
    if (written) return vector_json(column == 3 ? *written : Vec3(written->normalized()));
    return bone.glenoid ? vector_json(bone.glenoid->bone_from_glenoid.matrix().col(column)) : Json();
  };
  Json rim_mm = Json::array();
  for (const Vec3& p : bone.rim_mm) rim_mm.push_back(vector_json(p));
  Json json{{"given", given.near_mm     ? "near"
                      : given.landmarks ? "landmarks"
                      : given.center_mm ? "face"
                                        : "none"},
            {"center_mm", shown(given.center_mm, 3)},
            {"normal", shown(given.normal, 2)},
            {"superior", shown(given.superior, 1)},
            {"landmarks", Json()},
            {"rim_mm", rim_mm},
            {"rim_given", !given.rim_mm.empty()}};
  if (bone.landmarks) {
    json["landmarks"] = {{"glenoid_center_mm", vector_json(bone.landmarks->glenoid_center_mm)},
                         {"trigonum_spinae_mm", vector_json(bone.landmarks->trigonum_spinae_mm)},
                         {"inferior_angle_mm", vector_json(bone.landmarks->inferior_angle_mm)}};
  }
  return json;
}

/// The path of the tool in its own frame, at evenly spaced frames; poses are x, y, z (mm), qw, qx, qy, qz. `contact`:
/// of a plunge whose depth counts from the first contact, which the page finds, its direction and approach; else null.
Json motion_json(const MotionSettings& settings, MistakeList& mistakes, Diagnostics& report) {
  Json json{
      {"frame", name_of(settings.frame)}, {"time_s", Json::array()}, {"poses", Json::array()}, {"contact", Json()}};
  const auto count_from_contact = [&](const auto& feed) {
    if (!feed || feed->from != PlungeStart::contact) return;
    json["contact"] = {{"along", vector_json(feed->axis.normalized())}, {"approach_mm", feed->approach_mm}};
  };
  count_from_contact(settings.plunge);
  count_from_contact(settings.push);
  mistakes.attempt([&] {
    const Motion motion = build_motion(settings, GlenoidFrame{}, report);
    for (const std::size_t k : evenly_spaced(motion.poses.size(), kMaxPoses)) {
      const ToolPose pose = motion.poses[k];
      const Vec3& p = pose.position_mm;
      const Quat& q = pose.orientation;
      json["time_s"].push_back(short_number(static_cast<double>(k) * motion.frame_s()));
      json["poses"].push_back({short_number(p.x()), short_number(p.y()), short_number(p.z()), short_number(q.w()),
                               short_number(q.x()), short_number(q.y()), short_number(q.z())});
    }
  });
  return json;
}

/// The frame of the scenario; a face round `near_mm` is found on the voxels as a run finds it.
std::optional<GlenoidFrame> glenoid_of_scan(const BoneSettings& settings, const std::optional<FilledVoxmap>& voxels,
                                            Diagnostics& report) {
  if (!settings.glenoid.near_mm) return glenoid_frame(settings.glenoid, settings.side);
  if (!voxels) return std::nullopt;  // the segmentation failed, which is said
  if (settings.side == BodySide::unknown) return std::nullopt;
  const FoundGlenoid found = find_glenoid(fit_to_bone(*voxels, kMarginVoxels), settings.glenoid, settings.side);
  report.note(found.sentence);
  for (const std::string& doubt : found.doubts) report.warn(doubt);
  return found.frame;
}

/// Reads the bone. Mistakes that its preview can mend are collected. Throws InputError when it cannot be read.
PreviewBone load_preview_bone(const Scenario& scenario, Diagnostics& report) {
  const BoneSettings& settings = scenario.bone;
  PreviewBone out;
  out.side = settings.side;
  if (settings.source == BoneSource::ct) {
    std::optional<FilledVoxmap> voxels;
    const BoneSettings with_surface = with_surface_voxels(settings, scenario.cutting);
    out.scan = segmented_scan(with_surface, report, settings.glenoid.near_mm ? &voxels : nullptr);
    out.mistakes.add(InputError(out.scan.mistakes));
    out.landmarks = settings.glenoid.landmarks;
    out.rim_mm = settings.glenoid.rim_mm;
    out.mistakes.attempt([&] { out.glenoid = glenoid_of_scan(settings, voxels, report); });
    return out;
  }
  // A rim that lies beside the bone is what the preview is for: it must not stop it.
  BoneSettings without_rim = with_surface_voxels(settings, scenario.cutting);
  without_rim.glenoid.rim_mm.clear();
  out.bone = load_bone(without_rim, report);
  out.glenoid = out.bone->glenoid;
  out.landmarks = out.bone->landmarks;
  out.rim_mm = settings.glenoid.rim_mm.empty() ? out.bone->rim_mm : settings.glenoid.rim_mm;
  out.side = out.bone->side;
  out.frame = out.bone->voxmap->frame;
  return out;
}

/// A field of 1 in the page is this many HU away from the threshold.
constexpr float kFieldRange_hu = 200;
/// HU of the bytes 0 and 255: fat to dense cortex, in steps of 8 HU.
constexpr double kLow_hu = -440, kStep_hu = 8;

/// The lattice of boxes of `by` voxels. The last box along an axis may extend beyond the image.
ct::Lattice reduced_lattice(const ct::Lattice& lattice, const Vec3i& by) {
  ct::Lattice out = lattice;
  out.dims = (lattice.dims.array() + by.array() - 1) / by.array();
  out.spacing_mm = lattice.spacing_mm.cwiseProduct(by.cast<double>());
  out.origin_mm = lattice.origin_mm + 0.5 * (out.spacing_mm - lattice.spacing_mm);
  return out;
}

/// Voxels that are averaged along each axis.
Vec3i reduction(const ct::Lattice& lattice, std::int64_t most_voxels) {
  Vec3i by = Vec3i::Ones();
  while (reduced_lattice(lattice, by).dims.cast<std::int64_t>().prod() > most_voxels) {
    int finest = 0;
    lattice.spacing_mm.cwiseProduct(by.cast<double>()).minCoeff(&finest);
    ++by[finest];
  }
  return by;
}

/// Means over the boxes of `by` voxels of the voxels that lie in the image.
std::vector<float> means(const std::vector<float>& values, const ct::Lattice& from, const ct::Lattice& to,
                         const Vec3i& by) {
  std::vector<float> out(static_cast<std::size_t>(to.size()), 0);
  std::vector<float> count(out.size(), 0);
  from.for_each([&](const Vec3i& voxel, std::size_t at) {
    const std::size_t box = to.index(voxel.cwiseQuotient(by));
    out[box] += values[at];
    ++count[box];
  });
  for (std::size_t i = 0; i < out.size(); ++i) out[i] /= count[i];
  return out;
}

/// `byte_of(value)` of each, as differences to the one before.
template <class ByteOf>
std::string packed(const std::vector<float>& values, const ByteOf& byte_of) {
  std::vector<std::uint8_t> bytes(values.size());
  std::ranges::transform(values, bytes.begin(), [&](float value) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(byte_of(value)), 0L, 255L));
  });
  std::adjacent_difference(bytes.begin(), bytes.end(), bytes.begin());
  return compressed_base64(bytes);
}

/// The data of the page's script, with the warnings of `report`, which gets those of tool and motion.
Json preview_data(const PreviewRequest& request, const PreviewBone& bone, std::int64_t most_voxels,
                  Diagnostics& report) {
  const Scenario& scenario = request.scenario;
  const BoneSettings& settings = scenario.bone;
  MistakeList mistakes = bone.mistakes;
  Json json;
  json["scenario"] = request.text;
  json["file_name"] = request.file_name;
  json["anatomical"] = bone.frame == "LPS" || (bone.frame == "phantom" && bone.side != BodySide::unknown);
  json["side"] = bone.side == BodySide::unknown ? Json() : Json(name_of(bone.side));
  json["ct"] = settings.source == BoneSource::ct ? ct_json(settings.ct, bone.scan.settings) : Json();
  json["glenoid"] = glenoid_json(bone, settings.glenoid);
  const PassSpec last = passes_of(scenario).back();
  json["tool"] = Json();  // the envelope of revolution; null where it cannot be read
  mistakes.attempt([&] {
    const Tool tool = load_tool(last.tool, settings.voxel_mm, ShellUse::none, report);
    for (const Vec2& p : tool.profile.points)
      json["tool"]["profile"].push_back({short_number(p.x()), short_number(p.y())});
  });
  json["motion"] = motion_json(last.motion, mistakes, report);
  json["volume"] =
      volume_json(bone.bone ? preview_of_voxmap(*bone.bone, most_voxels) : preview_of_scan(bone.scan, most_voxels));
  json["problems"] = Json::array();
  for (Mistake mistake : mistakes.mistakes()) {
    // The file's name suffices, and says nothing about the machine.
    mistake.where = {std::filesystem::path(mistake.where.file).filename().string(), 0, 0};
    json["problems"].push_back(recorded_text(mistake.line()));
  }
  json["warnings"] = Json::array();
  for (const std::string& warning : report.warnings) json["warnings"].push_back(recorded_text(warning));
  return json;
}

}  // namespace

PreviewVolume preview_of_scan(const SegmentedScan& scan, std::int64_t most_voxels) {
  const ct::Lattice& lattice = scan.hu.lattice;
  const Vec3i by = reduction(lattice, most_voxels);
  PreviewVolume out{.lattice = reduced_lattice(lattice, by), .unit = "HU", .value = {}, .bone = {}};
  out.value = means(scan.hu.value, lattice, out.lattice, by);
  if (scan.field.empty()) return out;
  // The field of a label map has no unit; its values are −½…½.
  const float most = std::abs(*std::ranges::max_element(scan.field, {}, [](float f) { return std::abs(f); }));
  const float range = most <= 1 ? most : kFieldRange_hu;
  std::vector<float> field(scan.field.size());
  std::ranges::transform(scan.field, field.begin(), [&](float f) { return std::clamp(f / range, -1.0F, 1.0F); });
  out.bone = means(field, lattice, out.lattice, by);
  return out;
}

PreviewVolume preview_of_voxmap(const BoneView& bone, std::int64_t most_voxels) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const ct::Lattice fine{grid.dims, Vec3::Constant(grid.voxel_mm), grid.center_mm(Vec3i::Zero())};
  Vec3i by = Vec3i::Ones();
  while (reduced_lattice(fine, by).dims.cast<std::int64_t>().prod() > most_voxels) by += Vec3i::Ones();
  PreviewVolume out{.lattice = reduced_lattice(fine, by), .unit = "g/cm³", .value = {}, .bone = {}};
  out.value.assign(static_cast<std::size_t>(out.lattice.size()), 0);
  out.bone.assign(out.value.size(), -1);
  const auto voxels = static_cast<float>(by.prod());
  for_each_bone_voxel(bone, [&](const Vec3i& voxel, std::uint8_t grade, std::uint16_t fill) {
    const std::size_t box = out.lattice.index(voxel.cwiseQuotient(by));
    const float part = static_cast<float>(fill) / static_cast<float>(FillBricks::kWhole) / voxels;
    out.value[box] += part * static_cast<float>(DensityMapping::density_from_grade(grade));
    out.bone[box] += 2 * part;
  });
  return out;
}

Json volume_json(const PreviewVolume& volume) {
  const bool hu = volume.unit == "HU";
  const double low = hu ? kLow_hu : 0, step = hu ? kStep_hu : DensityMapping::kGradeStep_g_cm3;
  const Vec3i& dims = volume.lattice.dims;
  Json json{{"dims", {dims.x(), dims.y(), dims.z()}},
            {"origin_mm", vector_json(volume.lattice.origin_mm)},
            {"spacing_mm", vector_json(volume.lattice.spacing_mm)},
            {"unit", volume.unit},
            {"low", low},
            {"step", step},
            {"values", packed(volume.value, [&](float v) { return (static_cast<double>(v) - low) / step; })},
            {"bone", Json()}};
  if (!volume.bone.empty()) json["bone"] = packed(volume.bone, [](float f) { return 128 + 127 * f; });
  return json;
}

std::string preview_page(const PreviewRequest& request, Diagnostics& report) {
  const PreviewBone bone = load_preview_bone(request.scenario, report);
  // Noise does not compress, so the number of voxels alone does not bound the size.
  for (std::int64_t most_voxels = kMaxVoxels;; most_voxels /= 2) {
    Diagnostics found = report;
    const std::string page =
        self_contained_page(embedded::preview_page, request.source, "reamsim preview " REAMSIM_VERSION,
                            preview_data(request, bone, most_voxels, found));
    if (page.size() > kMaxBytes && most_voxels > 1) continue;
    report = std::move(found);
    return page;
  }
}

bool is_preview_page(const std::string& path) {
  return read_file_start(path, 2048).find(kMark) != std::string::npos;
}

}  // namespace reamsim

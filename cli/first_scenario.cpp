// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/first_scenario.h"

#include <fmt/ranges.h>
#include <filesystem>

#include "cli/command_line.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/bone/mesh_source.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

/// A text in single quotes for YAML.
std::string yaml_quoted(const std::string& text) {
  return "'" + replace_all(text, {{"'", "''"}}) + "'";
}

std::string yaml_vector(const Vec3& v, int digits) {
  return fmt::format("[{:.{}f}, {:.{}f}, {:.{}f}]", v.x(), digits, v.y(), digits, v.z(), digits);
}

std::string ct_text(const CtSettings& ct) {
  std::string out;
  if (ct.crop_min_mm && ct.crop_max_mm) {
    out += fmt::format("    crop_min_mm: {}   # a box round the scapula, LPS\n    crop_max_mm: {}\n",
                       yaml_vector(*ct.crop_min_mm, 1), yaml_vector(*ct.crop_max_mm, 1));
  }
  out +=
      fmt::format("    threshold_hu: {}          # least radiodensity of bone; lower it where the surface has holes\n",
                  shortest_text(ct.threshold_hu));
  if (ct.separate != Separate::none) {
    out += fmt::format("    separate: {}         # cuts the head of the humerus off along the joint gap\n",
                       name_of(ct.separate));
  }
  return out;
}

std::string mesh_text(const MeshBoneSettings& mesh, const std::string& scale_note) {
  return fmt::format(
      "    scale: {}                  # file units to mm{}\n"
      "    cortical_mm: {}          # a mesh has no density: a shell of cortical bone on trabecular bone\n"
      "    cortical_hu: {}\n    trabecular_hu: {}\n",
      shortest_text(mesh.scale), scale_note.empty() ? "" : ": " + scale_note, shortest_text(mesh.cortical_mm),
      shortest_text(mesh.cortical_hu), shortest_text(mesh.trabecular_hu));
}

/// A point with all its digits, so that the run is that of the landmarks as they are.
std::string exact_vector(const Vec3& v) {
  return fmt::format("[{}, {}, {}]", shortest_text(v.x()), shortest_text(v.y()), shortest_text(v.z()));
}

/// What gives the superior direction; `found`: that of the frame.
std::string superior_text(const FirstScenario& first, const Vec3& found) {
  const GlenoidSettings& glenoid = first.bone.glenoid;
  if (const auto& marks = glenoid.landmarks) {
    return fmt::format(
        "    landmarks:              # for the superior direction and the scapular frame\n"
        "      glenoid_center_mm: {}\n      trigonum_spinae_mm: {}\n      inferior_angle_mm: {}\n",
        exact_vector(marks->glenoid_center_mm), exact_vector(marks->trigonum_spinae_mm),
        exact_vector(marks->inferior_angle_mm));
  }
  if (glenoid.superior) return "    superior: " + exact_vector(*glenoid.superior) + "   # towards the superior point\n";
  const char* text = first.bone.source == BoneSource::mesh
                         ? "    superior: {}   # towards the narrow end of the face: check it\n"
                         : "    # superior: {}\n";
  return fmt::format(fmt::runtime(text), yaml_vector(found, 4));
}

/// A list of points under its key; "" without points.
std::string points_text(const std::string& key, const std::vector<Vec3>& points_mm, const std::string& indent) {
  if (points_mm.empty()) return "";
  std::string out = key + "\n";
  for (const Vec3& p : points_mm) out += indent + "- " + exact_vector(p) + "\n";
  return out;
}

std::string version_text(const VersionLandmarks& marks) {
  std::string out = points_text("      face_mm:", marks.face_mm, "        ");
  for (const auto& [key, point] : marks.in_slice()) out += fmt::format("      {}: {}\n", key, exact_vector(point));
  return out.empty() ? out : "    version_landmarks:\n" + out;
}

std::string glenoid_text(const FirstScenario& first) {
  if (!first.bone.glenoid.near_mm || !first.glenoid) return "";
  const GlenoidSettings& glenoid = first.bone.glenoid;
  const Mat3 axes = first.glenoid->linear();
  return fmt::format(
             "  glenoid:\n    near_mm: {}   # the face is found round this point\n"
             "    # Found: center_mm: {}, normal: {}.\n",
             yaml_vector(*glenoid.near_mm, 2), yaml_vector(first.glenoid->translation(), 2),
             yaml_vector(axes.col(2), 4)) +
         superior_text(first, axes.col(1)) +
         points_text("    rim_mm:                 # of the face before reaming", glenoid.rim_mm, "      ") +
         version_text(glenoid.version_landmarks);
}

std::string bone_text(const FirstScenario& first) {
  const BoneSettings& bone = first.bone;
  std::string out = fmt::format("bone:\n  source: {}\n", name_of(bone.source));
  if (bone.side != BodySide::unknown) out += fmt::format("  side: {}\n", name_of(bone.side));
  if (bone.source != BoneSource::vdb) out += fmt::format("  voxel_mm: {}\n", shortest_text(bone.voxel_mm));
  out += fmt::format("  {}:\n    path: {}\n", name_of(bone.source), yaml_quoted(first.bone_path));
  if (bone.source == BoneSource::ct) out += ct_text(bone.ct);
  if (bone.source == BoneSource::mesh) out += mesh_text(bone.mesh, first.scale_note);
  return out + glenoid_text(first);
}

std::string motion_text(const PlungeSettings& plunge) {
  return fmt::format(
      "motion:\n  frame: glenoid            # entry and axis are in the glenoid frame: +z out of the face, +y "
      "superior\n"
      "  plunge:\n    entry_mm: [0, 0, 0]     # the line of the plunge passes the centre of the face\n"
      "    axis: [0, 0, -1]\n    from: {}           # of the reamer with the bone, found before the run\n"
      "    approach_mm: {:g}          # before the contact\n    feed_mm_s: {:g}\n"
      "    depth_mm: {:g}             # beyond the contact\n    dwell_s: {:g}\n    retract_mm: {:g}\n"
      "    retract_mm_s: {:g}\n    spin_rpm: {:g}\n",
      name_of(plunge.from), plunge.approach_mm, plunge.feed_mm_s, plunge.depth_mm, plunge.dwell_s, plunge.retract_mm,
      plunge.retract_mm_s, plunge.spin_rpm);
}

/// Sets a key in the lines of a YAML text with two spaces a level: replaces its line, or adds it to its section.
void set_key(std::vector<std::string>& lines, const std::vector<std::string>& names, const std::string& value) {
  std::size_t at = 0;
  for (std::size_t depth = 0; depth < names.size(); ++depth, ++at) {
    const std::size_t indent = 2 * depth;
    const std::string key = std::string(indent, ' ') + names[depth] + ":";
    const bool last = depth + 1 == names.size();
    std::size_t end = at;  // of the section, without the comments behind it
    for (; at < lines.size() && !lines[at].starts_with(key); ++at) {
      const std::size_t first = lines[at].find_first_not_of(' ');
      if (first == std::string::npos || lines[at][first] == '#') continue;
      if (first < indent) break;
      end = at + 1;
    }
    if (at == lines.size() || !lines[at].starts_with(key)) {
      at = end;
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(at), last ? key + " " + value : key);
    } else if (last) {
      lines[at] = key + " " + value;
    }
  }
}

}  // namespace

std::string reamer_or_own(const std::string& given) {
  const fs::path reamer = given.empty() ? fs::path(shipped_folder("assets")) / "reamer_convex.stl" : fs::path(given);
  std::error_code ignored;
  if (fs::is_regular_file(reamer, ignored)) return reamer.string();
  throw InputError({reamer.string(), 0, 0}, "--tool", "there is no such reamer", "give a mesh with --tool MESH");
}

BoneSettings first_bone(const std::string& path, double voxel_mm, double scale, double threshold_hu,
                        const std::vector<std::string>& more) {
  const BoneSource source = source_of_file(path);
  if (source == BoneSource::vdb) return {.source = source, .vdb = {.path = path}};
  std::vector<std::string> set{"bone.voxel_mm=" + shortest_text(voxel_mm)};
  set.push_back(source == BoneSource::mesh ? "bone.mesh.scale=" + shortest_text(scale)
                                           : "bone.ct.threshold_hu=" + shortest_text(threshold_hu));
  set.insert(set.end(), more.begin(), more.end());
  return parse_bone_settings(name_of(source), path, set);
}

PlungeSettings first_plunge() {
  return {.from = PlungeStart::contact,
          .approach_mm = 2,
          .feed_mm_s = 1,
          .depth_mm = 3,
          .dwell_s = 0.2,
          .retract_mm = 12,
          .retract_mm_s = 20};
}

std::string text_of(const FirstScenario& first) {
  return fmt::format("{}\nversion: 2\n\n{}\ntool:\n  mesh: {}\n\n{}\nrender:\n  cameras: [glenoid, section, oblique]\n",
                     first.first_line, bone_text(first), yaml_quoted(first.tool_path), motion_text(first.plunge));
}

std::string with_keys(const std::string& text, const std::vector<std::string>& assignments) {
  std::vector<std::string> lines = split(text, '\n');
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos)
      throw InputError({}, "--set", "found " + printable(assignment), "expected KEY.PATH=VALUE");
    set_key(lines, split(assignment.substr(0, equals), '.'), assignment.substr(equals + 1));
  }
  return fmt::format("{}", fmt::join(lines, "\n"));
}

std::vector<std::string> bone_keys(const std::vector<std::string>& assignments) {
  std::vector<std::string> out = assignments;
  std::erase_if(out, [](const std::string& assignment) { return !assignment.starts_with("bone."); });
  return out;
}

std::optional<std::string> value_set(const std::vector<std::string>& assignments, const std::string& key) {
  std::optional<std::string> out;
  for (const std::string& assignment : assignments) {
    if (assignment.starts_with(key + "=")) out = assignment.substr(key.size() + 1);
  }
  return out;
}

std::optional<double> scale_of(std::optional<double> of_option, const std::vector<std::string>& assignments) {
  const auto set = value_set(assignments, "bone.mesh.scale");
  if (!set) return of_option;
  if (of_option) throw InputError({}, "--scale", "given beside --set bone.mesh.scale=...", "give one of them");
  const auto scale = parse_number(*set);
  if (!scale || !(*scale > 0)) {
    throw InputError({}, "--set bone.mesh.scale", "found " + printable(*set), "expected a number above 0");
  }
  return scale;
}

MeshScale mesh_scale(const std::string& path, std::optional<double> of_option, const Console& console) {
  constexpr const char* kGiveScale = "give --scale";
  if (source_of_file(path) != BoneSource::mesh) {
    if (of_option) throw InputError({path, 0, 0}, "--scale", "only a mesh has a scale", "leave it out");
    return {};
  }
  if (of_option) {
    require_scale(path, *of_option, kGiveScale);
    return {.scale = *of_option, .why = "given by --scale"};
  }
  const FoundScale found = find_scale_of(path, kGiveScale);
  const std::string length = fmt::format("the mesh is then {:.0f} mm long", found.length_mm);
  const MeshScale out{.scale = found.scale,
                      .why = found.assumed ? "mm is assumed; " + length + ", and a scapula 100 to 220 mm"
                                           : "the file is in " + found.unit + "; " + length + ", as a scapula"};
  const std::string text = fmt::format("bone.mesh.scale: {}: {}", shortest_text(out.scale), out.why);
  if (found.scale == 1 && !found.assumed) {
    console.say(text);
  } else {
    console.warn(text + "; if that is wrong, " + kGiveScale);
  }
  return out;
}

}  // namespace reamsim

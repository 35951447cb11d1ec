// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace reamsim {

// The values of every key that takes one of a closed list; docs/keys.md defines them. kChoiceNames<E> has their names,
// for scenarios, results and messages.

enum class BoneSource { phantom, ct, mesh, vdb };
/// The frame of a mesh's coordinates. file: as its header says; without a statement they are taken as they stand.
enum class MeshFrame { file, lps, ras };
enum class BodySide { unknown, left, right };
enum class SurfaceVoxels { automatic, partial, whole };
enum class PhantomShape { half_space, cup, sphere, layered, glenoid };
enum class Walch { none, a1, a2, b2, c };
enum class Modality { ct, any };
/// What happens to DICOM slices that are not evenly spaced.
enum class Uneven { refuse, resample };
enum class Separate { none, humerus };
enum class CtFilter { none, median, curvature_anisotropic };
/// The frame in which a scenario gives positions and directions.
enum class PoseFrame { bone, glenoid };
/// The frame in which the pose of an implant is given.
enum class ImplantFrame { reamer, glenoid, bone };
enum class FootprintShape { ellipse, pear };
enum class AugmentShape { wedge, step };
enum class ToolSpin { envelope, resolved };
/// Where the depth of a plunge is 0.
enum class PlungeStart { entry, contact };
/// What is meant to end a push.
enum class PushEnd { depth, time, stall };
/// The layout of a recording of poses.
enum class PoseFormat { csv, tum };
enum class Separator { comma, semicolon, tab, space };
enum class DecimalMark { point, comma };
enum class LengthUnit { mm, cm, m, um, in };
enum class TimeUnit { s, ms, us, ns };
/// The order of the components of a quaternion.
enum class QuaternionOrder { wxyz, xyzw };
enum class EngineKind { automatic, exact, bricked, direct, octree, implicit };
enum class KernelShape { automatic, cpu, gpu };
enum class CuttingLaw { energy, per_point };
enum class ErosionMode { exact, remove, wear };
enum class EnergyPreset { none, assumed_low, assumed_mid, assumed_high, drill_human_femur, drill_artificial_femur };
enum class CameraView { oblique, glenoid, section, overview };
enum class Projection { perspective, orthographic };
enum class RenderContext { automatic, osmesa, egl };
enum class FilmFormat { none, mp4, webp, apng };
enum class ToolMaterial { see_through, steel };
enum class Background { studio, white, transparent };

constexpr auto name_list(auto... names) {
  return std::array{std::string_view(names)...};
}

/// The names of the enumerators, in their order.
struct ChoiceNames {
  static constexpr auto of(BoneSource) { return name_list("phantom", "ct", "mesh", "vdb"); }
  static constexpr auto of(MeshFrame) { return name_list("file", "lps", "ras"); }
  static constexpr auto of(BodySide) { return name_list("", "left", "right"); }
  static constexpr auto of(SurfaceVoxels) { return name_list("auto", "partial", "whole"); }
  static constexpr auto of(PhantomShape) { return name_list("half_space", "cup", "sphere", "layered", "glenoid"); }
  static constexpr auto of(Walch) { return name_list("none", "A1", "A2", "B2", "C"); }
  static constexpr auto of(Modality) { return name_list("ct", "any"); }
  static constexpr auto of(Uneven) { return name_list("refuse", "resample"); }
  static constexpr auto of(Separate) { return name_list("none", "humerus"); }
  static constexpr auto of(CtFilter) { return name_list("none", "median", "curvature_anisotropic"); }
  static constexpr auto of(PoseFrame) { return name_list("bone", "glenoid"); }
  static constexpr auto of(ImplantFrame) { return name_list("reamer", "glenoid", "bone"); }
  static constexpr auto of(FootprintShape) { return name_list("ellipse", "pear"); }
  static constexpr auto of(AugmentShape) { return name_list("wedge", "step"); }
  static constexpr auto of(ToolSpin) { return name_list("envelope", "resolved"); }
  static constexpr auto of(PlungeStart) { return name_list("entry", "contact"); }
  static constexpr auto of(PushEnd) { return name_list("depth", "time", "stall"); }
  static constexpr auto of(PoseFormat) { return name_list("csv", "tum"); }
  static constexpr auto of(Separator) { return name_list("comma", "semicolon", "tab", "space"); }
  static constexpr auto of(DecimalMark) { return name_list("point", "comma"); }
  static constexpr auto of(LengthUnit) { return name_list("mm", "cm", "m", "um", "in"); }
  static constexpr auto of(TimeUnit) { return name_list("s", "ms", "us", "ns"); }
  static constexpr auto of(QuaternionOrder) { return name_list("wxyz", "xyzw"); }
  static constexpr auto of(EngineKind) { return name_list("auto", "exact", "bricked", "direct", "octree", "implicit"); }
  static constexpr auto of(KernelShape) { return name_list("auto", "cpu", "gpu"); }
  static constexpr auto of(CuttingLaw) { return name_list("energy", "per_point"); }
  static constexpr auto of(ErosionMode) { return name_list("exact", "remove", "wear"); }
  static constexpr auto of(EnergyPreset) {
    return name_list("", "assumed-low", "assumed-mid", "assumed-high", "drill-human-femur", "drill-artificial-femur");
  }
  static constexpr auto of(CameraView) { return name_list("oblique", "glenoid", "section", "overview"); }
  static constexpr auto of(Projection) { return name_list("perspective", "orthographic"); }
  static constexpr auto of(RenderContext) { return name_list("auto", "osmesa", "egl"); }
  static constexpr auto of(FilmFormat) { return name_list("none", "mp4", "webp", "apng"); }
  static constexpr auto of(ToolMaterial) { return name_list("see-through", "steel"); }
  static constexpr auto of(Background) { return name_list("studio", "white", "transparent"); }
};
template <class E>
inline constexpr auto kChoiceNames = ChoiceNames::of(E{});

/// The name of a value; "" for the value of a key that is not given.
template <class E>
std::string name_of(E value) {
  return std::string(kChoiceNames<E>[static_cast<std::size_t>(value)]);
}

template <class E>
std::vector<std::string> names_of(const std::vector<E>& values) {
  std::vector<std::string> out;
  for (const E value : values) out.push_back(name_of(value));
  return out;
}

/// The value of that name, or nullopt.
template <class E>
std::optional<E> from_name(std::string_view name) {
  const auto found = std::ranges::find(kChoiceNames<E>, name);
  if (found == kChoiceNames<E>.end()) return std::nullopt;
  return static_cast<E>(found - kChoiceNames<E>.begin());
}

}  // namespace reamsim

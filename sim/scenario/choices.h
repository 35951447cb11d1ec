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

// The values of every key that takes one of a closed list; docs/keys.md defines them. kChoiceNames<E> has their
// names in the order of the enumerators, for scenarios, results and messages.

template <class E>
inline constexpr bool kChoiceNames = false;  // specialised below, as arrays

constexpr auto name_list(auto... names) {
  return std::array{std::string_view(names)...};
}

enum class BoneSource { phantom, ct, mesh, vdb };
template <>
inline constexpr auto kChoiceNames<BoneSource> = name_list("phantom", "ct", "mesh", "vdb");

/// The frame of a mesh's coordinates. file: as its header says; without a statement they are taken as they stand.
enum class MeshFrame { file, lps, ras };
template <>
inline constexpr auto kChoiceNames<MeshFrame> = name_list("file", "lps", "ras");

enum class BodySide { unknown, left, right };
template <>
inline constexpr auto kChoiceNames<BodySide> = name_list("", "left", "right");

enum class SurfaceVoxels { automatic, partial, whole };
template <>
inline constexpr auto kChoiceNames<SurfaceVoxels> = name_list("auto", "partial", "whole");

enum class PhantomShape { half_space, cup, sphere, layered, glenoid };
template <>
inline constexpr auto kChoiceNames<PhantomShape> = name_list("half_space", "cup", "sphere", "layered", "glenoid");

enum class Walch { none, a1, a2, b2, c };
template <>
inline constexpr auto kChoiceNames<Walch> = name_list("none", "A1", "A2", "B2", "C");

enum class Modality { ct, any };
template <>
inline constexpr auto kChoiceNames<Modality> = name_list("ct", "any");

/// What happens to DICOM slices that are not evenly spaced.
enum class Uneven { refuse, resample };
template <>
inline constexpr auto kChoiceNames<Uneven> = name_list("refuse", "resample");

enum class Separate { none, humerus };
template <>
inline constexpr auto kChoiceNames<Separate> = name_list("none", "humerus");

enum class CtFilter { none, median, curvature_anisotropic };
template <>
inline constexpr auto kChoiceNames<CtFilter> = name_list("none", "median", "curvature_anisotropic");

/// The frame in which a scenario gives positions and directions.
enum class PoseFrame { bone, glenoid };
template <>
inline constexpr auto kChoiceNames<PoseFrame> = name_list("bone", "glenoid");

/// The frame in which the pose of an implant is given.
enum class ImplantFrame { reamer, glenoid, bone };
template <>
inline constexpr auto kChoiceNames<ImplantFrame> = name_list("reamer", "glenoid", "bone");

enum class FootprintShape { ellipse, pear };
template <>
inline constexpr auto kChoiceNames<FootprintShape> = name_list("ellipse", "pear");

enum class ToolSpin { envelope, resolved };
template <>
inline constexpr auto kChoiceNames<ToolSpin> = name_list("envelope", "resolved");

/// Where the depth of a plunge is 0.
enum class PlungeStart { entry, contact };
template <>
inline constexpr auto kChoiceNames<PlungeStart> = name_list("entry", "contact");

/// What is meant to end a push.
enum class PushEnd { depth, time, stall };
template <>
inline constexpr auto kChoiceNames<PushEnd> = name_list("depth", "time", "stall");

/// The layout of a recording of poses.
enum class PoseFormat { csv, tum };
template <>
inline constexpr auto kChoiceNames<PoseFormat> = name_list("csv", "tum");

enum class Separator { comma, semicolon, tab, space };
template <>
inline constexpr auto kChoiceNames<Separator> = name_list("comma", "semicolon", "tab", "space");

enum class DecimalMark { point, comma };
template <>
inline constexpr auto kChoiceNames<DecimalMark> = name_list("point", "comma");

enum class LengthUnit { mm, cm, m, um, in };
template <>
inline constexpr auto kChoiceNames<LengthUnit> = name_list("mm", "cm", "m", "um", "in");

enum class TimeUnit { s, ms, us, ns };
template <>
inline constexpr auto kChoiceNames<TimeUnit> = name_list("s", "ms", "us", "ns");

/// The order of the components of a quaternion.
enum class QuaternionOrder { wxyz, xyzw };
template <>
inline constexpr auto kChoiceNames<QuaternionOrder> = name_list("wxyz", "xyzw");

enum class EngineKind { automatic, exact, bricked, direct, octree, implicit };
template <>
inline constexpr auto kChoiceNames<EngineKind> = name_list("auto", "exact", "bricked", "direct", "octree", "implicit");

enum class KernelShape { automatic, cpu, gpu };
template <>
inline constexpr auto kChoiceNames<KernelShape> = name_list("auto", "cpu", "gpu");

enum class CuttingLaw { energy, per_point };
template <>
inline constexpr auto kChoiceNames<CuttingLaw> = name_list("energy", "per_point");

enum class ErosionMode { exact, remove, wear };
template <>
inline constexpr auto kChoiceNames<ErosionMode> = name_list("exact", "remove", "wear");

enum class EnergyPreset { none, literature_low, literature_mid, literature_high };
template <>
inline constexpr auto kChoiceNames<EnergyPreset> = name_list("", "literature-low", "literature-mid", "literature-high");

enum class CameraView { oblique, glenoid, section, overview };
template <>
inline constexpr auto kChoiceNames<CameraView> = name_list("oblique", "glenoid", "section", "overview");

enum class Projection { perspective, orthographic };
template <>
inline constexpr auto kChoiceNames<Projection> = name_list("perspective", "orthographic");

enum class RenderContext { automatic, osmesa, egl };
template <>
inline constexpr auto kChoiceNames<RenderContext> = name_list("auto", "osmesa", "egl");

enum class FilmFormat { none, mp4, webp, apng };
template <>
inline constexpr auto kChoiceNames<FilmFormat> = name_list("none", "mp4", "webp", "apng");

enum class ToolMaterial { see_through, steel };
template <>
inline constexpr auto kChoiceNames<ToolMaterial> = name_list("see-through", "steel");

enum class Background { studio, white, transparent };
template <>
inline constexpr auto kChoiceNames<Background> = name_list("studio", "white", "transparent");

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

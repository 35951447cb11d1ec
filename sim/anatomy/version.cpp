// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Version of a face by the definitions of the literature, as SciKit-SurgeryGlenoid implements them
// (github.com/SciKit-Surgery/glenoidplanefitting, commit 9c770a9): friedman.py, vault.py, plane_fitting.py.

#include <cmath>

#include "sim/anatomy/run_metrics.h"

namespace reamsim {

namespace {

/// Whether keys below bone.glenoid are given.
using Needed = std::initializer_list<std::pair<const char*, bool>>;

/// "set bone.glenoid.landmarks, ..." for those that are missing; "" where none is.
std::string missing_points(const Needed& needed) {
  std::string out;
  for (const auto& [key, given] : needed) {
    if (!given) out += std::string(out.empty() ? "landmarks are missing: set" : ",") + " bone.glenoid." + key;
  }
  return out;
}

/// Two planes. Here the anatomical directions give the sign; in the published code the order of the fit does.
Measured<double> two_planes_version(const BoneAxes& axes) {
  const std::vector<Vec3>& face_mm = axes.version.face_mm;
  const std::string missing =
      missing_points({{"landmarks", axes.scapula.has_value()}, {"version_landmarks.face_mm", !face_mm.empty()}});
  if (!missing.empty()) return Missing{missing};
  const std::optional<PlaneFit> plane = fit_plane(face_mm, axes.scapula->lateral);
  if (!plane) return Missing{"the points of bone.glenoid.version_landmarks.face_mm lie on one line"};
  return angle_deg(plane->normal, axes.scapula->anterior) - 90;
}

/// Friedman and vault: the angle at the middle of the margins, from the anterior margin to `medial`, less 90 degrees.
Measured<double> slice_version(const BoneAxes& axes, const std::optional<Vec3>& medial_mm, const char* medial_key) {
  constexpr double kLeastApart_mm = 1, kSlice_mm = 0.5;
  const auto& anterior = axes.version.anterior_margin_mm;
  const auto& posterior = axes.version.posterior_margin_mm;
  const std::string missing = missing_points({{"version_landmarks.anterior_margin_mm", anterior.has_value()},
                                              {"version_landmarks.posterior_margin_mm", posterior.has_value()},
                                              {medial_key, medial_mm.has_value()}});
  if (!missing.empty()) return Missing{missing};
  const Vec3 across = *anterior - *posterior, middle_mm = *posterior + across / 2, medial = *medial_mm - middle_mm;
  if (across.norm() < kLeastApart_mm || medial.norm() < kLeastApart_mm)
    return Missing{"the margins, or their middle and the medial point, lie less than 1 mm apart"};
  if (axes.axial_z && std::max(std::abs(across.z()), std::abs(medial.z())) > kSlice_mm)
    return Missing{"the points do not lie in one axial slice: they differ by more than 0.5 mm along z"};
  if (axes.side_known && axes.known() && across.dot(axes.known()->anterior) < 0)
    return Missing{"anterior_margin_mm lies posterior to posterior_margin_mm: swap them, or correct bone.side"};
  return angle_deg(across, medial) - 90;
}

}  // namespace

double angle_deg(const Vec3& a, const Vec3& b) {
  return degrees_of(std::atan2(a.cross(b).norm(), a.dot(b)));
}

std::vector<FaceVersion> measure_versions(const Measured<FaceAngles>& native, const BoneAxes& axes) {
  Measured<double> face_axis = Missing{native.reason};
  if (native.value) face_axis = native.value->version_deg;
  return {{"face_axis", "orientation.native.version_deg", face_axis},
          {"two_planes",
           "angle between the normals of the plane through face_mm (lateral) and of the scapular plane (anterior), "
           "less 90 degrees (Ganapathi et al. 2011)",
           two_planes_version(axes)},
          {"friedman_2d",
           "angle at the middle of the margins from anterior_margin_mm to medial_tip_mm, less 90 degrees (Friedman et "
           "al. 1992)",
           slice_version(axes, axes.version.medial_tip_mm, "version_landmarks.medial_tip_mm")},
          {"vault_2d",
           "angle at the middle of the margins from anterior_margin_mm to vault_tip_mm, less 90 degrees (Matsumura et "
           "al. 2014)",
           slice_version(axes, axes.version.vault_tip_mm, "version_landmarks.vault_tip_mm")}};
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/vdb/bone_vdb_metadata.h"

#include <array>
#include <cmath>
#include <locale>
#include <sstream>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr const char* kRemedy = "; remove it with a VDB tool, or write the file again";

/// Exactly N finite numbers.
template <std::size_t N>
bool read_numbers(const std::string& text, std::array<double, N>& numbers) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  for (double& number : numbers) {
    if (!(in >> number) || !std::isfinite(number)) return false;
  }
  std::string rest;
  return !(in >> rest);
}

/// The beginning of a text from a file.
std::string excerpt(const std::string& text) {
  return "found '" + printable(text.substr(0, 60)) + "'";
}

std::ostringstream exact_text() {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(17);  // reads back to the same values
  return out;
}

std::string text_of(const Rigid& transform) {
  std::ostringstream out = exact_text();
  for (int i = 0; i < 16; ++i) out << (i > 0 ? " " : "") << transform.matrix()(i / 4, i % 4);
  return out.str();
}

std::string text_of(const LandmarkSettings& marks) {
  std::ostringstream out = exact_text();
  for (const Vec3& p : {marks.glenoid_center_mm, marks.trigonum_spinae_mm, marks.inferior_angle_mm}) {
    out << (out.tellp() > 0 ? " " : "") << p.x() << " " << p.y() << " " << p.z();
  }
  return out.str();
}

}  // namespace

std::optional<GlenoidFrame> parse_stored_glenoid(const std::string& path, const std::string& text) {
  if (text.empty()) return std::nullopt;
  const InputError wrong({path, 0, 0}, vdb_keys::kGlenoid, excerpt(text),
                         std::string("expected 16 numbers of a rigid transform, row by row") + kRemedy);
  std::array<double, 16> n{};
  if (!read_numbers(text, n)) throw wrong;
  GlenoidFrame frame;
  frame.bone_from_glenoid.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(n.data());
  const Mat3 turn = frame.bone_from_glenoid.linear();
  const Eigen::Vector4d last = frame.bone_from_glenoid.matrix().row(3);
  const bool rigid = (turn * turn.transpose()).isApprox(Mat3::Identity(), 1e-4) && turn.determinant() > 0 &&
                     last.isApprox(Eigen::Vector4d(0, 0, 0, 1), 1e-9);
  if (!rigid) throw wrong;
  return frame;
}

std::optional<LandmarkSettings> parse_stored_landmarks(const std::string& path, const std::string& text) {
  if (text.empty()) return std::nullopt;
  std::array<double, 9> n{};
  if (!read_numbers(text, n)) {
    throw InputError({path, 0, 0}, vdb_keys::kLandmarks, excerpt(text),
                     std::string("expected 9 numbers: glenoid centre, trigonum spinae, inferior angle") + kRemedy);
  }
  return LandmarkSettings{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]}};
}

std::optional<BoneLayers> parse_stored_layers(const std::string& text) {
  std::array<double, 3> n{};
  if (!read_numbers(text, n) || n[0] < 0 || n[1] < 0 || n[2] < 0) return std::nullopt;
  return BoneLayers{n[0], n[1], n[2]};
}

std::string stored_text(const BoneLayers& layers) {
  std::ostringstream out = exact_text();
  out << layers.cortical_mm << " " << layers.cortical_g_cm3 << " " << layers.trabecular_g_cm3;
  return out.str();
}

BodySide checked_stored_side(const std::string& path, const std::string& text) {
  if (const auto side = from_name<BodySide>(text)) return *side;
  throw InputError({path, 0, 0}, vdb_keys::kSide, excerpt(text), std::string("expected left or right") + kRemedy);
}

Metadata metadata_of(const StoredAnatomy& anatomy) {
  Metadata out;
  if (anatomy.side != BodySide::unknown) out.emplace_back(vdb_keys::kSide, name_of(anatomy.side));
  if (anatomy.glenoid) out.emplace_back(vdb_keys::kGlenoid, text_of(anatomy.glenoid->bone_from_glenoid));
  if (anatomy.landmarks) out.emplace_back(vdb_keys::kLandmarks, text_of(*anatomy.landmarks));
  return out;
}

}  // namespace reamsim

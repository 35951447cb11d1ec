// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/first_scenario.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string_view>

#include "sim/base/error.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/markups.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

enum class Role { center, superior, trigonum, inferior_angle, rim, face, anterior, posterior, medial_tip, vault_tip };
constexpr std::array<std::string_view, 10> kRoleNames{"center",     "superior", "trigonum",        "inferior_angle",
                                                      "rim",        "face",     "anterior_margin", "posterior_margin",
                                                      "medial_tip", "vault_tip"};
const std::string kRoles = join_or({kRoleNames.begin(), kRoleNames.end()});
constexpr std::size_t kLeastRimPoints = 6, kLeastFacePoints = 3;

/// Labels by role, as words in alphabetical order without those of kIgnoredWords.
const std::array<std::vector<std::string_view>, kRoleNames.size()> kLabels{{
    {"center glenoid", "center", "gc", "glenoid", "glenoid midpoint", "glenoid middle"},
    {"superior", "glenoid superior", "pole superior", "glenoid pole superior", "rim superior", "glenoid rim superior",
     "supraglenoid tubercle", "glenoid sup", "sup"},
    {"spinae trigonum", "trigonum", "ts", "root spine"},
    {"angle inferior", "angulus inferior", "ai", "ia"},
    {"rim", "glenoid rim"},
    {"face", "face glenoid"},
    {"anterior margin", "anterior glenoid margin"},
    {"margin posterior", "glenoid margin posterior"},
    {"medial tip"},
    {"tip vault", "glenoid tip vault"},
}};
constexpr std::array<std::string_view, 13> kIgnoredWords{
    "the", "of", "point", "landmark", "lm", "mm", "fossa", "left", "right", "scapulae", "scapula", "scapular", "my"};

/// The words of a label: runs of letters, in lower case.
std::vector<std::string> label_words(std::string_view label) {
  std::vector<std::string> out;
  bool in_word = false;
  bool lower_before = false;
  for (const char c : label) {
    const bool upper = c >= 'A' && c <= 'Z', letter = upper || (c >= 'a' && c <= 'z');
    if (letter && (!in_word || (upper && lower_before))) out.emplace_back();  // "GlenoidCenter" has two
    if (letter) out.back() += upper ? static_cast<char>(c - 'A' + 'a') : c;
    in_word = letter;
    lower_before = letter && !upper;
  }
  return out;
}

std::optional<Role> role_of(std::string_view label) {
  std::set<std::string> words;
  for (const std::string& word : label_words(label)) {
    if (std::ranges::find(kIgnoredWords, word) == kIgnoredWords.end()) words.insert(word == "centre" ? "center" : word);
  }
  const std::string joined = fmt::format("{}", fmt::join(words, " "));
  for (std::size_t role = 0; role < kLabels.size(); ++role) {
    if (std::ranges::find(kLabels[role], joined) != kLabels[role].end()) return static_cast<Role>(role);
  }
  return std::nullopt;
}

bool is_of_side(std::string_view label, BodySide side) {
  const std::vector<std::string> words = label_words(label);
  const std::string other = name_of(side == BodySide::left ? BodySide::right : BodySide::left);
  return side == BodySide::unknown || std::ranges::find(words, other) == words.end();
}

/// A point of a file.
struct Candidate : MarkupsPoint {
  std::string file;
  std::string frame;
  bool used = false;
};

std::string text_of(const Candidate& point) {
  const Vec3& p = point.position_mm;
  return fmt::format("{} of {} ({}) at ({:.2f}, {:.2f}, {:.2f})", shown_text(point.label), shown_path(point.file),
                     point.frame, p.x(), p.y(), p.z());
}

std::string labels_of(const std::vector<Candidate>& points) {
  return points.empty() ? "no points" : "the points " + shown_labels({points.begin(), points.end()});
}

std::vector<Candidate> points_of(const std::vector<std::string>& files) {
  std::vector<Candidate> out;
  for (const std::string& file : files) {
    const Markups markups = read_markups(file);
    for (const MarkupsPoint& point : markups.points()) out.push_back({{point}, file, markups.frame});
  }
  return out;
}

std::string name_of(Role role) {
  return std::string(kRoleNames[static_cast<std::size_t>(role)]);
}

/// Points by their roles.
class Assignment {
 public:
  explicit Assignment(std::vector<Candidate> all) : all_(std::move(all)) {}

  /// `text`: "ROLE=LABEL".
  void give(const std::string& text) {
    const std::size_t equals = text.find('=');
    const auto role = std::ranges::find(kRoleNames, text.substr(0, equals));
    if (equals == std::string::npos || role == kRoleNames.end())
      throw InputError({}, "--point", "found " + shown_text(text), "expected ROLE=LABEL, ROLE one of " + kRoles);
    const std::string label = text.substr(equals + 1);
    const auto count = std::ranges::count(all_, label, &Candidate::label);
    if (count != 1) {
      throw InputError({}, "--point", (count == 0 ? "no point " : "several points ") + shown_text(label),
                       "the markups have " + labels_of(all_));
    }
    add(static_cast<Role>(role - kRoleNames.begin()), *std::ranges::find(all_, label, &Candidate::label));
  }

  /// Roles that are not given are found by labels.
  void find(BodySide side) {
    const auto given = chosen_;
    for (Candidate& candidate : all_) {
      const std::optional<Role> role = role_of(candidate.label);
      if (candidate.used || !role || given.contains(*role)) continue;
      if (is_of_side(candidate.label, side)) add(*role, candidate);
    }
  }

  [[nodiscard]] std::optional<Vec3> point(Role role) const {
    const auto found = chosen_.find(role);
    if (found == chosen_.end()) return std::nullopt;
    if (found->second.size() > 1) {
      std::vector<std::string> all;
      for (const Candidate* candidate : found->second) all.push_back(text_of(*candidate));
      throw InputError({}, "--markups",
                       fmt::format("several points may be the {}: {}", name_of(role), fmt::join(all, " and ")),
                       "give --point " + name_of(role) + "=LABEL, --side, or labels that differ");
    }
    return placed(*found->second.front());
  }

  [[nodiscard]] std::vector<Vec3> points(Role role) const {
    std::vector<Vec3> out;
    const auto found = chosen_.find(role);
    if (found == chosen_.end()) return out;
    for (const Candidate* candidate : found->second) out.push_back(placed(*candidate));
    return out;
  }

  [[nodiscard]] std::vector<std::string> said() const {
    std::vector<std::string> out;
    for (const auto& [role, points] : chosen_) {
      const bool several = (role == Role::rim || role == Role::face) && points.size() > 1;
      out.push_back(name_of(role) + ": " + (several ? fmt::format("{} points, the first ", points.size()) : "") +
                    text_of(*points.front()));
    }
    std::vector<Candidate> rest = all_;
    std::erase_if(rest, [](const Candidate& candidate) { return candidate.used; });
    if (!rest.empty()) out.push_back("not used: " + labels_of(rest) + "; --point ROLE=LABEL uses one as " + kRoles);
    return out;
  }

  [[nodiscard]] bool empty() const { return chosen_.empty(); }

 private:
  void add(Role role, Candidate& candidate) {
    chosen_[role].push_back(&candidate);
    candidate.used = true;
  }

  static Vec3 placed(const Candidate& point) {
    if (point.placed) return point.position_mm;
    refuse_file(shown_path(point.file), "the point " + shown_text(point.label) + " is not placed yet",
                "place it in 3D Slicer");
  }

  std::vector<Candidate> all_;
  std::map<Role, std::vector<const Candidate*>> chosen_;
};

/// Points of a rim in order round their middle, as seen along the normal of their plane.
std::vector<Vec3> ordered_round(std::vector<Vec3> rim) {
  if (rim.size() < kLeastRimPoints) return rim;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : rim) middle += p / static_cast<double>(rim.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : rim) spread += (p - middle) * (p - middle).transpose();
  const PointSpread plane{middle, symmetric_eigen(spread)};
  std::ranges::stable_sort(rim, {}, [&](const Vec3& p) { return angle_in_plane(p, plane); });
  return rim;
}

}  // namespace

Landmarks find_landmarks(const std::vector<std::string>& files, const std::vector<std::string>& given, BodySide side) {
  const std::vector<Candidate> all = points_of(files);
  Assignment roles(all);
  for (const std::string& text : given) roles.give(text);
  roles.find(side);
  if (roles.empty()) {
    throw InputError({}, "--markups", "no label was understood: the files have " + labels_of(all),
                     "give --point ROLE=LABEL, ROLE one of " + kRoles);
  }
  const std::optional<Vec3> center = roles.point(Role::center), superior = roles.point(Role::superior),
                            trigonum = roles.point(Role::trigonum), angle = roles.point(Role::inferior_angle);
  const std::vector<Vec3> rim = ordered_round(roles.points(Role::rim)), face = roles.points(Role::face);
  Landmarks out{.center = center, .glenoid = {}, .found = roles.said()};
  const auto unused = [&](const std::string& role, const std::string& why) {
    out.found.push_back(role + " is not used: " + why);
  };
  if (center && trigonum && angle) {
    out.glenoid.landmarks =
        LandmarkSettings{.glenoid_center_mm = *center, .trigonum_spinae_mm = *trigonum, .inferior_angle_mm = *angle};
    if (superior) unused("superior", "the landmarks give the superior direction");
  } else {
    const std::string why = "the scapular frame needs center, trigonum and inferior_angle";
    if (trigonum) unused("trigonum", why);
    if (angle) unused("inferior_angle", why);
    if (superior && center) {
      const Vec3 direction = *superior - *center;
      if (direction.norm() < 1)
        throw InputError({}, "--markups", "superior lies within 1 mm of center", "move one of them");
      out.glenoid.superior = direction.normalized();
    } else if (superior) {
      unused("superior", "its direction needs center");
    }
  }
  VersionLandmarks& version = out.glenoid.version_landmarks;
  const auto take = [&](const char* role, const std::vector<Vec3>& points, std::size_t least, std::vector<Vec3>& to) {
    if (points.size() >= least) to = points;
    if (to.empty() && !points.empty())
      unused(role, fmt::format("it has {} points, and at least {} are needed", points.size(), least));
  };
  take("rim", rim, kLeastRimPoints, out.glenoid.rim_mm);
  take("face", face, kLeastFacePoints, version.face_mm);
  const auto take_one = [&](Role role, std::optional<Vec3>& to) {
    if (roles.points(role).size() > 1) return unused(name_of(role), "several points may be it");
    to = roles.point(role);
  };
  take_one(Role::anterior, version.anterior_margin_mm);
  take_one(Role::posterior, version.posterior_margin_mm);
  take_one(Role::medial_tip, version.medial_tip_mm);
  take_one(Role::vault_tip, version.vault_tip_mm);
  return out;
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/landmark_roles.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

enum class Role { center, superior, trigonum, inferior_angle, rim };
constexpr std::array<std::string_view, 5> kRoleNames{"center", "superior", "trigonum", "inferior_angle", "rim"};
constexpr const char* kRoles = "center, superior, trigonum, inferior_angle or rim";
constexpr std::size_t kLeastRimPoints = 6;

/// Labels of a role as words in alphabetical order, without those of kIgnoredWords.
struct Spelling {
  std::string_view words;
  Role role;
};
constexpr std::array kSpellings{
    Spelling{"center glenoid", Role::center},
    Spelling{"center", Role::center},
    Spelling{"gc", Role::center},
    Spelling{"glenoid", Role::center},
    Spelling{"glenoid midpoint", Role::center},
    Spelling{"glenoid middle", Role::center},
    Spelling{"superior", Role::superior},
    Spelling{"glenoid superior", Role::superior},
    Spelling{"pole superior", Role::superior},
    Spelling{"glenoid pole superior", Role::superior},
    Spelling{"rim superior", Role::superior},
    Spelling{"glenoid rim superior", Role::superior},
    Spelling{"supraglenoid tubercle", Role::superior},
    Spelling{"glenoid sup", Role::superior},
    Spelling{"sup", Role::superior},
    Spelling{"spinae trigonum", Role::trigonum},
    Spelling{"trigonum", Role::trigonum},
    Spelling{"ts", Role::trigonum},
    Spelling{"root spine", Role::trigonum},
    Spelling{"angle inferior", Role::inferior_angle},
    Spelling{"angulus inferior", Role::inferior_angle},
    Spelling{"ai", Role::inferior_angle},
    Spelling{"ia", Role::inferior_angle},
    Spelling{"rim", Role::rim},
    Spelling{"glenoid rim", Role::rim},
};
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
  const auto found = std::ranges::find(kSpellings, joined, &Spelling::words);
  return found == kSpellings.end() ? std::nullopt : std::optional(found->role);
}

bool is_of_side(std::string_view label, BodySide side) {
  const std::vector<std::string> words = label_words(label);
  const std::string other = name_of(side == BodySide::left ? BodySide::right : BodySide::left);
  return side == BodySide::unknown || std::ranges::find(words, other) == words.end();
}

/// A point of a file.
struct Candidate {
  MarkupsPoint point;
  std::string file;
  std::string frame;
};

std::string text_of(const Candidate& candidate) {
  const Vec3& p = candidate.point.position_mm;
  return fmt::format("{} of {} ({}) at ({:.2f}, {:.2f}, {:.2f})", shown_text(candidate.point.label),
                     shown_path(candidate.file), candidate.frame, p.x(), p.y(), p.z());
}

std::string labels_of(const std::vector<Candidate>& candidates) {
  std::vector<MarkupsPoint> points;
  for (const Candidate& candidate : candidates) points.push_back(candidate.point);
  return points.empty() ? "no points" : "the points " + shown_labels(points);
}

std::vector<Candidate> points_of(const std::vector<std::string>& files) {
  std::vector<Candidate> out;
  for (const std::string& file : files) {
    const Markups markups = read_markups(file);
    for (const Markup& markup : markups.markups) {
      for (const MarkupsPoint& point : markup.points) out.push_back({point, file, markups.frame});
    }
  }
  return out;
}

/// Points by their roles.
class Assignment {
 public:
  Assignment(std::vector<Candidate> all, BodySide side) : all_(std::move(all)), used_(all_.size()), side_(side) {}

  /// `text`: "ROLE=LABEL".
  void give(const std::string& text) {
    const std::size_t equals = text.find('=');
    const auto role = std::ranges::find(kRoleNames, text.substr(0, equals));
    if (equals == std::string::npos || role == kRoleNames.end())
      throw InputError({}, "--point", "found " + shown_text(text),
                       std::string("expected ROLE=LABEL, ROLE one of ") + kRoles);
    const std::string label = text.substr(equals + 1);
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (all_[i].point.label == label) found.push_back(i);
    }
    if (found.size() == 1) return add(static_cast<Role>(role - kRoleNames.begin()), found.front());
    throw InputError({}, "--point",
                     found.empty() ? "no point " + shown_text(label) : "several points " + shown_text(label),
                     "the markups have " + labels_of(all_));
  }

  /// Roles that are not given are found by labels.
  void find() {
    const std::map<Role, std::vector<std::size_t>> given = chosen_;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const std::optional<Role> role = role_of(all_[i].point.label);
      if (!used_[i] && role && !given.contains(*role) && is_of_side(all_[i].point.label, side_)) add(*role, i);
    }
  }

  [[nodiscard]] std::optional<Vec3> point(Role role) const {
    const auto found = chosen_.find(role);
    if (found == chosen_.end()) return std::nullopt;
    if (found->second.size() > 1) {
      std::string both;
      for (const std::size_t i : found->second) both += (both.empty() ? "" : " and ") + text_of(all_[i]);
      const std::string name(kRoleNames[static_cast<std::size_t>(role)]);
      throw InputError({}, "--markups", "several points may be the " + name + ": " + both,
                       "give --point " + name + "=LABEL, --side, or labels that differ");
    }
    return placed(found->second.front());
  }

  [[nodiscard]] std::vector<Vec3> points(Role role) const {
    std::vector<Vec3> out;
    const auto found = chosen_.find(role);
    if (found == chosen_.end()) return out;
    for (const std::size_t i : found->second) out.push_back(placed(i));
    return out;
  }

  [[nodiscard]] std::vector<std::string> said() const {
    std::vector<std::string> out;
    for (const auto& [role, points] : chosen_) {
      const std::string name(kRoleNames[static_cast<std::size_t>(role)]);
      if (role == Role::rim && points.size() > 1) {
        out.push_back(fmt::format("{}: {} points, the first {}", name, points.size(), text_of(all_[points.front()])));
      } else {
        out.push_back(name + ": " + text_of(all_[points.front()]));
      }
    }
    std::vector<Candidate> rest;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (!used_[i]) rest.push_back(all_[i]);
    }
    if (!rest.empty()) out.push_back("not used: " + labels_of(rest) + "; --point ROLE=LABEL uses one as " + kRoles);
    return out;
  }

  [[nodiscard]] bool empty() const { return chosen_.empty(); }
  [[nodiscard]] const std::vector<Candidate>& all() const { return all_; }

 private:
  void add(Role role, std::size_t i) {
    chosen_[role].push_back(i);
    used_[i] = true;
  }

  [[nodiscard]] Vec3 placed(std::size_t i) const {
    const Candidate& candidate = all_[i];
    if (candidate.point.placed) return candidate.point.position_mm;
    throw InputError({shown_path(candidate.file), 0, 0}, "",
                     "the point " + shown_text(candidate.point.label) + " is not placed yet", "place it in 3D Slicer");
  }

  std::vector<Candidate> all_;
  std::vector<bool> used_;
  BodySide side_;
  std::map<Role, std::vector<std::size_t>> chosen_;
};

/// Points of a rim in order round their middle, as seen along the normal of their plane.
std::vector<Vec3> ordered_round(std::vector<Vec3> rim) {
  if (rim.size() < kLeastRimPoints) return rim;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : rim) middle += p / static_cast<double>(rim.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : rim) spread += (p - middle) * (p - middle).transpose();
  const Mat3 axes = symmetric_eigen(spread).vectors;  // that of the least spread, the normal, first
  const auto angle = [&](const Vec3& p) {
    return std::atan2((p - middle).dot(axes.col(1)), (p - middle).dot(axes.col(2)));
  };
  std::ranges::stable_sort(rim, {}, angle);
  return rim;
}

}  // namespace

FoundLandmarks find_landmarks(const std::vector<std::string>& files, const std::vector<std::string>& given,
                              BodySide side) {
  Assignment roles(points_of(files), side);
  for (const std::string& text : given) roles.give(text);
  roles.find();
  if (roles.empty()) {
    throw InputError({}, "--markups", "no label was understood: the files have " + labels_of(roles.all()),
                     std::string("give --point ROLE=LABEL, ROLE one of ") + kRoles);
  }
  FoundLandmarks out;
  out.center = roles.point(Role::center);
  out.superior = roles.point(Role::superior);
  out.trigonum = roles.point(Role::trigonum);
  out.inferior_angle = roles.point(Role::inferior_angle);
  out.rim = ordered_round(roles.points(Role::rim));
  out.found = roles.said();
  return out;
}

void apply_landmarks(FoundLandmarks& landmarks, GlenoidSettings& glenoid) {
  const auto unused = [&](const std::string& role, const std::string& why) {
    landmarks.found.push_back(role + " is not used: " + why);
  };
  const bool all = landmarks.center && landmarks.trigonum && landmarks.inferior_angle;
  if (all) {
    glenoid.landmarks = LandmarkSettings{.glenoid_center_mm = *landmarks.center,
                                         .trigonum_spinae_mm = *landmarks.trigonum,
                                         .inferior_angle_mm = *landmarks.inferior_angle};
    if (landmarks.superior) unused("superior", "the landmarks give the superior direction");
  } else {
    const std::string why = "the scapular frame needs center, trigonum and inferior_angle";
    if (landmarks.trigonum) unused("trigonum", why);
    if (landmarks.inferior_angle) unused("inferior_angle", why);
    if (landmarks.superior && landmarks.center) {
      const Vec3 direction = *landmarks.superior - *landmarks.center;
      if (direction.norm() < 1)
        throw InputError({}, "--markups", "superior lies within 1 mm of center", "move one of them");
      glenoid.superior = direction.normalized();
    } else if (landmarks.superior) {
      unused("superior", "its direction needs center");
    }
  }
  if (landmarks.rim.size() >= kLeastRimPoints) {
    glenoid.rim_mm = landmarks.rim;
  } else if (!landmarks.rim.empty()) {
    unused("rim", fmt::format("it has {} points, and at least {} are needed", landmarks.rim.size(), kLeastRimPoints));
  }
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/distance_table.h"

#include <cmath>
#include <limits>

#include "sim/base/parallel.h"

namespace reamsim {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

}  // namespace

double DistanceTable::at(const Vec2& rz) const {
  const double r = (rz.x() - first.x()) / pitch_mm, z = (rz.y() - first.y()) / pitch_mm;
  if (r < 0 || z < 0 || z >= count_z - 1 || r >= count_r - 1) return kFar;
  const auto column = static_cast<std::size_t>(r), row = static_cast<std::size_t>(z);
  const double u = r - static_cast<double>(column), v = z - static_cast<double>(row);
  const float* corner = mm.data() + row * static_cast<std::size_t>(count_r) + column;
  const double low = (1 - u) * double{corner[0]} + u * double{corner[1]};
  const double high = (1 - u) * double{corner[count_r]} + u * double{corner[count_r + 1]};
  return (1 - v) * low + v * high;
}

double DistanceTable::nearest(const Vec2& rz) const {
  const double r = std::floor((rz.x() - first.x()) / pitch_mm + 0.5),
               z = std::floor((rz.y() - first.y()) / pitch_mm + 0.5);
  if (r < 0 || z < 0 || r >= count_r || z >= count_z) return kFar;
  return double{mm[static_cast<std::size_t>(r) + static_cast<std::size_t>(count_r) * static_cast<std::size_t>(z)]};
}

DistanceTable make_distance_table(const Profile& profile, const Vec2& first, double pitch_mm, int count_r,
                                  int count_z) {
  DistanceTable out{first, pitch_mm, count_r, count_z, {}};
  out.mm.resize(static_cast<std::size_t>(count_r) * static_cast<std::size_t>(count_z));
  parallel_items(static_cast<std::size_t>(count_z), [&](std::size_t row) {
    for (int i = 0; i < count_r; ++i) {
      const Vec2 rz(first.x() + i * pitch_mm, first.y() + static_cast<double>(row) * pitch_mm);
      out.mm[row * static_cast<std::size_t>(count_r) + static_cast<std::size_t>(i)] =
          static_cast<float>(profile.nearest(rz).distance_mm);
    }
  });
  return out;
}

DistanceTable distance_table_around(const Profile& profile, double pitch_mm, double margin_mm) {
  const Aabb box = profile.bounds().expanded(margin_mm);
  return make_distance_table(profile, {0, box.min.z()}, pitch_mm,
                             static_cast<int>(std::ceil(box.max.x() / pitch_mm)) + 2,
                             static_cast<int>(std::ceil((box.max.z() - box.min.z()) / pitch_mm)) + 2);
}

}  // namespace reamsim

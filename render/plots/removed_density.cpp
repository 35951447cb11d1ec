// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <array>
#include <string>

#include "render/plots/plots.h"

namespace reamsim {
namespace embedded {
extern const char* const removed_density_script;
}
namespace {

// All classes have the same number of grades.
constexpr int kGradesPerClass = 5;
constexpr std::size_t kClasses = 250 / kGradesPerClass;
using Histogram = std::array<double, kClasses>;  // mm³

Histogram removed_by_density(const Voxmap& voxmap, const FillBricks& before, const FillBricks& after) {
  Histogram out{};
  after.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& last) {
    const GradeBricks::Brick* grades = voxmap.grade.brick(coord);
    if (grades == nullptr) return;
    const FillBricks::Brick* first = before.brick(coord);
    for (std::size_t i = 0; i < last.size(); ++i) {
      if ((*grades)[i] == 0) continue;
      const int removed = (first == nullptr ? FillBricks::kWhole : (*first)[i]) - last[i];
      const std::size_t density_class = std::min<std::size_t>(((*grades)[i] - 1) / kGradesPerClass, kClasses - 1);
      out[density_class] += static_cast<double>(removed) / FillBricks::kWhole * voxmap.grid.voxel_mm3();
    }
  });
  return out;
}

}  // namespace

void write_removed_density(const std::string& dir, const Voxmap& voxmap, const FillBricks& before,
                           const FillBricks& after) {
  const Histogram removed = removed_by_density(voxmap, before, after);
  CsvWriter csv = plot_csv(dir, "removed_density.csv", "density_from_g_cm3,density_to_g_cm3,removed_mm3");
  for (std::size_t i = 0; i < kClasses; ++i) {
    // In thousandths, so that the bounds are round numbers.
    const auto bound = [](std::size_t place) { return static_cast<double>(place * kGradesPerClass * 8) / 1000; };
    csv.row({bound(i), bound(i + 1), removed[i]});
  }
  csv.close();
  draw_plot(dir, "plots/removed_density", "", embedded::removed_density_script);
}

}  // namespace reamsim

#include <array>
#include <string>

#include "render/plots/plots.h"
#include "sim/base/error.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/record/snapshot.h"

namespace reamsim {

namespace embedded {
extern const char* const removed_density_script;
}

namespace {

// Every class holds as many grades as the others, so that none stands out for holding more.
constexpr int kGradesPerClass = 5;
constexpr std::size_t kClasses = 250 / kGradesPerClass;
using Histogram = std::array<double, kClasses>;  // mm³

FillBricks fill_before(const std::string& dir, const Vec3i& dims) {
  FillBricks before(dims);
  const std::vector<std::int64_t> frames = snapshot_frames(dir);
  if (frames.empty()) {
    throw InputError({dir + "/snapshots", 0, 0}, "", "no snapshot there", "the output folder of a run");
  }
  if (frames.front() == 0) apply_snapshot(dir, 0, before);
  return before;
}

Histogram removed_by_density(const FilledVoxmap& voxmap, const FillBricks& before) {
  Histogram out{};
  voxmap.fill.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& after) {
    const GradeBricks::Brick* grades = voxmap.grade.brick(coord);
    if (grades == nullptr) return;
    const FillBricks::Brick* first = before.brick(coord);
    for (std::size_t i = 0; i < after.size(); ++i) {
      if ((*grades)[i] == 0) continue;
      const int lost = (first == nullptr ? FillBricks::kWhole : (*first)[i]) - after[i];
      const std::size_t place = std::min<std::size_t>(((*grades)[i] - 1) / kGradesPerClass, kClasses - 1);
      out[place] += static_cast<double>(lost) / FillBricks::kWhole * voxmap.grid.voxel_mm3();
    }
  });
  return out;
}

}  // namespace

void write_removed_density(const std::string& dir) {
  const FilledVoxmap voxmap = read_bone_vdb(dir + "/reamed.vdb");
  const Histogram removed = removed_by_density(voxmap, fill_before(dir, voxmap.grid.dims));
  std::string csv = "density_from_g_cm3,density_to_g_cm3,removed_mm3\n";
  for (std::size_t i = 0; i < kClasses; ++i) {
    // In thousandths, so that the bounds are round numbers.
    const auto bound = [](std::size_t place) {
      return shortest_text(static_cast<double>(place * kGradesPerClass * 8) / 1000);
    };
    csv += bound(i) + "," + bound(i + 1) + "," + shortest_text(removed[i]) + "\n";
  }
  write_text_file(dir + "/plots/removed_density.csv", csv);
  draw_plot(dir, "plots/removed_density", "", embedded::removed_density_script);
}

}  // namespace reamsim

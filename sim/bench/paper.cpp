#include "sim/bench/paper.h"

#include <string_view>

namespace reamsim::bench {

std::optional<double> paper_ms(const char* engine, int voxmap, int shell) {
  const std::string_view name = engine;
  const auto row = place(kVoxmaps, voxmap);
  const auto column = place(kShells, shell);
  if (!row) return std::nullopt;
  if (name == "implicit") return kPaperImplicit[*row];
  if (!column) return std::nullopt;
  if (name == "octree")
    return *row < std::size(kPaperOctree) ? std::optional(kPaperOctree[*row][*column]) : std::nullopt;
  return kPaperDirect[*row][*column];
}

}  // namespace reamsim::bench

#include "sim/bone/ct/scan_planes.h"

#include <cmath>

namespace reamsim::ct {

namespace {

/// Which axes of LPS a plane shows, and how: the radiological convention.
struct View {
  const char* name;
  int across;    // axis that runs to the right
  int down;      // axis that runs down or up
  bool upwards;  // rows go against it
  const char* left;
  const char* right;
  const char* top;
  const char* bottom;
};
constexpr View kViews[] = {{"axial", 0, 1, false, "R", "L", "A", "P"},
                           {"coronal", 0, 2, true, "R", "L", "S", "I"},
                           {"sagittal", 1, 2, true, "A", "P", "S", "I"}};

ScanPlane plane_of(const View& view, const AlignedImage& hu, const BoneField& bone, const CtSettings& settings,
                   const Vec3i& through) {
  const Lattice& lattice = hu.lattice;
  ScanPlane out{.name = view.name,
                .columns = lattice.dims[view.across],
                .rows = lattice.dims[view.down],
                .spacing_mm = {lattice.spacing_mm[view.across], lattice.spacing_mm[view.down]},
                .left = view.left,
                .right = view.right,
                .top = view.top,
                .bottom = view.bottom,
                .hu = {},
                .field = {}};
  const auto row_of = [&](int index) { return view.upwards ? out.rows - 1 - index : index; };
  out.through = Vec2(through[view.across], row_of(through[view.down]));
  for (int row = 0; row < out.rows; ++row) {
    for (int column = 0; column < out.columns; ++column) {
      Vec3i voxel = through;
      voxel[view.across] = column;
      voxel[view.down] = row_of(row);
      const std::size_t at = lattice.index(voxel);
      const float field = bone.field.value[at];
      const bool cut = bone.facts.method == "threshold" && is_cut_away(settings, lattice.center_mm(voxel));
      out.hu.push_back(hu.value[at]);
      out.field.push_back(cut ? -std::abs(field) : field);
    }
  }
  return out;
}

}  // namespace

std::vector<ScanPlane> scan_planes(const AlignedImage& hu, const BoneField& bone, const CtSettings& settings,
                                   const Vec3& through_mm) {
  const Vec3i last = hu.lattice.dims - Vec3i::Ones();
  const Vec3 index = (through_mm - hu.lattice.origin_mm).cwiseQuotient(hu.lattice.spacing_mm);
  const Vec3 inside = index.cwiseMax(0).cwiseMin(last.cast<double>());
  const Vec3i through = inside.array().round().cast<int>();
  std::vector<ScanPlane> out;
  for (const View& view : kViews) out.push_back(plane_of(view, hu, bone, settings, through));
  return out;
}

}  // namespace reamsim::ct

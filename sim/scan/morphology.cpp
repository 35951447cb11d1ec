// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/segment.h"

#include <itkConnectedComponentImageFilter.h>
#include <itkDiscreteGaussianImageFilter.h>
#include <itkImportImageFilter.h>
#include <itkMedianImageFilter.h>
#include <itkRelabelComponentImageFilter.h>

#include <algorithm>
#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim::ct {

namespace {

using FloatImage = itk::Image<float, 3>;
using MaskImage = itk::Image<std::uint8_t, 3>;
using LabelImage = itk::Image<std::uint32_t, 3>;

/// An ITK image of `values`, which it does not own.
template <typename Value>
typename itk::Image<Value, 3>::Pointer view(std::vector<Value>& values, const Vec3i& dims,
                                            const Vec3& spacing = Vec3::Ones()) {
  using Importer = itk::ImportImageFilter<Value, 3>;
  const auto importer = Importer::New();
  typename Importer::RegionType region;
  typename Importer::SpacingType step;
  for (unsigned axis = 0; axis < 3; ++axis) {
    region.SetSize(axis, static_cast<itk::SizeValueType>(dims[axis]));
    step[axis] = spacing[axis];
  }
  importer->SetRegion(region);
  importer->SetSpacing(step);
  importer->SetImportPointer(values.data(), values.size(), false);
  importer->Update();
  return importer->GetOutput();
}

template <class Filter>
void apply(Filter& filter, AlignedImage& image) {
  filter.SetInput(view(image.value, image.lattice.dims, image.lattice.spacing_mm));
  filter.Update();
  std::copy_n(filter.GetOutput()->GetBufferPointer(), image.value.size(), image.value.begin());
}

/// Marks every voxel at one of some offsets from a marked one. `rows`: the offsets, symmetric about each axis, as rows
/// along x: half the width, and the place, of each. The mask grows from its boundary, the voxels with a neighbour
/// outside: those farther inside add nothing, where the set contains all that is nearer along each axis.
Mask dilated(const Mask& mask, const Lattice& lattice, const std::vector<Vec3i>& rows) {
  Mask out = mask, boundary(mask.size());
  const auto length = static_cast<std::size_t>(lattice.dims.x());
  parallel_items(static_cast<std::size_t>(lattice.dims.y() * lattice.dims.z()), [&](std::size_t row) {
    Vec3i voxel = lattice.voxel_at(row * length);
    for (std::size_t at = row * length; at < (row + 1) * length; ++at, ++voxel.x()) {
      boundary[at] = mask[at] != 0 && has_face_outside(mask, lattice, voxel) ? 1 : 0;
    }
  });
  for (std::size_t at = 0; at < boundary.size(); ++at) {
    if (boundary[at] == 0) continue;
    const Vec3i voxel = lattice.voxel_at(at);
    for (const Vec3i& row : rows) {
      const Vec3i first(std::max(voxel.x() - row.x(), 0), voxel.y() + row.y(), voxel.z() + row.z());
      if (!lattice.contains(first)) continue;
      const int last = std::min(voxel.x() + row.x(), lattice.dims.x() - 1);
      std::fill_n(&out[lattice.index(first)], last - first.x() + 1, std::uint8_t{1});
    }
  }
  return out;
}

/// Labels of the connected components of the background; of a plane, where one of `dims` is 1.
std::vector<std::uint32_t> label_background(Mask& background, const Vec3i& dims, std::uint32_t& count) {
  const auto label = itk::ConnectedComponentImageFilter<MaskImage, LabelImage>::New();
  label->SetInput(view(background, dims));
  label->Update();
  count = static_cast<std::uint32_t>(label->GetObjectCount());
  const std::uint32_t* first = label->GetOutput()->GetBufferPointer();
  return {first, first + background.size()};
}

/// Marks the components of the background that reach the rim of this face of the image: they are open.
void mark_open_parts(const std::vector<std::uint32_t>& part, const Lattice& lattice, int across, int level,
                     std::vector<std::uint8_t>& open) {
  IndexBox face{Vec3i::Zero(), lattice.dims};
  face.start[across] = level;
  face.size[across] = 1;
  const std::vector<std::uint32_t> here = part_of(part, lattice, face);
  Mask background(here.size());
  std::ranges::transform(here, background.begin(), [](std::uint32_t component) { return component != 0; });
  std::uint32_t count = 0;
  const std::vector<std::uint32_t> region = label_background(background, face.size, count);
  std::vector<std::uint8_t> reaches_rim(count + std::size_t{1}, 0);
  lattice.part(face).for_each([&](const Vec3i& v, std::size_t at) {
    for (const int axis : {(across + 1) % 3, (across + 2) % 3}) {
      if (v[axis] == 0 || v[axis] == face.size[axis] - 1) reaches_rim[region[at]] = 1;
    }
  });
  for (std::size_t at = 0; at < here.size(); ++at) {
    if (region[at] != 0 && reaches_rim[region[at]]) open[here[at]] = 1;
  }
}

}  // namespace

Mask positive_voxels(const AlignedImage& image) {
  Mask out(image.value.size());
  std::ranges::transform(image.value, out.begin(), [](float value) { return value > 0 ? 1 : 0; });
  return out;
}

Mask complement(const Mask& mask) {
  Mask out(mask.size());
  std::ranges::transform(mask, out.begin(), [](std::uint8_t inside) { return inside ? 0 : 1; });
  return out;
}

bool has_face_outside(const Mask& mask, const Lattice& lattice, const Vec3i& voxel) {
  return std::ranges::any_of(kFaceSteps, [&](const Vec3i& step) {
    const Vec3i near = voxel + step;
    return lattice.contains(near) && mask[lattice.index(near)] == 0;
  });
}

Mask eroded(const Mask& mask, const Lattice& lattice, const Vec3i& radius) {
  return complement(dilated(complement(mask), lattice, radius));
}

Mask dilated(const Mask& mask, const Lattice& lattice, const Vec3i& radius) {
  std::vector<Vec3i> box;
  for_each_voxel({0, -radius.y(), -radius.z()}, {0, radius.y(), radius.z()},
                 [&](const Vec3i& place) { box.emplace_back(radius.x(), place.y(), place.z()); });
  return dilated(mask, lattice, box);
}

void median_filter(AlignedImage& image, int radius_voxels) {
  const auto filter = itk::MedianImageFilter<FloatImage, FloatImage>::New();
  filter->SetRadius(static_cast<itk::SizeValueType>(radius_voxels));
  apply(*filter, image);
}

void gaussian_filter(AlignedImage& image, double sigma_voxels) {
  const auto filter = itk::DiscreteGaussianImageFilter<FloatImage, FloatImage>::New();
  filter->SetUseImageSpacing(false);
  filter->SetVariance(sigma_voxels * sigma_voxels);
  apply(*filter, image);
}

IndexBox box_around(const Vec3i& first, const Vec3i& last, const Vec3i& margin, const Lattice& lattice) {
  const Vec3i start = (first - margin).cwiseMax(0);
  const Vec3i end = (last + margin + Vec3i::Ones()).cwiseMin(lattice.dims);
  return {start, end - start};
}

Pieces connected_pieces(const Mask& mask, const Lattice& lattice) {
  Mask input = mask;
  const auto label = itk::ConnectedComponentImageFilter<MaskImage, LabelImage>::New();
  label->SetInput(view(input, lattice.dims));
  const auto by_size = itk::RelabelComponentImageFilter<LabelImage, LabelImage>::New();
  by_size->SetInput(label->GetOutput());
  by_size->Update();
  Pieces out;
  const std::uint32_t* first = by_size->GetOutput()->GetBufferPointer();
  out.label.assign(first, first + input.size());
  out.list.resize(by_size->GetNumberOfObjects());
  for (std::size_t n = 0; n < out.list.size(); ++n) out.list[n].label = static_cast<std::uint32_t>(n + 1);
  lattice.for_each([&](const Vec3i& voxel, std::size_t at) {
    if (out.label[at] != 0) out.list[out.label[at] - 1].add(voxel);
  });
  return out;
}

void close_mask(Mask& mask, const Lattice& lattice, double radius_mm) {
  const Vec3i radius = (radius_mm * lattice.spacing_mm.cwiseInverse()).array().round().cast<int>();
  if (radius.isZero()) return;
  std::vector<Vec3i> ball;
  const auto reach2 = [&](int n, int axis) { return std::pow(n / (radius[axis] + 0.5), 2); };
  for_each_voxel({0, -radius.y(), -radius.z()}, {0, radius.y(), radius.z()}, [&](const Vec3i& place) {
    const double rest = 1 - reach2(place.y(), 1) - reach2(place.z(), 2);
    if (rest >= 0) ball.emplace_back(static_cast<int>(std::sqrt(rest) * (radius.x() + 0.5)), place.y(), place.z());
  });
  // With room for what the dilation adds beyond the lattice: the erosion needs it.
  Lattice room = lattice;
  room.dims += 2 * radius;
  Mask wide(static_cast<std::size_t>(room.size()), 0);
  lattice.for_each([&](const Vec3i& voxel, std::size_t at) { wide[room.index(voxel + radius)] = mask[at]; });
  wide = complement(dilated(complement(dilated(wide, room, ball)), room, ball));
  lattice.for_each([&](const Vec3i& voxel, std::size_t at) { mask[at] = wide[room.index(voxel + radius)]; });
}

std::int64_t fill_holes(Mask& mask, const Lattice& lattice) {
  Mask background = complement(mask);
  const Vec3i& d = lattice.dims;
  std::uint32_t count = 0;
  const std::vector<std::uint32_t> part = label_background(background, d, count);
  std::vector<std::uint8_t> open(count + std::size_t{1}, 0);
  for (int across = 0; across < 3; ++across) {
    for (const int level : {0, d[across] - 1}) mark_open_parts(part, lattice, across, level, open);
  }
  std::int64_t filled = 0;
  for (std::size_t at = 0; at < mask.size(); ++at) {
    if (part[at] == 0 || open[part[at]]) continue;
    mask[at] = 1;
    ++filled;
  }
  return filled;
}

}  // namespace reamsim::ct

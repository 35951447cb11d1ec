// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>
#include <itkCurvatureAnisotropicDiffusionImageFilter.h>
#include <itkImportImageFilter.h>

#include <random>

#include "sim/scan/segment.h"

namespace reamsim::test {
namespace {

/// The result of ITK's filter, with its largest stable time step.
std::vector<float> diffused_by_itk(ct::AlignedImage image, unsigned iterations, double conductance) {
  using Image = itk::Image<float, 3>;
  const auto importer = itk::ImportImageFilter<float, 3>::New();
  itk::ImportImageFilter<float, 3>::RegionType region;
  for (unsigned axis = 0; axis < 3; ++axis) region.SetSize(axis, static_cast<unsigned>(image.lattice.dims[axis]));
  importer->SetRegion(region);
  importer->SetSpacing(image.lattice.spacing_mm.data());
  importer->SetImportPointer(image.value.data(), image.value.size(), false);
  const auto filter = itk::CurvatureAnisotropicDiffusionImageFilter<Image, Image>::New();
  filter->SetInput(importer->GetOutput());
  filter->SetNumberOfIterations(iterations);
  filter->SetConductanceParameter(conductance);
  filter->SetTimeStep(image.lattice.spacing_mm.minCoeff() / 16);
  filter->Update();
  const float* values = filter->GetOutput()->GetBufferPointer();
  return {values, values + image.value.size()};
}

TEST(CurvatureDiffusion, IsThatOfItk) {
  constexpr unsigned kSeed = 20261130;
  std::mt19937 random(kSeed);
  std::normal_distribution<float> noise(0, 60);
  for (const Vec3i& dims : {Vec3i(31, 22, 27), Vec3i(40, 1, 9), Vec3i(2, 9, 2), Vec3i(1, 1, 5)}) {
    ct::AlignedImage image{{dims, {0.7, 0.9, 1.4}, Vec3::Zero()}, {}};
    image.lattice.for_each([&](const Vec3i& v, std::size_t) {
      image.value.push_back((v.cast<double>().norm() < 15 ? 900.0F : -50.0F) + noise(random));
    });
    for (const double conductance : {0.5, 1.5, 3.0}) {
      const std::vector<float> expected = diffused_by_itk(image, 4, conductance);
      ct::AlignedImage ours = image;
      ct::curvature_anisotropic_filter(ours, 4, conductance);
      for (std::size_t i = 0; i < expected.size(); ++i) {
        ASSERT_FLOAT_EQ(ours.value[i], expected[i])
            << "seed " << kSeed << ", voxel " << i << " of " << dims.transpose();
      }
    }
    // Without a gradient nothing flows.
    std::ranges::fill(image.value, 7.0F);
    ct::AlignedImage flat = image;
    ct::curvature_anisotropic_filter(flat, 2, 1.5);
    EXPECT_EQ(flat.value, image.value);
  }
}

}  // namespace
}  // namespace reamsim::test

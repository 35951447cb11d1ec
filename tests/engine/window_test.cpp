// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Windows of smooth motion: the polynomials of kernels/window.h against the fractions that they replace.
#include <gtest/gtest.h>

#include <iostream>
#include <random>

#include "kernels/window.h"

namespace reamsim::test::window_tests {
namespace {

constexpr unsigned kSeed = 20200416;
constexpr int kFrames = 64;

MotionWindow window_of(int frames) {
  MotionWindow w{};
  w.first.frame = 64;
  w.middle.frame = 64 + frames / 2;
  w.last.frame = 64 + frames - 1;
  w.per_frame = 2.0F / static_cast<float>(frames);
  w.first_time = rs_window_time(&w, w.first.frame);
  w.last_time = rs_window_time(&w, w.last.frame);
  return w;
}

Clip clip_of(const float* n, float away) {
  Clip clip{};
  for (int i = 0; i < 3; ++i) clip.plane.n[i] = n[i];
  clip.plane.away = away;
  return clip;
}

/// Largest error of the fill through a window in which a plane with normal `n` advances from `from` to `to`, voxels;
/// -1 where the voxel is cut frame by frame.
int worst_error(const float* n, float from, float to) {
  const MotionWindow w = window_of(kFrames);
  const auto at = [&](rs_i32 frame) {
    return from + (to - from) * static_cast<float>(frame - w.first.frame) / static_cast<float>(kFrames - 1);
  };
  const Clip first = clip_of(n, from), middle = clip_of(n, at(w.middle.frame)), last = clip_of(n, to);
  WindowVoxel v;
  rs_fit_fraction(&w, &first, &middle, &last, &v);
  if (v.pieces == 0) return -1;
  int worst = 0;
  for (rs_i32 frame = w.first.frame; frame <= w.last.frame; ++frame) {
    const int expected = static_cast<int>(std::floor(rs_outside_fraction(n, at(frame)) * RS_WHOLE_FILL + 0.5F));
    const int found = rs_window_outside(&v, rs_window_time(&w, frame), RS_WINDOW_PIECES);
    worst = std::max(worst, std::abs(found - expected));
  }
  return worst;
}

TEST(Window, TheFractionIsThatOfThePlane) {
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> u(0, 1);
  std::normal_distribution<float> g;
  for (const float way : {0.0F, 1e-4F, 0.01F, 0.05F, 0.13F, 0.3F, 0.5F}) {
    int framed = 0, worst = 0;
    constexpr int kTrials = 20000;
    for (int i = 0; i < kTrials; ++i) {
      // All directions, and those nearly along one or two axes.
      float n[3] = {g(random), g(random), g(random)};
      if (i % 3 == 1) n[i % 7 % 3] *= std::pow(10.0F, -5 * u(random));
      if (i % 3 == 2) n[0] *= std::pow(10.0F, -5 * u(random)), n[1] *= std::pow(10.0F, -5 * u(random));
      const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      for (float& c : n) c /= length;
      const float from = 1 - 2 * u(random);
      const int error = worst_error(n, from, from - way);
      if (error < 0) ++framed;
      if (error > 4 && worst <= 4)
        std::cout << n[0] << ' ' << n[1] << ' ' << n[2] << " from " << from << " way " << way << ": " << error << '\n';
      worst = std::max(worst, error);
    }
    std::cout << "way " << way << ": worst " << worst << " of 65535, frame by frame " << 100.0 * framed / kTrials
              << " %\n";
    EXPECT_LE(worst, 4) << way;
  }
}

}  // namespace
}  // namespace reamsim::test::window_tests

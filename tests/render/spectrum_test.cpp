// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace reamsim {
namespace {

constexpr double kSpin_hz = 4;  // 240 rpm

/// Two seconds at 1 kHz, with a second in the air before and after; `torque` of the time since contact.
std::vector<TorqueSample> log_of(const std::function<double(double)>& torque, double contact_s = 2) {
  std::vector<TorqueSample> log;
  for (int i = 0; i < 4000; ++i) {
    const double time_s = 0.001 * i, touching_s = time_s - 1;
    const bool touching = touching_s >= 0 && touching_s < contact_s;
    log.push_back({time_s, 2 * std::numbers::pi * kSpin_hz * time_s, touching ? torque(touching_s) : 0});
  }
  return log;
}

double sine(double frequency_hz, double time_s) {
  return std::sin(2 * std::numbers::pi * frequency_hz * time_s);
}

TEST(Spectrum, FindsTheTeethOnARisingTorque) {
  const TorqueSpectrum found =
      torque_spectrum(log_of([](double t) { return 400 * (2 - std::exp(-t)) + 60 * sine(24, t) + 20 * sine(48, t); }));
  EXPECT_NEAR(found.spin_hz, kSpin_hz, 1e-9);
  ASSERT_EQ(found.peaks.size(), 2u);
  EXPECT_NEAR(found.peaks[0].frequency_hz, 24, 0.3);
  EXPECT_NEAR(found.peaks[0].torque_nmm, 60, 2);
  EXPECT_NEAR(found.peaks[1].frequency_hz, 48, 0.3);
  EXPECT_NEAR(found.peaks[1].torque_nmm, 20, 1);
  EXPECT_NEAR(found.lines.back().frequency_hz, 500, 1e-6) << "half the frame rate";
}

TEST(Spectrum, PausesBetweenTeethDoNotEndIt) {
  // One tooth, in contact for a third of the turn.
  const TorqueSpectrum found =
      torque_spectrum(log_of([](double t) { return std::fmod(t * kSpin_hz, 1.0) < 1.0 / 3 ? 300.0 : 0.0; }));
  ASSERT_FALSE(found.peaks.empty());
  EXPECT_NEAR(found.peaks[0].frequency_hz, kSpin_hz, 0.3);
  // First line of a rectangle's Fourier series.
  EXPECT_NEAR(found.peaks[0].torque_nmm, 2 * 300 / std::numbers::pi * std::sin(std::numbers::pi / 3), 10);
}

TEST(Spectrum, NeedsFourTurnsAndASpin) {
  EXPECT_TRUE(torque_spectrum(log_of([](double) { return 100; }, 0.9)).lines.empty());
  EXPECT_TRUE(torque_spectrum(log_of([](double) { return 0; })).lines.empty());
  std::vector<TorqueSample> still = log_of([](double t) { return 100 + sine(24, t); });
  for (TorqueSample& sample : still) sample.angle_rad = 0;
  EXPECT_TRUE(torque_spectrum(still).lines.empty());
  EXPECT_TRUE(torque_spectrum({}).lines.empty());
}

}  // namespace
}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/verify/closed_forms.h"

namespace reamsim::verify {

// Feeds of a head under a thrust, from the closed forms of its forces (docs/feeds.md, 10). `feed_mm_s` of the head is
// not used.

/// A of A·v + B·v² = F, N·s/mm.
double linear_resistance(const SteadyPlunge& head);
/// The feed in full contact from A·v + B·v² = F, mm/s.
double quadratic_feed(const SteadyPlunge& head, double thrust_n);
/// The feed in full contact from all terms of the force, mm/s.
double balanced_feed_of(const SteadyPlunge& head, double thrust_n);
/// The time in which a head without bore comes from first contact to a depth below its full contact, s: the integral of
/// the inverse feed, which is that of the force on the cap in contact, with the law's speed floor.
double time_to_depth_s(const SteadyPlunge& head, double thrust_n, double max_feed_mm_s, double depth_mm);
/// The travel of a mass from rest in full contact, mm: M·dv/dt = F − A·v − B·v².
double travel_of_mass_mm(const SteadyPlunge& head, double thrust_n, double mass_kg, double time_s);

}  // namespace reamsim::verify

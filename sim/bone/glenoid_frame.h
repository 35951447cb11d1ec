// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/scenario/scenario.h"

namespace reamsim {

/// The glenoid frame of the scenario, from centre/normal/superior or from landmarks; nullopt without either,
/// and where the face must be found (find_glenoid.h). `superior`
/// is projected perpendicular to the normal. With landmarks the normal is the Friedman axis (trigonum spinae to glenoid
/// centre, lateral), and superior lies in the scapular plane, away from the inferior angle. The frame is right-handed
/// on both sides: +x is posterior on a left scapula, anterior on a right one. Throws InputError: an incomplete set,
/// zero or parallel directions, collinear landmarks, an unknown side.
std::optional<GlenoidFrame> glenoid_frame(const GlenoidSettings& settings, BodySide side);

/// The scapular axes if the normal of the frame is the Friedman axis. An unknown side counts as left.
ScapularAxes axes_of(const GlenoidFrame& glenoid, BodySide side);

}  // namespace reamsim

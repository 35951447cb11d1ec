// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/record/verification.h"

namespace reamsim {

/// The report of a verification: tables in Markdown, with a reference to verification.png.
std::string verification_markdown(const verify::Findings& findings);
/// The report as JSON; see docs/columns.md.
std::string verification_json(const verify::Findings& findings);

/// Writes verification.md, verification.json, and the figure of the refinements (verification.gp, .png, .svg) into
/// `dir`. Throws RunError when a file cannot be written, or gnuplot is missing or fails.
void write_verification(const std::string& dir, const verify::Findings& findings);

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/predicted_run.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/record/snapshot.h"
#include "sim/scene/contact_forecast.h"
#include "sim/tool/envelope.h"

namespace reamsim {
namespace {

/// The tool's path, with the frames of the run.
ToolPath path_of_pass(const ToolPass& pass) {
  std::vector<PathSample> path;
  for (std::size_t i = 0; i < pass.poses.size(); ++i) {
    path.push_back({pass.poses[i], static_cast<std::size_t>(pass.pose_frames[i])});
  }
  return {std::move(path), tool_reach_mm(pass.tool)};
}

/// Adds a pass after those so far.
void add_pass(const RunInputs& run, std::size_t index, PredictedRun& out) {
  const ToolPass& pass = run.passes[index];
  const Profile tool = envelope_of_revolution(pass.tool).profile;
  const auto contact = forecast_contact_frames(*run.voxmap, out.bone.fill, tool, path_of_pass(pass));
  if (contact) out.contact.push_back(*contact);
  PredictedBone bone = predict_swept_bone(*run.voxmap, out.bone.fill, tool, pass.poses, run.whole_voxels);
  if (!bone.touches) return;
  out.bone = std::move(bone);
  out.pass = index;
}

}  // namespace

double tool_reach_mm(const TriangleMesh& tool) {
  double reach_mm = 0;
  for (const Vec3& v : tool.vertices) reach_mm = std::max(reach_mm, v.norm());
  return reach_mm;
}

PredictedRun predict_run(const RunInputs& run) {
  PredictedRun out{.bone = {.fill = run.fill, .deepest = run.passes.front().poses.front()}, .contact = {}};
  for (std::size_t i = 0; i < run.passes.size(); ++i) {
    try {
      add_pass(run, i, out);
    } catch (const InputError& error) {
      throw InputError({tool_path(run.dir, static_cast<int>(i) + 1), 0, 0}, "", error.what(),
                       "expected the tool of a run");
    }
  }
  return out;
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/run_view.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numbers>
#include <stdexcept>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/mesh/mesh_io.h"
#include "sim/record/recorder.h"
#include "sim/scene/contact_forecast.h"
#include "sim/tool/profile.h"

namespace reamsim {
namespace {

std::string log_path(const std::string& dir) {
  return dir + "/forces.csv";
}

template <class Compute>
auto lazily(Compute compute) {
  return std::async(std::launch::deferred, std::move(compute)).share();
}

/// Motion of the tool between two poses that are kept of a long run, voxels: as finely as its swept volume is sampled.
constexpr double kPathStep_voxels = 0.5;

/// The fill with all voxels that an earlier run removed restored, because depth is measured from before it.
FillBricks with_removed_voxels_restored(const FillBricks& fill) {
  FillBricks out = fill;
  fill.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& brick) {
    FillBricks::Brick whole = brick;
    std::replace(whole.begin(), whole.end(), std::uint16_t{0}, FillBricks::kWhole);
    out.put(coord, whole);
  });
  return out;
}

/// The inputs in the folder of a run, without the poses.
RunInputs read_inputs(const std::string& dir, const std::shared_ptr<const StoredBone>& bone) {
  RunInputs out;
  out.dir = dir;
  out.voxmap = {bone, &bone->voxmap};
  out.glenoid = bone->anatomy.glenoid;
  out.side = bone->anatomy.side;
  out.whole_voxels = bone->erosion == "remove" || bone->erosion == "wear";
  out.frames = snapshot_frames(dir);
  if (out.frames.empty())
    refuse_file(dir + "/snapshots", "contains no snapshot", "expected the results folder of a run");
  out.fill = out.frames.front() == 0 ? fill_at(out, 0) : FillBricks(out.voxmap->grid.dims);
  out.passes = read_tools(dir);
  return out;
}

/// With the means and the rows that the pictures show.
LogOptions log_options(const RunInputs& run) {
  return {.mean_travel_mm = run.whole_voxels ? run.voxmap->grid.voxel_mm : 0, .keep = run.frames};
}

/// Height of the tool's head above its lowest point. The shaft may extend beyond the picture.
constexpr double kHead_mm = 12;

void target_glenoid(ViewTarget& target, const GlenoidFrame& glenoid, BodySide side, const std::string& frame) {
  const Mat3 axes = glenoid.bone_from_glenoid.linear();
  target.bone_from_glenoid = glenoid.bone_from_glenoid;
  target.focus_mm = glenoid.bone_from_glenoid.translation();
  target.outward = axes.col(2);
  target.superior = axes.col(1);
  target.anatomical = true;
  // +x of G is superior × lateral: posterior on a left shoulder, anterior on a right one.
  if (side == BodySide::left) target.anterior = -axes.col(0);
  if (side == BodySide::right) target.anterior = axes.col(0);
  // In LPS +y is posterior on both sides.
  if (side == BodySide::unknown && frame == "LPS") {
    target.anterior = axes(1, 0) > 0 ? Vec3(-axes.col(0)) : Vec3(axes.col(0));
  }
}

void target_tool(ViewTarget& target) {
  target.focus_mm = target.bone_from_tool.translation();
  target.outward = target.bone_from_tool.linear().col(2);
  // Up in the picture is +z of B, or +y where the tool points along z.
  const Vec3 up = std::abs(target.outward.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitY();
  target.superior = (up - up.dot(target.outward) * target.outward).normalized();
}

/// The farthest point of the tool from its origin, mm.
double tool_reach_mm(const TriangleMesh& tool) {
  double reach_mm = 0;
  for (const Vec3& v : tool.vertices) reach_mm = std::max(reach_mm, v.norm());
  return reach_mm;
}

/// Extends the target by tools on their paths; the head is that of the pass of the greatest depth.
void include_tools(ViewTarget& target, const RunInputs& run, std::size_t deepest_pass) {
  const TriangleMesh& deepest = run.passes[deepest_pass].tool;
  const double lowest_mm = deepest.bounds().min.z();
  for (const Vec3& v : deepest.vertices) {
    if (v.z() < lowest_mm + kHead_mm) target.tool_head_mm.push_back(target.bone_from_tool * v);
  }
  for (const ToolPass& pass : run.passes) {
    const double reach_mm = tool_reach_mm(pass.tool);
    for (const PathSample& at : pass.path) {
      target.radius_mm = std::max(target.radius_mm, (at.pose.position_mm - target.focus_mm).norm() + reach_mm);
    }
  }
}

/// The glenoid if known; else the tool at its greatest depth, seen along its axis. `bone`: unreamed, voxel index space.
ViewTarget make_view_target(const RunInputs& run, const PredictedRun& predicted, const IsoSurface& bone) {
  ViewTarget target;
  target.bone_from_tool = predicted.bone.deepest.bone_from_tool();
  run.glenoid ? target_glenoid(target, *run.glenoid, run.side, run.voxmap->frame) : target_tool(target);
  const VoxelGrid& grid = run.voxmap->grid;
  for (const Eigen::Vector3f& p : bone.points) {
    target.bone_mm.emplace_back(grid.origin_mm + grid.voxel_mm * (p.cast<double>() + Vec3::Constant(0.5)));
    target.radius_mm = std::max(target.radius_mm, (target.bone_mm.back() - target.focus_mm).norm());
  }
  include_tools(target, run, predicted.pass);
  return target;
}

}  // namespace

RunPath::RunPath(const RunInputs& run) : dir_(run.dir) {
  for (const ToolPass& pass : run.passes) {
    paths_.emplace_back(tool_reach_mm(pass.tool), kPathStep_voxels * run.voxmap->grid.voxel_mm, run.frames);
  }
}

void RunPath::add(const ToolPose& pose, std::int64_t frame, int pass) {
  const auto i = static_cast<std::size_t>(pass - 1);
  if (i >= paths_.size())
    refuse_file(tool_path(dir_, pass), "no such file", "the tool of pass " + std::to_string(pass));
  paths_[i].add(pose, static_cast<std::size_t>(frame));
}

void RunPath::give(RunInputs& run) {
  std::size_t used = 0;
  for (; used < paths_.size(); ++used) {
    run.passes[used].path = paths_[used].finish();
    if (run.passes[used].path.empty()) break;  // an interrupted run has not come to its last passes
  }
  run.passes.resize(used);
}

std::size_t RunInputs::pass_at(std::int64_t frame) const {
  std::size_t out = 0;
  while (out + 1 < passes.size() && std::cmp_less_equal(passes[out + 1].path.front().frame, frame)) ++out;
  return out;
}

const ToolPose& RunInputs::pose_at(std::int64_t frame) const {
  const std::vector<PathSample>& path = passes[pass_at(frame)].path;
  const auto after = std::ranges::upper_bound(path, static_cast<std::size_t>(frame), {}, &PathSample::frame);
  return (after == path.begin() ? after : std::prev(after))->pose;
}

FillBricks fill_at(const RunInputs& run, std::int64_t frame) {
  if (run.dir.empty()) return run.fill;
  FillBricks fill(run.voxmap->grid.dims);
  apply_snapshot(run.dir, frame, fill);
  return fill;
}

std::vector<ToolPass> read_tools(const std::string& dir) {
  std::vector<ToolPass> out;
  do {
    out.push_back({.tool = read_mesh(tool_path(dir, static_cast<int>(out.size()) + 1), 1.0)});
  } while (std::filesystem::exists(tool_path(dir, static_cast<int>(out.size()) + 1)));
  return out;
}

std::shared_ptr<RunData::Stored> RunData::read_stored(const std::string& dir) {
  if (!std::filesystem::is_directory(dir)) refuse_file(dir, "folder not found", "the output folder of a run");
  auto bone = std::make_shared<StoredBone>(read_stored_bone(dir + "/reamed.vdb"));
  FillBricks fill = std::exchange(bone->voxmap.fill, FillBricks(bone->voxmap.grid.dims));
  RunInputs inputs = read_inputs(dir, bone);
  RunPath path(inputs);
  LogOptions options = log_options(inputs);
  options.each = [&path](const ForceRow& row) { path.add(row.pose, row.frame, row.pass); };
  ForceLog log = read_force_log(log_path(dir), options);
  for (const std::int64_t frame : inputs.frames) static_cast<void>(log.at(frame, log_path(dir)));
  path.give(inputs);
  return std::make_shared<Stored>(Stored{std::move(fill), std::move(log), std::move(inputs)});
}

RunData::Prediction RunData::predict_outcome(const RunInputs& inputs) {
  PredictedRun predicted = predict_run(inputs);
  UnreamedSurface unreamed(*inputs.voxmap, with_removed_voxels_restored(inputs.fill), predicted.bone.fill);
  ViewTarget target = make_view_target(inputs, predicted, unreamed.surface);
  return {std::move(unreamed), std::move(target), predicted.contact};
}

RunData::RunData(std::string dir) : dir_(std::move(dir)) {
  const auto stored = lazily([folder = dir_] { return read_stored(folder); });
  fill_ = lazily([stored] { return std::move(stored.get()->fill); });
  log_ = lazily([stored] { return std::move(stored.get()->log); });
  inputs_ = lazily([stored] { return std::move(stored.get()->inputs); });
  predict(std::launch::deferred);
}

RunData::RunData(RunInputs inputs)
    : dir_(inputs.dir), inputs_(lazily([known = std::move(inputs)]() mutable { return std::move(known); })) {
  predict(std::launch::deferred);
}

void RunData::predict(std::launch when) {
  prediction_ = std::async(when, [inputs = inputs_] { return predict_outcome(inputs.get()); }).share();
  unreamed_tiles_ = lazily([inputs = inputs_, prediction = prediction_] {
    const UnreamedSurface& unreamed = prediction.get().unreamed;
    return BoneTiles(BoneFields(*inputs.get().voxmap, unreamed.before, unreamed));
  });
}

void RunData::finish_log() {
  log_ = lazily([dir = dir_, inputs = inputs_] { return read_force_log(log_path(dir), log_options(inputs.get())); });
}

void RunData::finish(FillBricks fill) {
  fill_ = lazily([known = std::move(fill)]() mutable { return std::move(known); });
}

namespace {

/// The circle swept by the tool's outermost point, in B.
std::vector<Vec3> widest_circle(const TriangleMesh& tool, const Rigid& bone_from_tool) {
  const Vec3 widest = *std::ranges::max_element(tool.vertices, {}, [](const Vec3& v) { return v.head<2>().norm(); });
  const double radius = widest.head<2>().norm();
  std::vector<Vec3> circle;
  constexpr int kPoints = 128;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPoints;
    circle.emplace_back(bone_from_tool * Vec3(radius * std::cos(angle), radius * std::sin(angle), widest.z()));
  }
  return circle;
}

/// Least fraction of the run's greatest force that is drawn as an arrow.
constexpr double kMinArrowFraction = 0.01;

}  // namespace

Scale depth_scale(const RunData& run, double depth_max_mm) {
  return depth_max_mm > 0 ? scale_exactly(depth_max_mm) : scale_up_to(run.unreamed().deepest_mm);
}

RunView::RunView(const RunData& run, const RenderSettings& settings)
    : run_(run), settings_(settings), depth_scale_(reamsim::depth_scale(run, settings.depth_max_mm)) {}

PageLayout RunView::frame_page() const {
  const int height_px = std::min(settings_.height_px, settings_.frame_height_px);
  const double width_px = static_cast<double>(settings_.width_px) * height_px / settings_.height_px;
  return page_layout(std::max(1, static_cast<int>(std::lround(width_px))), height_px);
}

Camera RunView::camera(const std::string& name, int width_px, int height_px) const {
  for (const UserCamera& own : settings_.user_cameras) {
    if (own.name == name) return make_user_camera(own, run_.target(), width_px, height_px);
  }
  return make_camera(from_name<CameraView>(name).value(), run_.target(), width_px, height_px);
}

std::optional<PlacedTool> RunView::tool_at(std::int64_t frame) const {
  if (!settings_.tool) return std::nullopt;
  const ToolPose& pose = run_.inputs().pose_at(frame);
  // A positive spin is about −z of T.
  const Rigid bone_from_tool = pose.bone_from_tool() * Eigen::AngleAxisd(-pose.spin_angle_rad, Vec3::UnitZ());
  return PlacedTool{bone_from_tool, run_.inputs().pass_at(frame)};
}

Rigid RunView::map_from_bone() const {
  const ViewTarget& target = run_.target();
  return (target.bone_from_glenoid ? *target.bone_from_glenoid : target.bone_from_tool).inverse();
}

Labels RunView::labels(const Camera& camera, const std::optional<PlacedTool>& tool) const {
  Labels labels;
  labels.legends.push_back({"Reamed depth", "mm", depth_colors(), depth_scale_});
  if (camera.cut_plane) labels.legends.push_back({"Bone density", "g/cm³", density_colors(), density_scale()});
  const ViewTarget& target = run_.target();
  if (target.anatomical) {
    labels.directions = {{"superior", target.superior}, {"lateral", target.outward}};
    if (target.anterior) labels.directions.emplace_back("anterior", *target.anterior);
  }
  if (tool && !camera.shows_tool) {
    labels.outline_mm = widest_circle(run_.inputs().passes[tool->pass].tool, tool->bone_from_tool);
  }
  return labels;
}

Captions::Captions(const ForceLog& log, bool arrows)
    : log_(log), mean_(log.mean_travel_mm > 0 ? "mean " : ""), arrows_(arrows) {
  for (const ForceRow& row : log_.rows) max_force_n_ = std::max(max_force_n_, row.layer_force_n.norm());
}

Captions::Values Captions::at(const ForceRow& row) const {
  const bool several = log_.rows.back().pass > 1;
  Values out{{several ? "pass " + std::to_string(row.pass) + ", time" : "time", fixed_text(row.time_s, 3) + " s"},
             {"tool depth", depth_text(row.depth_mm)},
             {mean_ + "axial force", fixed_text(row.layer_axial_force_n, 1) + " N"},
             {mean_ + "spin torque", fixed_text(row.layer_spin_torque_nmm, 0) + " N·mm"},
             {"removed", fixed_text(row.removed_mm3, 1) + " mm³"}};
  if (row.push) out.insert(out.begin() + 2, {"feed rate", fixed_text(row.push->feed_mm_s, 2) + " mm/s"});
  return out;
}

Captions::Values Captions::after(double deepest_mm) const {
  const KeyResults run = key_results_of(log_);
  return {{run.depth().name, run.depth().value()},
          {run.force().name, run.force().value()},
          {run.torque().name, run.torque().value()},
          {"removed", fixed_text(log_.rows.back().removed_mm3, 1) + " mm³"},
          {"greatest reamed depth", fixed_text(deepest_mm, 2) + " mm"}};
}

std::optional<ForceArrow> Captions::arrow(const ForceRow& row) const {
  const double force_n = row.layer_force_n.norm();
  if (!arrows_ || force_n == 0 || force_n < kMinArrowFraction * max_force_n_) return std::nullopt;
  // The resultant; a mean has only its axial part.
  const std::string name = mean_.empty() ? "resultant " : mean_ + "axial force ";
  return ForceArrow{row.pose.position_mm, row.layer_force_n / max_force_n_, name + fixed_text(force_n, 1) + " N"};
}

PredictedRun predict_run(const RunInputs& run) {
  PredictedRun out{.bone = {.fill = run.fill, .deepest = run.passes.front().path.front().pose}, .contact = {}};
  for (std::size_t i = 0; i < run.passes.size(); ++i) {
    const ToolPass& pass = run.passes[i];
    try {
      const Profile tool = envelope_of_revolution(pass.tool).profile;
      const auto contact =
          forecast_contact_frames(*run.voxmap, out.bone.fill, tool, ToolPath(pass.path, tool_reach_mm(pass.tool)));
      if (contact) out.contact.push_back(*contact);
      std::vector<ToolPose> poses;
      poses.reserve(pass.path.size());
      for (const PathSample& at : pass.path) poses.push_back(at.pose);
      PredictedBone bone = predict_swept_bone(*run.voxmap, out.bone.fill, tool, poses, run.whole_voxels);
      if (!bone.touches) continue;
      out.bone = std::move(bone);
      out.pass = i;
    } catch (const InputError& error) {
      refuse_file(tool_path(run.dir, static_cast<int>(i) + 1), error.what(), "expected the tool of a run");
    }
  }
  return out;
}

}  // namespace reamsim

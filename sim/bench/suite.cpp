// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/suite.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/bench/measure.h"
#include "sim/bench/paper.h"

namespace reamsim::bench {

namespace {

constexpr double kPoseTolerance = 0.05;

std::string size_text(const SizePair& size) {
  return "voxmap " + std::to_string(size.voxmap) + "³, shell " + std::to_string(size.shell) + "³";
}

/// Counts the points that touch at the stored depths. Throws RunError where they differ from the cases.
void verify_poses(const Plan& plan, const BenchSetup& setup, Findings& findings) {
  const auto points = static_cast<double>(setup.tool->shell.codes.size());
  for (const Contact contact : kContacts) {
    int pose = 0;
    for (const Substep& frame : substeps_of(contact)) {
      PoseCount count{name_of(contact), pose++, count_touching(*setup.voxmap, *setup.tool, frame),
                      wanted_points(contact, points)};
      findings.poses.push_back(count);
      const double off = std::abs(static_cast<double>(count.points) - count.wanted);
      if (!plan.verify_poses || off <= kPoseTolerance * count.wanted) continue;
      throw RunError(fmt::format(
          "pose {} of the case {} touches {} points and should touch {} to within 5 %: the scene is not the "
          "one that its depths were found for",
          count.pose, count.contact, count.points, std::lround(count.wanted)));
    }
  }
}

/// Runs the plan with the current voxmap and the tools.
class Bench {
 public:
  Bench(const Plan& plan, const BenchControl& control) : plan_(plan), control_(control) {}

  Findings run() {
    const Stopwatch stopwatch;
    check_plan(plan_);
    const cl::DeviceInfo device = cl::choose_device(plan_.device);
    findings_.device = device.name;
    findings_.driver = device.platform_name + " " + device.driver;
    findings_.compute_units = device.compute_units;
    findings_.repetitions = plan_.repetitions;
    if (!plan_.sizes.empty()) {
      control_.progress("generating the bone");
      series_.emplace(plan_.sampled);
    }
    for (std::size_t i = 0; i < plan_.sizes.size(); ++i) measure(plan_.sizes[i], i + 1 == plan_.sizes.size());
    voxmap_ = {};
    measure_spheres(plan_, control_, findings_);
    findings_.seconds = stopwatch.seconds();
    return std::move(findings_);
  }

 private:
  const Tool& tool(int shell) {
    const auto [place, is_new] = tools_.try_emplace(shell);
    if (is_new) {
      place->second = cap_tool(shell);
      findings_.shell_points.emplace_back(shell, place->second.shell.codes.size());
    }
    return place->second;
  }

  void measure(const SizePair& size, bool last) {
    if (control_.stop()) throw Interrupted();
    control_.progress(size_text(size));
    if (voxmap_.grid.dims.x() != size.voxmap) {
      voxmap_ = {};
      voxmap_ = series_->at(size.voxmap);
    }
    const Tool& reamer = tool(size.shell);
    const BenchSetup setup{&voxmap_, &reamer, series_->box(size.voxmap), shell_box(reamer)};
    if (last) verify_poses(plan_, setup, findings_);
    const bool whole = size.shell == plan_.sizes.back().shell;
    const ProgramSet set = make_programs(plan_, setup, size, whole, findings_.skipped);
    measure_memory(set, findings_);
    measure_contact(set, size, Contact::severe, last);
    if (whole && plan_.light) measure_contact(set, size, Contact::light, last);
    if (whole) measure_contact(set, size, Contact::none, last);
    if (plan_.details && whole) measure_scatter(plan_, set, control_, findings_);
    if (!plan_.details || !last) return;
    control_.progress("VOI");
    measure_voi(plan_, set, control_, findings_);
    control_.progress("batches");
    measure_batches(plan_, set, control_, findings_);
    control_.progress("plunge");
    measure_plunge(plan_, set, control_, findings_);
    measure_exact_case(plan_, set.setup, size, "plunge", control_, findings_);
  }

  /// `exact` has no shell: the last size is enough.
  void measure_contact(const ProgramSet& set, const SizePair& size, Contact contact, bool last) {
    measure_case(plan_, set, contact, control_, findings_);
    if (last) measure_exact_case(plan_, set.setup, size, name_of(contact), control_, findings_);
  }

  const Plan& plan_;
  const BenchControl& control_;
  Findings findings_;
  std::optional<BoneSeries> series_;
  FilledVoxmap voxmap_;
  std::map<int, Tool> tools_;
};

/// Usual seconds of the steps of a plan on two cores, in the order in which they call progress(). Only ratios matter.
std::vector<double> usual_seconds(const Plan& plan) {
  std::vector<double> out;
  if (!plan.sizes.empty()) out.push_back(3);  // the bone
  for (const SizePair& size : plan.sizes) out.push_back(30 * std::pow(size.voxmap / 1024.0, 2));
  if (!plan.sizes.empty() && plan.details) {
    out.back() += 300;                           // of the last size every case, and scatter
    out.insert(out.end(), {60.0, 10.0, 150.0});  // VOI, batches, plunge
  }
  for (const double voxel_mm : plan.sphere_voxels_mm) {
    for (const std::string& engine : plan.engines) {
      out.push_back(0.2 + (engine == "implicit" ? 55 : 10) * std::pow(0.04 / voxel_mm, 3));
    }
  }
  return out;
}

}  // namespace

Plan full_plan() {
  Plan plan;
  plan.engines = engine_names();
  for (const int voxmap : kVoxmaps) {
    for (const int shell : kShells) plan.sizes.push_back({voxmap, shell});
  }
  return plan;
}

Plan sphere_plan() {
  Plan plan;
  plan.engines = {"exact"};
  return plan;
}

Plan quick_plan() {
  Plan plan;
  plan.engines = {"exact", "bricked", "direct"};
  plan.sizes = {{256, 256}, {256, 1024}, {1024, 1024}};
  plan.light = false;
  plan.details = false;
  plan.sphere_voxels_mm = {};
  return plan;
}

void check_plan(const Plan& plan) {
  for (const std::string& engine : plan.engines) {
    const auto& known = engine_names();
    if (std::find(known.begin(), known.end(), engine) != known.end()) continue;
    std::string names;
    for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
    throw InputError({}, "--engines", "\"" + engine + "\"", "expected some of " + names);
  }
  if (plan.device == "serial") {
    throw InputError({}, "--device", "\"serial\" is not an OpenCL device",
                     "the benchmark compares programs on an OpenCL device");
  }
  cl::choose_device(plan.device);
}

Findings run_bench(const Plan& plan, const BenchControl& control) {
  const std::vector<double> steps = usual_seconds(plan);
  const double total = std::accumulate(steps.begin(), steps.end(), 0.0);
  std::size_t begun = 0;
  double behind = 0;
  BenchControl counted = control;
  counted.progress = [&](const std::string& step) {
    control.progress(step);
    control.part(total > 0 ? behind / total : 0, step);
    if (begun < steps.size()) behind += steps[begun++];
  };
  return Bench(plan, counted).run();
}

std::string find_depths(int voxmap, int shell) {
  const FilledVoxmap bone = BoneSeries().at(voxmap);
  const Tool tool = cap_tool(shell);
  const auto points = static_cast<double>(tool.shell.codes.size());
  std::string out;
  for (const Approach& approach : kApproaches) {
    const auto depth = [&](Contact contact) {
      return find_depth(bone, tool, approach, wanted_points(contact, points));
    };
    out += fmt::format("{{{:.4f}, {:.4f}, {:.4f}}}\n", depth(Contact::severe), depth(Contact::light),
                       depth(Contact::none));
  }
  return out;
}

}  // namespace reamsim::bench

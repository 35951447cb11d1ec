// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/measure.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <numeric>
#include <optional>

#include "sim/base/error.h"
#include "sim/base/statistics.h"
#include "sim/base/stopwatch.h"
#include "sim/bench/paper.h"

namespace reamsim::embedded {
extern const char* const kernel_peaks;
}

namespace reamsim::bench {

namespace {

/// The programs that touch voxels with a shell or the tool's surface, fastest engine first. `exact` needs the motion
/// before a frame (whole_frames.cpp).
const Label kPrograms[] = {{"bricked", "deterministic"}, {"direct", "deterministic"}, {"direct", "published"},
                           {"octree", "deterministic"},  {"octree", "published"},     {"implicit", "deterministic"}};

constexpr int kRepetitions = 5;

/// The shortest time of a kernel, s.
double shortest(const cl::Kernel& kernel, const cl::Device& device, std::size_t items) {
  double best = INFINITY;
  for (int i = 0; i < kRepetitions; ++i) {
    std::vector<cl::Event> events;
    events.push_back(kernel.launch(device, items, 1));
    device.finish();
    best = std::min(best, cl::take_seconds(events).front());
  }
  return best;
}

constexpr double kPoseTolerance = 0.05;

/// Counts the points that touch at the stored depths. Throws RunError where they differ from the cases.
void verify_poses(const Plan& plan, const BenchSetup& setup, Json& report) {
  const auto points = static_cast<double>(setup.tool->shell.codes.size());
  for (const Contact contact : kContacts) {
    int pose = 0;
    for (const Substep& frame : substeps_of(contact)) {
      const std::int64_t touching = count_touching(*setup.voxmap, *setup.tool, frame);
      const double wanted = wanted_points(contact, points);
      report["poses"].push_back({{"case", name_of(contact)}, {"pose", pose}, {"points", touching}, {"wanted", wanted}});
      const double off = std::abs(static_cast<double>(touching) - wanted);
      ++pose;
      if (!plan.verify_poses || off <= kPoseTolerance * wanted) continue;
      throw RunError(fmt::format(
          "pose {} of the case {} touches {} points and should touch {} to within 5 %: the scene is not the "
          "one that its depths were found for",
          pose - 1, name_of(contact), touching, std::lround(wanted)));
    }
  }
}

/// Usual seconds of the steps of a plan on two cores, in the order in which they begin. Only ratios matter.
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

/// Runs the plan with the current voxmap and the tools.
class Bench {
 public:
  Bench(const Plan& plan, const BenchControl& control)
      : plan_(plan), control_(control), usual_s_(usual_seconds(plan)) {}

  Json run() {
    const Stopwatch stopwatch;
    check_plan(plan_);
    const cl::DeviceInfo device = cl::choose_device(plan_.device);
    report_ = {{"program", "reamsim " REAMSIM_VERSION},
               {"device", device.name},
               {"driver", device.platform_name + " " + device.driver},
               {"compute_units", device.compute_units},
               {"repetitions", plan_.repetitions},
               {"seconds", 0}};
    for (const char* list : {"results", "memory", "phases", "voi", "batches", "scatter", "spheres"}) {
      report_[list] = Json::array();
    }
    report_["peaks"] = nullptr;
    for (const char* list : {"poses", "shells", "skipped"}) report_[list] = Json::array();
    if (!plan_.sizes.empty()) {
      begin("generating the bone");
      series_.emplace(plan_.sampled);
    }
    for (std::size_t i = 0; i < plan_.sizes.size(); ++i) measure(plan_.sizes[i], i + 1 == plan_.sizes.size());
    voxmap_ = {};
    measure_spheres(
        plan_, control_, [this](const std::string& step) { begin(step); }, report_);
    report_["seconds"] = stopwatch.seconds();
    return std::move(report_);
  }

 private:
  void begin(const std::string& step) {
    const auto past = usual_s_.begin() + static_cast<std::ptrdiff_t>(std::min(begun_++, usual_s_.size()));
    const double total = std::accumulate(usual_s_.begin(), usual_s_.end(), 0.0);
    control_.part(total > 0 ? std::accumulate(usual_s_.begin(), past, 0.0) / total : 0, step);
  }

  const Tool& tool(int shell) {
    const auto [place, is_new] = tools_.try_emplace(shell);
    if (is_new) {
      place->second = cap_tool(shell);
      report_["shells"].push_back({{"shell", shell}, {"points", place->second.shell.codes.size()}});
    }
    return place->second;
  }

  void measure(const SizePair& size, bool last) {
    if (control_.stop()) throw Interrupted();
    begin("voxmap " + std::to_string(size.voxmap) + "³, shell " + std::to_string(size.shell) + "³");
    if (voxmap_.grid.dims.x() != size.voxmap) {
      voxmap_ = {};
      voxmap_ = series_->at(size.voxmap);
    }
    const Tool& reamer = tool(size.shell);
    const BenchSetup setup{&voxmap_, &reamer, series_->box(size.voxmap), shell_box(reamer)};
    if (last) verify_poses(plan_, setup, report_);
    const bool whole = size.shell == plan_.sizes.back().shell;
    ProgramSet set{plan_, control_, report_, setup, size, {}};
    make_programs(set, whole);
    for (const auto& program : set.programs) add_memory(program->label().engine, size, program->bytes(), report_);
    measure_contact(set, Contact::severe, last);
    if (whole && plan_.light) measure_contact(set, Contact::light, last);
    if (whole) measure_contact(set, Contact::none, last);
    if (plan_.details && whole) measure_scatter(set);
    if (!plan_.details || !last) return;
    begin("VOI");
    measure_voi(set);
    begin("batches");
    measure_batches(set);
    begin("plunge");
    measure_plunge(set);
    measure_exact_case(set, std::nullopt);
  }

  /// `exact` has no shell: the last size is enough.
  static void measure_contact(const ProgramSet& set, Contact contact, bool last) {
    measure_case(set, contact);
    if (last) measure_exact_case(set, contact);
  }

  const Plan& plan_;
  const BenchControl& control_;
  std::vector<double> usual_s_;  ///< of the steps
  std::size_t begun_ = 0;
  Json report_;
  std::optional<BoneSeries> series_;
  FilledVoxmap voxmap_;
  std::map<int, Tool> tools_;
};

}  // namespace

const std::vector<std::string>& engine_names() {
  static const std::vector<std::string> names{"exact", "bricked", "direct", "octree", "implicit"};
  return names;
}

void measure_or_skip(Json row, Json& report, const std::function<void()>& measure) {
  const auto skip = [&](const char* reason) {
    row["reason"] = reason;
    report["skipped"].push_back(std::move(row));
  };
  try {
    measure();
  } catch (const InputError& error) {
    skip(error.what());
  } catch (const RunError& error) {
    skip(error.what());
  } catch (const std::bad_alloc&) {
    skip("not enough memory for the copy of the bone");
  }
}

void make_programs(ProgramSet& set, bool whole) {
  for (const Label& label : kPrograms) {
    if (std::ranges::count(set.plan.engines, label.engine) == 0) continue;
    if (!whole && label.engine == "implicit") continue;  // has no shell
    measure_or_skip(case_row(label, set.size, "all"), set.report,
                    [&] { set.programs.push_back(make_program(label, set.plan.device, set.setup)); });
  }
}

std::vector<std::vector<BatchSample>> run_alternately(const Programs& programs, const std::vector<Substep>& frames,
                                                      int repetitions, bool use_voi, const BenchControl& control) {
  constexpr int kRounds = 2;
  std::vector<std::vector<BatchSample>> samples(programs.size());
  for (int round = 0; round < kRounds; ++round) {
    const int timed = repetitions * (round + 1) / kRounds - repetitions * round / kRounds;
    for (const Substep& frame : frames) {
      for (std::size_t i = 0; i < programs.size(); ++i) {
        if (control.stop()) throw Interrupted();
        for (int repetition = -1; repetition < timed; ++repetition) {
          const BatchSample sample = programs[i]->run({&frame, 1}, use_voi);
          if (repetition >= 0) samples[i].push_back(sample);
          programs[i]->restore();
        }
      }
    }
  }
  return samples;
}

Latency frame_latency(SimulationInput& scene, Engine& engine, std::int64_t most, const std::function<bool()>& stop) {
  const Motion& motion = scene.motion;
  FrameSink sink;  // what becomes of the rows is no part of the latency
  Diagnostics ignored;
  FrameStepper stepper(scene, engine, sink, ignored);
  stepper.start(planned_motion(motion, 0));
  std::vector<double> ms;
  for (std::int64_t k = 1; k <= motion.last_frame() && std::ssize(ms) < most; ++k) {
    if (stop()) throw Interrupted();
    const FrameMotion frame = planned_motion(motion, k);
    const Stopwatch watch;
    stepper.add(frame);
    stepper.finish_batch();
    const double frame_ms = 1e3 * watch.seconds();
    if (stepper.last().contacts > 0) ms.push_back(frame_ms);
  }
  ms.erase(ms.begin(), ms.begin() + static_cast<std::ptrdiff_t>(std::min(kWarmUpFrames, ms.size())));
  if (ms.empty()) return {};
  return {.frames = std::ssize(ms),
          .median_ms = quantile(ms, 0.5),
          .p99_ms = quantile(ms, 0.99),
          .p999_ms = quantile(ms, 0.999),
          .most_ms = *std::ranges::max_element(ms)};
}

Json measure_peaks(const cl::DeviceInfo& info) {
  constexpr std::size_t kVector = 16 * sizeof(cl_float), kItems = 4096, kVectors = 512;
  constexpr cl_int kRounds = 4096;
  constexpr double kOperations = 256;  // of a round
  const cl::Device device(info);
  const cl::Program program = device.build("peaks.cl", embedded::kernel_peaks);
  const cl::Buffer<cl_uchar> from(device, kItems * kVectors * kVector, "memory to copy");
  const cl::Buffer<cl_uchar> to(device, from.count(), "a copy of memory");
  cl::Kernel multiply_add(program, "fused_multiply_adds"), copy(program, "copy_memory");
  multiply_add.set_from(0, to, kRounds);
  copy.set_from(0, from, to, static_cast<cl_int>(kVectors));
  return {{"gops", 1e-9 * kOperations * kRounds * kItems / shortest(multiply_add, device, kItems)},
          {"gb_s", 1e-9 * 2 * static_cast<double>(from.count()) / shortest(copy, device, kItems)},
          {"operations_per_voxel", kExactOperations},
          {"bytes_per_voxel", kExactBytes}};
}

Plan full_plan() {
  Plan plan;
  plan.engines = engine_names();
  for (const int voxmap : kVoxmaps) {
    for (const int shell : kShells) plan.sizes.push_back({voxmap, shell});
  }
  return plan;
}

Plan sphere_plan() {
  return {.engines = {"exact"}, .sizes = {}};
}

Plan quick_plan() {
  return {.engines = {"exact", "bricked", "direct"},
          .sizes = {{256, 256}, {256, 1024}, {1024, 1024}},
          .light = false,
          .details = false,
          .sphere_voxels_mm = {}};
}

void check_plan(const Plan& plan) {
  for (const std::string& engine : plan.engines) {
    if (std::ranges::count(engine_names(), engine) > 0) continue;
    throw InputError({}, "--engines", "\"" + engine + "\"",
                     fmt::format("expected some of {}", fmt::join(engine_names(), ", ")));
  }
  if (plan.device == "serial") {
    throw InputError({}, "--device", "\"serial\" is not an OpenCL device",
                     "the benchmark compares programs on an OpenCL device");
  }
  cl::choose_device(plan.device);
}

Json run_bench(const Plan& plan, const BenchControl& control) {
  return Bench(plan, control).run();
}

}  // namespace reamsim::bench

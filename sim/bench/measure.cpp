#include "sim/bench/measure.h"

#include <algorithm>
#include <functional>
#include <new>

#include "sim/base/error.h"

namespace reamsim::bench {

namespace {

using Maker = std::function<std::unique_ptr<Program>(const cl::DeviceInfo&, const Plan&, const Setup&)>;

/// A program of the set. A new engine is a line here.
struct Entry {
  Label label;
  bool has_shell;
  Maker make;
};

Maker engine(const char* name) {
  return [name](const cl::DeviceInfo&, const Plan& plan, const Setup& setup) {
    return make_engine_program(name, plan.device, setup);
  };
}

const std::vector<Entry>& entries() {
  static const std::vector<Entry> list{
      {{"bricked", "deterministic"}, true, engine("bricked")},
      {{"direct", "deterministic"}, true, engine("direct")},
      {{"direct", "published"},
       true,
       [](const cl::DeviceInfo& device, const Plan&, const Setup& setup) {
         return make_published_direct(device, setup, false);
       }},
      {{"octree", "deterministic"}, true, engine("octree")},
      {{"octree", "published"},
       true,
       [](const cl::DeviceInfo& device, const Plan&, const Setup& setup) {
         return make_published_octree(device, setup);
       }},
      {{"implicit", "deterministic"}, false, engine("implicit")},
  };
  return list;
}

}  // namespace

const std::vector<std::string>& engine_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const Entry& entry : entries()) {
      if (out.empty() || out.back() != entry.label.engine) out.push_back(entry.label.engine);
    }
    return out;
  }();
  return names;
}

ProgramSet make_programs(const Plan& plan, const Setup& setup, const SizePair& size, bool whole,
                         std::vector<Skipped>& skipped) {
  ProgramSet set{setup, size.voxmap, size.shell, {}};
  const cl::DeviceInfo device = cl::choose_device(plan.device);
  for (const Entry& entry : entries()) {
    if (std::find(plan.engines.begin(), plan.engines.end(), entry.label.engine) == plan.engines.end()) continue;
    if (!whole && !entry.has_shell) continue;
    const auto skip = [&](const std::string& reason) {
      skipped.push_back({{entry.label, size.voxmap, size.shell, "all"}, reason});
    };
    try {
      set.programs.push_back(entry.make(device, plan, setup));
    } catch (const InputError& error) {
      skip(error.what());
    } catch (const RunError& error) {
      skip(error.what());
    } catch (const std::bad_alloc&) {
      skip("not enough memory for the copy of the bone");
    }
  }
  return set;
}

std::vector<Program*> pointers_to(const ProgramSet& set) {
  std::vector<Program*> out;
  for (const auto& program : set.programs) out.push_back(program.get());
  return out;
}

std::vector<std::vector<BatchSample>> run_alternately(const std::vector<Program*>& programs,
                                                      const std::vector<Substep>& frames, int repetitions, bool use_voi,
                                                      const BenchControl& control) {
  constexpr int kRounds = 2;
  std::vector<std::vector<BatchSample>> samples(programs.size());
  for (int round = 0; round < kRounds; ++round) {
    const int timed = repetitions * (round + 1) / kRounds - repetitions * round / kRounds;
    for (const Substep& frame : frames) {
      for (std::size_t i = 0; i < programs.size(); ++i) {
        if (control.stop()) throw Interrupted();
        for (int repetition = -1; repetition < timed; ++repetition) {
          programs[i]->prepare(frame);
          const BatchSample sample = programs[i]->run({&frame, 1}, use_voi);
          if (repetition >= 0) samples[i].push_back(sample);
          programs[i]->restore();
        }
      }
    }
  }
  return samples;
}

}  // namespace reamsim::bench

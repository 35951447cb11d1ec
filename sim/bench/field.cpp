#include "sim/bench/field.h"

#include <algorithm>
#include <functional>
#include <new>

#include "sim/base/error.h"

namespace reamsim::bench {

namespace {

using Maker = std::function<std::unique_ptr<Contender>(const cl::DeviceInfo&, const Plan&, const Arena&)>;

/// A program of the field. A new engine is a line here.
struct Entry {
  Label label;
  bool has_shell;
  Maker make;
};

Maker engine(const char* name) {
  return [name](const cl::DeviceInfo&, const Plan& plan, const Arena& arena) {
    return make_engine_contender(name, plan.device, arena);
  };
}

const std::vector<Entry>& entries() {
  static const std::vector<Entry> list{
      {{"bricked", "deterministic"}, true, engine("bricked")},
      {{"direct", "deterministic"}, true, engine("direct")},
      {{"direct", "published"},
       true,
       [](const cl::DeviceInfo& device, const Plan&, const Arena& arena) {
         return make_published_direct(device, arena, false);
       }},
      {{"octree", "deterministic"}, true, engine("octree")},
      {{"octree", "published"},
       true,
       [](const cl::DeviceInfo& device, const Plan&, const Arena& arena) {
         return make_published_octree(device, arena);
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

Field make_field(const Plan& plan, const Arena& arena, const SizePair& size, bool whole,
                 std::vector<Skipped>& skipped) {
  Field field{arena, size.voxmap, size.shell, {}};
  const cl::DeviceInfo device = cl::choose_device(plan.device);
  for (const Entry& entry : entries()) {
    if (std::find(plan.engines.begin(), plan.engines.end(), entry.label.engine) == plan.engines.end()) continue;
    if (!whole && !entry.has_shell) continue;
    const auto skip = [&](const std::string& reason) {
      skipped.push_back({{entry.label, size.voxmap, size.shell, "all"}, reason});
    };
    try {
      field.contenders.push_back(entry.make(device, plan, arena));
    } catch (const InputError& error) {
      skip(error.what());
    } catch (const RunError& error) {
      skip(error.what());
    } catch (const std::bad_alloc&) {
      skip("not enough memory for the copy of the bone");
    }
  }
  return field;
}

std::vector<Contender*> all_of(const Field& field) {
  std::vector<Contender*> out;
  for (const auto& contender : field.contenders) out.push_back(contender.get());
  return out;
}

std::vector<std::vector<BatchSample>> take_turns(const std::vector<Contender*>& contenders,
                                                 const std::vector<Substep>& frames, int repetitions, bool use_voi,
                                                 const Watch& watch) {
  constexpr int kRounds = 2;
  std::vector<std::vector<BatchSample>> samples(contenders.size());
  for (int round = 0; round < kRounds; ++round) {
    const int timed = repetitions * (round + 1) / kRounds - repetitions * round / kRounds;
    for (const Substep& frame : frames) {
      for (std::size_t i = 0; i < contenders.size(); ++i) {
        if (watch.stop()) throw Interrupted();
        for (int repetition = -1; repetition < timed; ++repetition) {
          contenders[i]->prepare(frame);
          const BatchSample sample = contenders[i]->run({&frame, 1}, use_voi);
          if (repetition >= 0) samples[i].push_back(sample);
          contenders[i]->restore();
        }
      }
    }
  }
  return samples;
}

}  // namespace reamsim::bench

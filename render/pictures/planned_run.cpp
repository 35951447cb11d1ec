#include "render/pictures/planned_run.h"

#include <future>
#include <utility>

#include "render/pictures/results.h"
#include "render/pictures/subject.h"
#include "render/surface/unreamed_surface.h"
#include "sim/base/error.h"
#include "sim/predict/swept_bone.h"
#include "sim/tool/envelope.h"

namespace reamsim {
namespace {

ForeseenBone foresee(const RunPlan& plan) {
  try {
    return foresee(*plan.bone, plan.fill_before, envelope_of_revolution(plan.tool).profile, plan.poses,
                   plan.whole_voxels);
  } catch (const InputError& error) {
    throw InputError({tool_path(plan.dir), 0, 0}, "", error.what(), "expected the tool of a run");
  }
}

}  // namespace

struct PlannedRun::Made {
  explicit Made(const RunPlan& plan) : Made(plan, foresee(plan)) {}
  Made(const RunPlan& plan, const ForeseenBone& foreseen)
      : unreamed(std::make_shared<UnreamedBone>(*plan.bone, with_gone_voxels_whole(plan.fill_before)), *plan.bone,
                 foreseen.fill),
        subject(make_subject(plan, foreseen.deepest, unreamed)) {}

  UnreamedSurface unreamed;
  Subject subject;
};

struct PlannedRun::Shared {
  RunPlan plan;
  std::shared_future<std::shared_ptr<const Made>> made;
};

PlannedRun::PlannedRun(RunPlan plan) : shared_(new Shared{std::move(plan), {}}) {
  shared_->made = std::async(std::launch::async,
                             [&plan = std::as_const(shared_->plan)] { return std::make_shared<const Made>(plan); });
}

const RunPlan& PlannedRun::plan() const {
  return shared_->plan;
}

const UnreamedSurface& PlannedRun::unreamed() const {
  return shared_->made.get()->unreamed;
}

const Subject& PlannedRun::subject() const {
  return shared_->made.get()->subject;
}

}  // namespace reamsim

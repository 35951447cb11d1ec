// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/import_progress.h"

#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace reamsim {

namespace {

/// The usual time of a stage, s, at voxels of v mm: fixed + per_area/v² + per_volume/v³.
///
/// Measured as processor time of the main thread and of the process that reads files, or half of that of all threads
/// where this is more, as on two cores of an AMD EPYC: `reamsim import` of the public shoulder CT (with and without its
/// crop), of the public scapula mesh (with and without near_mm), of the VDB of that mesh and of the phantom of
/// trajectories/default.yaml, at 0.8, 0.4 and 0.25 mm. The forms fit within 0.1 s or a fifth. Only ratios count.
struct StageTime {
  BoneStage stage;
  const char* name;
  double fixed_s, per_area_s, per_volume_s;
};

constexpr std::array kCt{StageTime{BoneStage::read, "reading the scan", 0.2, 0, 0},
                         StageTime{BoneStage::filter, "filtering the scan", 1.2, 0, 0},
                         StageTime{BoneStage::segment, "segmenting the bone", 0.6, 0, 0},
                         StageTime{BoneStage::correct_density, "correcting the density of its boundary", 0.55, 0, 0},
                         StageTime{BoneStage::voxels, "making voxels", 0.65, 0, 0.036},
                         StageTime{BoneStage::anatomy, "placing the glenoid", 0.01, 0, 0},
                         StageTime{BoneStage::write, "writing the VDB", 0, 0.09, 0}};
constexpr std::array kMesh{StageTime{BoneStage::read, "reading the mesh", 0.01, 0, 0},
                           StageTime{BoneStage::distances, "computing distances to its surface", 0.17, 0, 0.031},
                           StageTime{BoneStage::voxels, "making voxels", 0.01, 0, 0.007},
                           StageTime{BoneStage::anatomy, "placing the glenoid", 0.01, 0, 0},
                           StageTime{BoneStage::write, "writing the VDB", 0, 0.1, 0}};
constexpr std::array kVdb{StageTime{BoneStage::read, "reading the VDB", 0, 0.03, 0},
                          StageTime{BoneStage::anatomy, "placing the glenoid", 0.01, 0, 0},
                          StageTime{BoneStage::write, "writing the VDB", 0, 0.09, 0}};
constexpr std::array kPhantom{StageTime{BoneStage::voxels, "making voxels", 0.1, 0, 0.0275},
                              StageTime{BoneStage::anatomy, "placing the glenoid", 0.01, 0, 0},
                              StageTime{BoneStage::write, "writing the VDB", 0, 0.03, 0}};

/// Where the face is searched round `near_mm`.
constexpr StageTime kFace{BoneStage::anatomy, "placing the glenoid", 0.3, 0, 0.011};

std::span<const StageTime> times_of(BoneSource source) {
  switch (source) {
    case BoneSource::ct:
      return kCt;
    case BoneSource::mesh:
      return kMesh;
    case BoneSource::vdb:
      return kVdb;
    case BoneSource::phantom:
      break;
  }
  return kPhantom;
}

}  // namespace

ImportProgress::ImportProgress(const BoneSettings& settings, Sink sink) : sink_(std::move(sink)) {
  const double area = std::pow(settings.voxel_mm, -2), volume = std::pow(settings.voxel_mm, -3);
  for (const StageTime& usual : times_of(settings.source)) {
    if (usual.stage == BoneStage::filter && settings.ct.filter == CtFilter::none) continue;
    const StageTime& time = usual.stage == BoneStage::anatomy && settings.glenoid.near_mm ? kFace : usual;
    parts_.push_back({time.stage, time.name, time.fixed_s + time.per_area_s * area + time.per_volume_s * volume});
    total_s_ += parts_.back().seconds;
  }
}

void ImportProgress::begin(BoneStage stage) {
  double before_s = 0;
  for (const Part& part : parts_) {
    if (part.stage == stage) return sink_(before_s / total_s_, part.name);
    before_s += part.seconds;
  }
}

void ImportProgress::finish() {
  sink_(1, "");
}

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/// The simulator as a library. Simulation: the caller gives the pose of the tool frame by frame, and gets the force.
/// run_scenario(): a whole scenario into a results folder, as `reamsim run` does it.
///
/// Frames and units are those of docs/scenario.md: mm, s, N, N·mm, mJ; B is the bone's frame, T the tool's without its
/// spin. Every error is a reamsim::Error; no other exception leaves the library. A Simulation may be used by one thread
/// at a time.
#ifndef REAMSIM_SIMULATION_H
#define REAMSIM_SIMULATION_H

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace reamsim {

/// Changes with every change of this header that a program could notice.
inline constexpr int kLibraryVersion = 3;

/// The base of every exception that leaves the library.
class Error : public std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Wrong input: the message has file, line, column and key, what was found, and what to do.
class BadInput : public Error {
  using Error::Error;
};
/// The device, the memory or a file failed.
class RunFailure : public Error {
  using Error::Error;
};

/// RunOptions::stop ended a run. The message says which results are kept, and whether RunOptions::resume continues it.
class Stopped : public Error {
  using Error::Error;
};

/// A pose of the tool in B.
struct Pose {
  std::array<double, 3> position_mm{};           ///< of the tool's origin
  std::array<double, 4> quaternion{1, 0, 0, 0};  ///< w, x, y, z of the rotation from T to B; of length 1
  double spin_rpm = 0;                           ///< positive clockwise seen from the drive
  /// Rotation so far. Without it the integral of the speed over the steps.
  std::optional<double> spin_angle_rad{};
};

/// What a step did: a row of forces.csv.
struct StepResult {
  std::int64_t frame = 0;              ///< counted from start(), which is 0
  double time_s = 0;                   ///< at the end of the step
  std::array<double, 3> force_n{};     ///< of the bone on the tool, in B, mean over the step
  std::array<double, 3> torque_nmm{};  ///< about the tool's origin, in B
  double axial_force_n = 0;            ///< along +z of T
  double spin_torque_nmm = 0;          ///< resistance to the spin
  double depth_mm = 0;                 ///< travel along −z of T since first contact
  std::int64_t contacts = 0;           ///< voxels that lost bone
  double removed_mm3 = 0;              ///< in this step
  double energy_mj = 0;                ///< of cutting, in this step
  double floor_energy_mj = 0;          ///< the part of it below the least speed (docs/physics.md, 4)
  double balance = 0;                  ///< of energy, so far, relative
  Pose pose{};                         ///< at the end of the step, with its spin angle
};

/// A value per voxel, x fastest.
struct Volume {
  std::array<int, 3> dims{};          ///< voxels along x, y and z
  double voxel_mm = 0;                ///< edge of a voxel
  std::array<double, 3> origin_mm{};  ///< corner of voxel (0, 0, 0), B
  std::vector<float> values;          ///< of voxel (x, y, z) at x + dims[0]·(y + dims[1]·z)
};

/// Bone, tool and engine of a scenario, between two steps.
class Simulation {
 public:
  /// Loads bone and tool of a scenario and prepares the engine. `scenario`: its file; the name of a shipped one, such
  /// as "default", where the program or the Python module stands beside them. `set`: overrides as of `reamsim run
  /// --set`, such as "bone.voxel_mm=0.4". Throws BadInput, RunFailure.
  explicit Simulation(const std::string& scenario, const std::vector<std::string>& set = {});
  /// The other one may only be destroyed or assigned to.
  Simulation(Simulation&&) noexcept;
  /// The other one may only be destroyed or assigned to.
  Simulation& operator=(Simulation&&) noexcept;
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  ~Simulation();

  /// 1/motion.frame_rate_hz.
  [[nodiscard]] double frame_s() const;
  /// The poses of the scenario's motion, one per frame.
  [[nodiscard]] std::vector<Pose> planned_poses() const;
  /// What `reamsim check` would warn of, one text per warning.
  [[nodiscard]] std::vector<std::string> warnings() const;

  /// Frame 0: puts the tool somewhere. With erosion exact, bone inside it is removed without force.
  StepResult start(const Pose& pose);
  /// Moves the tool to `pose` in `dt` seconds, frame_s() unless given. Throws BadInput before start(), for a quaternion
  /// that is no rotation, a value that is not finite, and dt of 0 or less.
  StepResult step(const Pose& pose, std::optional<double> dt = {});
  /// The same for poses that are known ahead, frame_s() apart, in batches: faster, and where the motion is smooth with
  /// one fit for many frames (docs/erosion.md, 3), as `reamsim run` does. Before start(), the first pose is that of
  /// start(). `stop` is called several times a second; where it returns true, the steps end early: as many as results.
  /// Wrong poses are found before the first step.
  std::vector<StepResult> run(std::span<const Pose> poses, const std::function<bool()>& stop = {});
  /// What step() would return, without removing bone. Only for erosion exact. A motion of more than
  /// engine.max_step_voxels takes longer than in step(), because the bone is put back.
  [[nodiscard]] StepResult peek(const Pose& pose, std::optional<double> dt = {});

  /// The part of each voxel that is left, 0 to 1.
  [[nodiscard]] Volume fill();
  /// g/cm³, without fill.
  [[nodiscard]] Volume density() const;
  /// The sum over start() and all steps.
  [[nodiscard]] double removed_mm3() const;
  /// The present pose; none before start().
  [[nodiscard]] std::optional<Pose> pose() const;
  /// The frame of the last step; 0 after start() and before it.
  [[nodiscard]] std::int64_t frame() const;

  /// The simulation after a step: bone, pose and sums.
  class State {
   public:
    /// What a state holds; of the library alone.
    struct Parts;
    /// Made by Simulation::state().
    explicit State(std::shared_ptr<const Parts> parts) : parts_(std::move(parts)) {}
    /// For Simulation::restore().
    [[nodiscard]] const Parts& parts() const { return *parts_; }

    /// Writes the state to a file, in one piece: the path has the old or the new content. Throws RunFailure.
    void save(const std::string& path) const;
    /// Reads such a file. Throws BadInput where it is missing, damaged or another file.
    static State load(const std::string& path);

   private:
    std::shared_ptr<const Parts> parts_;
  };
  /// The present state.
  [[nodiscard]] State state();
  /// Goes back to a state of this simulation, or of another one of the same scenario. Throws BadInput for one of
  /// another bone.
  void restore(const State& state);

 private:
  struct Core;
  std::unique_ptr<Core> core_;
};

/// How run_scenario() runs a scenario.
struct RunOptions {
  std::vector<std::string> set{};  ///< overrides as of `reamsim run --set`
  std::string dir{};               ///< the results folder; "": output.dir of the scenario, else out/NAME
  bool overwrite = false;          ///< results of an older run in the folder are replaced once this one succeeds
  bool resume = false;             ///< an interrupted run in the folder is continued from its checkpoint
  /// Numbers of finished frames and of all frames. Called several times a second, on the calling thread.
  std::function<void(std::int64_t done, std::int64_t total)> progress{};
  /// Called several times a second; where it returns true, the run ends, with a checkpoint: Stopped.
  std::function<bool()> stop{};
};

/// What run_scenario() leaves.
struct RunResults {
  std::string dir;                    ///< the results folder
  std::vector<std::string> warnings;  ///< as of `reamsim run`, one text per warning
};

/// Runs a scenario and writes the files of `reamsim run`, except pictures, plots, meshes and the report, which
/// `reamsim render DIR` adds. `scenario`: as for Simulation. Throws BadInput; RunFailure; Stopped.
/// On an error the folder is left as `reamsim run` leaves it (docs/results.md).
RunResults run_scenario(const std::string& scenario, const RunOptions& options = {});

}  // namespace reamsim

#endif

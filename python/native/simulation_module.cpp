// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The module reamsim._simulation: what python/src/reamsim/simulation.py needs of reamsim/simulation.h.
#include <pthread.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <reamsim/simulation.h>

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace reamsim::python {

namespace {

namespace py = pybind11;

/// Columns of a pose, without and with the spin angle.
constexpr py::ssize_t kColumns = 8, kColumnsWithAngle = 9;

/// Position, quaternion, spindle speed and spin angle.
auto values_of(const Pose& pose) {
  const std::tuple rest{pose.spin_rpm, pose.spin_angle_rad.value_or(0)};
  return std::tuple_cat(pose.position_mm, pose.quaternion, rest);
}

/// A row of forces.csv (docs/columns.md): whole numbers where the column has them.
auto values_of(const StepResult& s) {
  constexpr int kOnlyPass = 1;
  const std::tuple start{s.frame, s.time_s};
  const std::tuple rest{s.axial_force_n, s.spin_torque_nmm, s.contacts, s.removed_mm3,
                        s.energy_mj,     s.floor_energy_mj, s.balance,  kOnlyPass};
  return std::tuple_cat(start, values_of(s.pose), std::tuple{s.depth_mm}, s.force_n, s.torque_nmm, rest);
}

/// The values of each item, a row.
template <class Item>
py::array_t<double> array_of(const std::vector<Item>& items) {
  constexpr std::size_t kCount = std::tuple_size_v<decltype(values_of(items[0]))>;
  py::array_t<double> out({items.size(), kCount});
  double* at = out.mutable_data();
  for (const Item& item : items) {
    std::apply([&](auto... values) { ((*at++ = static_cast<double>(values)), ...); }, values_of(item));
  }
  return out;
}

/// The values as a read-only array of shape `dims`, without a copy; the centre of the first voxel, mm; the edge of a
/// voxel, mm.
py::tuple grid_of(Volume volume) {
  auto owned = std::make_unique<std::vector<float>>(std::move(volume.values));
  const float* data = owned->data();
  const py::capsule owner(owned.get(), [](void* values) { delete static_cast<std::vector<float>*>(values); });
  owned.release();  // NOLINT: the capsule owns it
  const auto [nx, ny, nz] = volume.dims;
  constexpr py::ssize_t kBytes = sizeof(float);
  const py::array_t<float> values({nx, ny, nz}, {kBytes, kBytes * nx, kBytes * nx * ny}, data, owner);
  values.attr("flags").attr("writeable") = false;
  std::array<double, 3> center = volume.origin_mm;
  for (double& x : center) x += 0.5 * volume.voxel_mm;
  return py::make_tuple(values, py::make_tuple(center[0], center[1], center[2]), volume.voxel_mm);
}

std::string shown(const py::handle& value) {
  return py::repr(value).cast<std::string>();
}

[[noreturn]] void fail(const char* name, const py::handle& found, const std::string& expected) {
  PyErr_Clear();
  throw BadInput(std::string(name) + ": found " + shown(found) + "; expected " + expected);
}

/// Numbers of a sequence or an array. Throws BadInput with `name` for another length and for what is no number.
template <std::size_t N>
std::array<double, N> numbers_of(const py::handle& values, const char* name) {
  const std::string expected = std::to_string(N) + " numbers";
  const auto sequence = py::reinterpret_steal<py::object>(PySequence_Fast(values.ptr(), ""));
  if (!sequence || PySequence_Fast_GET_SIZE(sequence.ptr()) != py::ssize_t{N}) fail(name, values, expected);
  std::array<double, N> out{};
  for (std::size_t i = 0; i < N; ++i) {
    out[i] = PyFloat_AsDouble(PySequence_Fast_GET_ITEM(sequence.ptr(), static_cast<py::ssize_t>(i)));
    if (out[i] == -1 && PyErr_Occurred() != nullptr) fail(name, values, expected);
  }
  return out;
}

double number_of(const py::handle& value, const char* name) {
  const double out = PyFloat_AsDouble(value.ptr());
  if (out == -1 && PyErr_Occurred() != nullptr) fail(name, value, "a number");
  return out;
}

std::optional<double> optional_number_of(const py::handle& value, const char* name) {
  return value.is_none() ? std::nullopt : std::optional(number_of(value, name));
}

Pose pose_of(const py::handle& position_mm, const py::handle& quaternion, const py::handle& spin_rpm,
             const py::handle& spin_angle_rad) {
  return {.position_mm = numbers_of<3>(position_mm, "position_mm"),
          .quaternion = numbers_of<4>(quaternion, "quaternion"),
          .spin_rpm = number_of(spin_rpm, "spin_rpm"),
          .spin_angle_rad = optional_number_of(spin_angle_rad, "spin_angle_rad")};
}

/// The rows of an array. Throws BadInput for another shape.
std::vector<Pose> poses_of(const py::array_t<double, py::array::c_style>& rows) {
  if (rows.ndim() != 2 || (rows.shape(1) != kColumns && rows.shape(1) != kColumnsWithAngle)) {
    throw BadInput("poses: found an array of shape " + shown(rows.attr("shape")) +
                   "; expected (n, 8): position, quaternion, spindle speed; or (n, 9), with the spin angle");
  }
  std::vector<Pose> out(static_cast<std::size_t>(rows.shape(0)));
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    const double* v = rows.data(i, 0);
    Pose& pose = out[static_cast<std::size_t>(i)];
    pose = {.position_mm = {v[0], v[1], v[2]}, .quaternion = {v[3], v[4], v[5], v[6]}, .spin_rpm = v[7]};
    if (rows.shape(1) == kColumnsWithAngle) pose.spin_angle_rad = v[8];
  }
  return out;
}

// Global: a fork concerns the whole process. The threads of OpenCL and TBB do not exist in it, and a wait for them
// never ends.
std::atomic<bool> used = false, forked = false;

/// Converts a message to text, whatever its bytes.
py::object text_of(const std::string& message) {
  PyObject* text = PyUnicode_DecodeUTF8(message.data(), static_cast<py::ssize_t>(message.size()), "backslashreplace");
  if (text == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::object>(text);
}

/// Raises an exception of reamsim.errors. `status`: the exit status of the program for the same error.
void raise_python(const char* name, const std::string& message, int status) {
  const py::object type = py::module_::import("reamsim.errors").attr(name);
  const py::object error = type(text_of(message).attr("splitlines")(), status);
  PyErr_SetObject(type.ptr(), error.ptr());
}

void translate(std::exception_ptr thrown) {  // NOLINT(performance-unnecessary-value-param): as pybind11 calls it
  constexpr int kFailed = 1, kWrongInput = 2;
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const BadInput& error) {
    raise_python("InputError", error.what(), kWrongInput);
  } catch (const RunFailure& error) {
    raise_python("RunError", error.what(), kFailed);
  }
}

/// Calls work() without the GIL. An interrupt of the user comes before the error that it caused.
template <class Work>
auto without_gil(const Work& work) {
  try {
    const py::gil_scoped_release release;
    return work();
  } catch (const Error&) {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    throw;
  }
}

/// A simulation that several threads of Python can reach. The GIL is released while it computes.
class Guarded {
 public:
  Guarded(const std::string& path, const std::vector<std::string>& set) {
    require_process();
    used = true;
    without_gil([&] { simulation_.emplace(path, set); });
    warn();
  }
  Guarded(const Guarded&) = delete;
  Guarded& operator=(const Guarded&) = delete;
  ~Guarded() {
    // Its device cannot be released in a fork.
    if (forked) new std::optional<Simulation>(std::move(simulation_));  // NOLINT: stays until the process ends
  }

  /// Calls work(simulation) with the GIL, so that no other thread can meet it. For what takes no time.
  template <class Work>
  auto look(const Work& work) {
    require_free();
    return work(*simulation_);
  }

  /// Calls work(simulation) without the GIL.
  template <class Work>
  auto compute(const Work& work) {
    require_free();
    busy_ = true;
    const std::unique_ptr<bool, void (*)(bool*)> release(&busy_, [](bool* busy) { *busy = false; });
    return without_gil([&] { return work(*simulation_); });
  }

  /// The same for steps, whose warnings become warnings of Python.
  template <class Work>
  auto step(const Work& work) {
    try {
      auto out = compute(work);
      warn();
      return out;
    } catch (const Error&) {
      warn();
      throw;
    }
  }

  /// Gives Python the warnings since the last call.
  void warn() {
    const std::vector<std::string> all = simulation_->warnings();
    while (warned_ < all.size()) {
      const py::object type = py::module_::import("reamsim.errors").attr("ReamsimWarning");
      constexpr int kCaller = 2;  // of the function in simulation.py
      const py::object text = text_of(all[warned_++]);
      const char* bytes = PyUnicode_AsUTF8(text.ptr());
      if (bytes == nullptr || PyErr_WarnEx(type.ptr(), bytes, kCaller) != 0) throw py::error_already_set();
    }
  }

 private:
  static void require_process() {
    if (!forked) return;
    throw RunFailure(
        "this process is a fork of one that has used the simulator, whose threads it does not have: start processes "
        "with multiprocessing.get_context(\"spawn\")");
  }

  void require_free() const {
    require_process();
    if (busy_) throw BadInput("the simulation computes in another thread: use one thread at a time");
  }

  std::optional<Simulation> simulation_;
  bool busy_ = false;  ///< the GIL guards it
  std::size_t warned_ = 0;
};

/// Simulation::step and peek.
template <auto kMember>
py::object move(Guarded& guarded, const py::object& position, const py::object& quaternion, const py::object& spin,
                const py::object& angle, const py::object& dt) {
  const Pose pose = pose_of(position, quaternion, spin, angle);
  const std::optional<double> dt_s = optional_number_of(dt, "dt_s");
  return py::cast(values_of(guarded.step([&](Simulation& s) { return (s.*kMember)(pose, dt_s); })));
}

py::object start(Guarded& guarded, const py::object& position, const py::object& quaternion, const py::object& spin,
                 const py::object& angle) {
  const Pose pose = pose_of(position, quaternion, spin, angle);
  return py::cast(values_of(guarded.step([&](Simulation& s) { return s.start(pose); })));
}

/// A signal of the user, such as Ctrl-C, ends the steps and is raised.
py::array_t<double> run(Guarded& guarded, const py::array_t<double, py::array::c_style>& rows) {
  const std::vector<Pose> poses = poses_of(rows);
  bool interrupted = false;
  const auto stop = [&interrupted] {
    const py::gil_scoped_acquire acquire;
    return interrupted = PyErr_CheckSignals() != 0;
  };
  const auto steps = guarded.compute([&](Simulation& s) { return s.run(poses, stop); });
  if (interrupted) throw py::error_already_set();
  guarded.warn();
  return array_of(steps);
}

void add_simulation(py::module_& module) {
  using State = Simulation::State;
  py::class_<State>(module, "State")
      .def("save", [](const State& state, const std::string& path) { without_gil([&] { state.save(path); }); })
      .def_static("load", [](const std::string& path) { return without_gil([&] { return State::load(path); }); });
  py::class_<Guarded>(module, "Simulation")
      .def(py::init<const std::string&, const std::vector<std::string>&>())
      .def("start", start)
      .def("step", move<&Simulation::step>)
      .def("peek", move<&Simulation::peek>)
      .def("run", run)
      .def("planned_poses",
           [](Guarded& g) { return array_of(g.compute([](Simulation& s) { return s.planned_poses(); })); })
      .def("pose",
           [](Guarded& g) -> py::object {
             const std::optional<Pose> pose = g.look([](Simulation& s) { return s.pose(); });
             return pose ? py::object(array_of(std::vector{*pose})) : py::none();
           })
      .def("fill", [](Guarded& g) { return grid_of(g.compute([](Simulation& s) { return s.fill(); })); })
      .def("density", [](Guarded& g) { return grid_of(g.compute([](Simulation& s) { return s.density(); })); })
      .def("frame_s", [](Guarded& g) { return g.look([](Simulation& s) { return s.frame_s(); }); })
      .def("frame", [](Guarded& g) { return g.look([](Simulation& s) { return s.frame(); }); })
      .def("removed_mm3", [](Guarded& g) { return g.look([](Simulation& s) { return s.removed_mm3(); }); })
      .def("state", [](Guarded& g) { return g.compute([](Simulation& s) { return s.state(); }); })
      .def("restore", [](Guarded& g, const State& state) { g.compute([&](Simulation& s) { s.restore(state); }); });
}

}  // namespace
}  // namespace reamsim::python

PYBIND11_MODULE(_simulation, module) {
  using namespace reamsim::python;
  module.attr("__version__") = REAMSIM_VERSION;
  py::register_exception_translator(translate);
  add_simulation(module);
  pthread_atfork(nullptr, nullptr, [] { forked = used.load(); });
}

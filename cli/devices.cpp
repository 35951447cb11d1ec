#include <CLI/CLI.hpp>

#include "cli/commands.h"
#include "sim/base/error.h"
#include "sim/device/opencl.h"

namespace reamsim {

namespace {

std::string line(const cl::DeviceInfo& device, cl_device_id chosen) {
  std::string out = (device.id == chosen ? "* " : "  ") + device.name + "  [" + device.platform_name + ", driver " +
                    device.driver + ", " + (device.gpu ? "GPU" : "CPU") + ", " + std::to_string(device.compute_units) +
                    " compute units, " + std::to_string(device.global_memory_bytes / 1'000'000) + " MB, at most " +
                    std::to_string(device.max_allocation_bytes / 1'000'000) + " MB at once]";
  if (!device.missing.empty()) out += "  not usable: lacks " + device.missing;
  return out;
}

void devices_command(const Console& console) {
  const auto devices = cl::list_devices();
  if (devices.empty()) {
    console.say(
        "no OpenCL device found; reamsim run needs --device serial (slow), or install one (Debian: pocl-opencl-icd)");
    return;
  }
  std::string why;
  cl_device_id chosen = nullptr;
  try {
    const cl::DeviceInfo device = cl::choose_device("auto");
    chosen = device.id;
    why = device.name + ": the first " + (device.gpu ? "GPU" : "CPU") +
          " with 64-bit floats and 64-bit atomics; GPUs go before CPUs";
  } catch (const RunError& error) {
    why = error.what();
  }
  for (const auto& device : devices) console.say(line(device, chosen));
  console.say("auto chooses " + why);
  console.say("serial is always there: the plain C++ reference, slow");
}

}  // namespace

void add_devices_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("devices", "List what OpenCL sees, and what would be chosen");
  command->callback([&console] { devices_command(console); });
}

}  // namespace reamsim

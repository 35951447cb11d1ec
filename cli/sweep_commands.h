// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

namespace CLI {
class App;
}

namespace reamsim {

class Console;

/// Each adds one command below `reamsim sweep`.
void add_sweep_plan(CLI::App& sweep, Console& console);
void add_sweep_run(CLI::App& sweep, Console& console);
void add_sweep_status(CLI::App& sweep, Console& console);
void add_sweep_collect(CLI::App& sweep, Console& console);
void add_sweep_submit(CLI::App& sweep, Console& console);
void add_sweep_worker(CLI::App& sweep);

}  // namespace reamsim

// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace CLI {
class App;
}

namespace reamsim {

/// reamsim(1) for man(7): all commands and options of `root`.
std::string man_page(const CLI::App& root);

}  // namespace reamsim

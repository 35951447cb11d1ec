// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "cli/console.h"
#include "sim/base/text.h"
#include "sim/scene/bone_store.h"

namespace reamsim {

void add_cache_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("cache", "Show or empty the store of bones that were loaded before");
  auto empty = std::make_shared<bool>(false);
  command->add_flag("--clear", *empty, "Remove these bones");
  command->callback([empty, &console] {
    const std::filesystem::path folder = BoneStore::usual_folder();
    if (folder.empty()) return console.say("no bones are kept: REAMSIM_CACHE is off, or there is no home");
    const BoneStore store(folder);
    if (*empty) store.clear();
    const auto [bones, bytes] = store.size();
    console.say(fmt::format("{}: {} bones, {} of at most {}; REAMSIM_CACHE=off keeps none", folder.string(), bones,
                            megabytes(bytes), megabytes(BoneStore::kMostBytes)));
  });
}

}  // namespace reamsim

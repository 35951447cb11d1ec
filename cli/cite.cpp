// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "sim/base/error.h"
#include "sim/record/citation.h"

namespace reamsim {

namespace {

struct CiteOptions {
  std::string dir;
  bool bibtex = false;
  bool json = false;
};

/// Throws InputError where DIR is no folder with results of reamsim.
void require_results(const std::string& dir) {
  for (const char* mark : {"summary.json", "manifest.json", "study.json", "runs.csv"}) {
    if (std::filesystem::exists(dir + "/" + mark)) return;
  }
  const bool exists = std::filesystem::exists(dir);
  refuse_file(dir, exists ? "holds no results of reamsim" : "not found",
              "give a results folder, or none to cite the program");
}

}  // namespace

void add_cite_command(CLI::App& app) {
  auto* command =
      app.add_subcommand("cite", "Print how to cite reamsim, or a run: program, method, data and libraries");
  auto options = std::make_shared<CiteOptions>();
  command->add_option("DIR", options->dir, "Results folder; without it the program is cited")->check(refuse_empty);
  auto* bibtex = command->add_flag("--bibtex", options->bibtex, "Print entries of BibTeX");
  command->add_flag("--json", options->json, "Print CSL-JSON, which reference managers read")->excludes(bibtex);
  command->callback([options] {
    if (!options->dir.empty()) require_results(options->dir);
    const Citation citation = options->dir.empty() ? cite_program() : cite_results(options->dir);
    const std::string& text = options->json ? citation.csl_json : options->bibtex ? citation.bibtex : citation.text;
    std::fputs(text.c_str(), stdout);
  });
}

}  // namespace reamsim

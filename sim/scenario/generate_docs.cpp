// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "sim/scenario/parse.h"

namespace {

/// Replaces the text between the two marker comments of a Markdown file.
bool replace_between_markers(std::string& text, const std::string& table) {
  const std::string begin = "<!-- keys: begin -->\n";
  const std::string end = "<!-- keys: end -->";
  const std::size_t from = text.find(begin);
  const std::size_t to = text.find(end);
  if (from == std::string::npos || to == std::string::npos || to < from) return false;
  text.replace(from + begin.size(), to - from - begin.size(), table);
  return true;
}

bool write(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) std::cerr << path << ": cannot be written\n";
  return static_cast<bool>(file);
}

}  // namespace

/// reamsim_docs SCHEMA.json KEYS.md: writes the JSON schema, and the table of keys into the page.
int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: reamsim_docs SCHEMA.json KEYS.md\n";
    return EXIT_FAILURE;
  }
  std::ifstream page_file(argv[2], std::ios::binary);
  std::string page{std::istreambuf_iterator<char>(page_file), {}};
  if (!replace_between_markers(page, reamsim::scenario_key_table())) {
    std::cerr << argv[2] << ": the markers <!-- keys: begin --> and <!-- keys: end --> are missing\n";
    return EXIT_FAILURE;
  }
  const bool done = write(argv[1], reamsim::scenario_json_schema()) && write(argv[2], page);
  return done ? EXIT_SUCCESS : EXIT_FAILURE;
}

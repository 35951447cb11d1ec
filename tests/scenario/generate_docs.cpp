// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <cstdlib>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>

#include "sim/base/file.h"
#include "tests/scenario/key_documents.h"

namespace {

/// The page with `table` between its two marker comments.
std::string with_table(std::string page, const std::string& table) {
  const std::string begin = "<!-- keys: begin -->\n";
  const std::size_t from = page.find(begin), to = page.find("<!-- keys: end -->");
  if (from == std::string::npos || to == std::string::npos || to < from)
    throw std::runtime_error("the markers <!-- keys: begin --> and <!-- keys: end --> are missing");
  return page.replace(from + begin.size(), to - from - begin.size(), table);
}

}  // namespace

/// reamsim_docs SCHEMA.json KEYS.md STUDY_SCHEMA.json: writes the schema of scenarios, and the keys into the other two.
int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: reamsim_docs SCHEMA.json KEYS.md STUDY_SCHEMA.json\n";
    return EXIT_FAILURE;
  }
  try {
    const std::string page = argv[2], study = argv[3];
    reamsim::write_file(argv[1], reamsim::test::scenario_json_schema());
    reamsim::write_file(page,
                        with_table(reamsim::read_file(page, "the page of keys"), reamsim::test::scenario_key_table()));
    reamsim::write_file(study, reamsim::test::study_json_schema(reamsim::read_file(study, "the schema of studies")));
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return EXIT_FAILURE;
  }
}

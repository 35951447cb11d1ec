// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <cstdlib>
#include <exception>
#include <iostream>

#include "sim/base/file.h"
#include "sim/study/study.h"

/// reamsim_study_schema FILE: writes the JSON schema of studies.
int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: reamsim_study_schema FILE\n";
    return EXIT_FAILURE;
  }
  try {
    reamsim::write_file(argv[1], reamsim::study_json_schema());
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return EXIT_FAILURE;
  }
}

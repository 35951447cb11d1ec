# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Writes OUTPUT, a header with the commit that ROOT has checked out, or "" if ROOT is not a clone.
cmake_minimum_required(VERSION 3.25)
set(commit "")
if(EXISTS "${ROOT}/.git")
  find_package(Git QUIET)
  if(GIT_FOUND)
    execute_process(COMMAND ${GIT_EXECUTABLE} -C "${ROOT}" rev-parse --short=12 HEAD OUTPUT_VARIABLE commit
                    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  endif()
endif()
set(text "#pragma once\n\nnamespace reamsim {\ninline constexpr const char* kCommit = \"${commit}\";\n}\n")
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "${text}")

# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

cmake_minimum_required(VERSION 3.25)
file(READ "${INPUT}" text)
get_filename_component(folder "${INPUT}" DIRECTORY)
set(included)
while(text MATCHES "(^|\n)(#include \"([a-z_]+\\.(h|gp))\"\n)")
  set(line "${CMAKE_MATCH_2}")
  set(name "${CMAKE_MATCH_3}")
  set(header "")
  if(NOT name IN_LIST included)
    list(APPEND included "${name}")
    file(READ "${folder}/${name}" header)
  endif()
  string(FIND "${text}" "${line}" begin)
  string(LENGTH "${line}" length)
  math(EXPR end "${begin} + ${length}")
  string(SUBSTRING "${text}" 0 ${begin} before)
  string(SUBSTRING "${text}" ${end} -1 after)
  set(text "${before}${header}${after}")
endwhile()
if(text MATCHES "\\)embedded\"")
  message(FATAL_ERROR "${INPUT} holds the raw-string delimiter )embedded\"")
endif()
file(WRITE "${OUTPUT}" "namespace reamsim::embedded {
extern const char* const ${VARIABLE};
const char* const ${VARIABLE} = R\"embedded(${text})embedded\";
}  // namespace reamsim::embedded
")

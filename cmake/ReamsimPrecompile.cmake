# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Headers that most files include anyway, parsed once: they are half of what compiling a file costs. The debug preset does
# without, so that a file that forgets an include of its own is found.
option(REAMSIM_PRECOMPILE "Precompile common headers" ON)

# ccache, where it is installed, also caches files that use precompiled headers.
find_program(REAMSIM_CCACHE ccache NO_CACHE)
if(REAMSIM_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${REAMSIM_CCACHE})
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
endif()

# Nothing is hot in tests, in the command line itself, and in libraries that read settings and write files (COLD of
# reamsim_library). The same bytes: no option lets a compiler change floating-point results.
set(REAMSIM_QUICK_TO_COMPILE $<$<CONFIG:Release>:-O1>)

# A precompiled header no longer counts as a system header, and GCC 12 warns of what cannot happen in std::string's
# operator+ (GCC bug 105651).
set(REAMSIM_PRECOMPILED_WARNINGS $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>)

# reamsim_headers(NAME OPTIONS ... LINK ... HEADERS ...): a set of precompiled headers that targets share; their options
# must be those that the targets are compiled with.
function(reamsim_headers name)
  cmake_parse_arguments(ARG "" "" "OPTIONS;LINK;HEADERS" ${ARGN})
  set(source ${CMAKE_BINARY_DIR}/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "")
  add_library(${name} OBJECT ${source})
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS} ${REAMSIM_PRECOMPILED_WARNINGS})
  target_link_libraries(${name} PRIVATE reamsim_options ${ARG_LINK})
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()

# reamsim_precompile(TARGET HEADERS): TARGET uses the set HEADERS.
function(reamsim_precompile target headers)
  if(REAMSIM_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM ${headers})
    target_compile_options(${target} PRIVATE ${REAMSIM_PRECOMPILED_WARNINGS})
  endif()
endfunction()

if(REAMSIM_PRECOMPILE)
  set(common <Eigen/Geometry> <algorithm> <array> <charconv> <cmath> <cstdint> <cstring> <filesystem> <fstream> <functional>
      <iomanip> <limits> <map> <memory> <nlohmann/json.hpp> <numeric> <optional> <set> <span> <sstream> <string>
      <string_view> <utility> <variant> <vector>)
  reamsim_headers(common_headers LINK Eigen3::Eigen nlohmann_json::nlohmann_json HEADERS ${common})
  reamsim_headers(cold_headers OPTIONS ${REAMSIM_QUICK_TO_COMPILE} LINK Eigen3::Eigen nlohmann_json::nlohmann_json HEADERS ${common})
  reamsim_headers(command_headers OPTIONS ${REAMSIM_QUICK_TO_COMPILE} LINK Eigen3::Eigen nlohmann_json::nlohmann_json CLI11::CLI11
                  HEADERS ${common} <CLI/CLI.hpp>)
  if(REAMSIM_TESTS)
    reamsim_headers(test_headers OPTIONS ${REAMSIM_QUICK_TO_COMPILE} LINK Eigen3::Eigen nlohmann_json::nlohmann_json GTest::gmock
                    HEADERS ${common} <gmock/gmock.h>)
  endif()
endif()

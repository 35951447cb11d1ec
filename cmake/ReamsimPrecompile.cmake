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

# Simulation is hot on the device, whose compiler is another. On the host only voxels, grids, surfaces and what is measured on
# them take time (HOT of reamsim_library): with -O1, loading a CT took a quarter longer and writing a grid two thirds; simulation
# did not. -O3 shortens only generated bones and surfaces. The same bytes: no option lets a compiler change floating-point
# results.
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
  set(libraries Eigen3::Eigen nlohmann_json::nlohmann_json)
  reamsim_headers(common_headers OPTIONS ${REAMSIM_QUICK_TO_COMPILE} LINK ${libraries} HEADERS ${common})
  foreach(level 2 3)
    reamsim_headers(hot${level}_headers OPTIONS $<$<CONFIG:Release>:-O${level}> LINK ${libraries} HEADERS ${common})
  endforeach()
  if(REAMSIM_TESTS)
    reamsim_headers(test_headers OPTIONS ${REAMSIM_QUICK_TO_COMPILE} LINK ${libraries} GTest::gmock
                    HEADERS ${common} <gmock/gmock.h>)
  endif()
endif()

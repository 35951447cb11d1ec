# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Flags that every target of this project is compiled with. A warning is an error where CMAKE_COMPILE_WARNING_AS_ERROR says so, as
# in the presets of developers and in CI: the compiler of a user may be newer than ours.
add_library(reamsim_options INTERFACE)
target_compile_options(reamsim_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  # GCC 12 sees overlaps in std::string's operator+ that cannot happen (GCC bug 105329); GCC 14 takes what an empty
  # std::optional holds for a value that is used, and with sanitizers GCC 12 a state of std::regex.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict;-Wno-maybe-uninitialized>
  # Clang warns of members that a designated initializer leaves to their default, of macros of libseccomp, and of the length
  # of embedded texts.
  $<$<CXX_COMPILER_ID:Clang>:-Wno-missing-field-initializers;-Wno-c99-extensions;-Wno-overlength-strings>
  # Host and kernels must round alike, so no fused multiply-add that the source does not write.
  -ffp-contract=off
  # Some libraries ask for it; precompiled headers want it everywhere or nowhere.
  -pthread)
target_include_directories(reamsim_options INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
target_compile_definitions(reamsim_options INTERFACE REAMSIM_VERSION="${PROJECT_VERSION}")

# All code can become part of the Python module, a shared object. The property POSITION_INDEPENDENT_CODE would give
# programs another flag (-fPIE), and precompiled headers want one everywhere. No symbol is replaced at run time, so calls can
# be inlined. -fvisibility=hidden would do that too, but it splits the templates of OpenVDB: std::call_once stays visible, and
# libopenvdb then initializes the program's copy of a type's name instead of its own.
add_compile_options(-fPIC -fno-semantic-interposition)

if(REAMSIM_SANITIZE)
  add_compile_options(-fsanitize=${REAMSIM_SANITIZE} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${REAMSIM_SANITIZE})
  if(REAMSIM_SANITIZE MATCHES "undefined")
    add_compile_options(-fno-sanitize-recover=undefined)
  endif()
endif()

if(REAMSIM_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined -ffunction-sections
                      -fdata-sections)
  add_link_options(-fsanitize=address,undefined)
endif()

# Lines of the project's own files only; threads count them together.
if(REAMSIM_COVERAGE)
  add_compile_options(--coverage -fprofile-update=atomic -fprofile-exclude-files=^/usr/)
  add_link_options(--coverage)
endif()

# How long a test, and a program that a test starts, may take; sanitizers slow everything down.
set(REAMSIM_TEST_TIMEOUT_S 600)
set(REAMSIM_PROGRAM_TIMEOUT_S 60)
if(REAMSIM_SANITIZE OR REAMSIM_COVERAGE)
  set(REAMSIM_TEST_TIMEOUT_S 6000)
  set(REAMSIM_PROGRAM_TIMEOUT_S 600)
endif()

# reamsim_library(NAME SOURCES ... LINK ... [PRIVATE ...] [HOT n]): a static library of a folder, so that the linker enforces the
# layers. HOT: compiled with -O2 or -O3, for a fast program instead of a quick build.
function(reamsim_library name)
  cmake_parse_arguments(ARG "" "HOT" "SOURCES;LINK;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  set_property(GLOBAL APPEND PROPERTY REAMSIM_LIBRARIES ${name})
  target_link_libraries(${name} PUBLIC ${ARG_LINK} PRIVATE reamsim_options ${ARG_PRIVATE})
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
  if(ARG_HOT)
    target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O${ARG_HOT}>)
    # sim/bone/vdb/grids.h. Tried with GCC 12 and 14 and OpenVDB 10.0.
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND OpenVDB_VERSION VERSION_LESS 11)
      target_compile_definitions(${name} PRIVATE $<$<CONFIG:Release>:REAMSIM_GRIDS_OF_LIBRARY>)
    endif()
    reamsim_precompile(${name} hot${ARG_HOT}_headers)
  else()
    target_compile_options(${name} PRIVATE ${REAMSIM_QUICK_TO_COMPILE})
    reamsim_precompile(${name} common_headers)
  endif()
endfunction()

# reamsim_test(NAME SOURCES ... LINK ... [HOST_THREADS] [COST n]): a GoogleTest program whose suites CTest lists, each a process:
# what a process needs to start (libraries, OpenCL, kernels) takes longer than most cases. HOST_THREADS: they use the host's
# threads and no OpenCL, so that the thread sanitizer can judge them. COST: tests of a higher one begin earlier, so that short
# ones are left for the end, when cores become free.
function(reamsim_test name)
  cmake_parse_arguments(ARG "HOST_THREADS" "COST" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE reamsim_options ${ARG_LINK} test_main GTest::gmock)
  target_compile_options(${name} PRIVATE ${REAMSIM_QUICK_TO_COMPILE})
  reamsim_precompile(${name} test_headers)
  # Names of tests, which are short, must differ within a unit.
  set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 12)
  # Tests load their bones themselves, and leave nothing in the home of who runs them.
  set(properties TIMEOUT ${REAMSIM_TEST_TIMEOUT_S} SKIP_RETURN_CODE 77 ENVIRONMENT REAMSIM_CACHE=off)
  if(ARG_HOST_THREADS)
    list(APPEND properties LABELS host_threads)
  endif()
  if(ARG_COST)
    list(APPEND properties COST ${ARG_COST})
  endif()
  set(suites "${CMAKE_CURRENT_BINARY_DIR}/${name}_suites.cmake")
  list(JOIN properties " " properties)
  add_custom_command(TARGET ${name} POST_BUILD VERBATIM BYPRODUCTS "${suites}"
    COMMAND ${CMAKE_COMMAND} "-DPROGRAM=$<TARGET_FILE:${name}>" -DTIMEOUT=${REAMSIM_PROGRAM_TIMEOUT_S} "-DFOLDER=${CMAKE_CURRENT_BINARY_DIR}" "-DPROPERTIES=${properties}"
    "-DOUT=${suites}" -P "${PROJECT_SOURCE_DIR}/cmake/DiscoverSuites.cmake")
  set(include "${CMAKE_CURRENT_BINARY_DIR}/${name}_include.cmake")
  file(WRITE "${include}" "if(EXISTS \"${suites}\")\n  include(\"${suites}\")\nelse()\n"
    "  add_test(${name}_NOT_BUILT ${name}_NOT_BUILT)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES "${include}")
endfunction()

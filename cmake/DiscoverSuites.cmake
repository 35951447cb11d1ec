# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# cmake -DPROGRAM=FILE -DTIMEOUT=SECONDS -DFOLDER=DIR -DPROPERTIES="NAME VALUE ..." -DOUT=FILE -P DiscoverSuites.cmake: writes a file
# for CTest that lists each suite of a GoogleTest program as one test. Suites need different names in all programs.
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed TIMEOUT ${TIMEOUT} COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "(^|\n)[A-Za-z0-9_/]+[.]" suites "${listed}")
list(TRANSFORM suites REPLACE "[\n.]" "")
set(text "")
foreach(suite ${suites})
  string(APPEND text "add_test(\"${suite}\" \"${PROGRAM}\" \"--gtest_filter=${suite}.*\")\n"
    "set_tests_properties(\"${suite}\" PROPERTIES WORKING_DIRECTORY \"${FOLDER}\" ${PROPERTIES})\n")
endforeach()
file(WRITE "${OUT}" "${text}")

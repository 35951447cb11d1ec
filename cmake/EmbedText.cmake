# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# reamsim_embed_text(TARGET VARIABLE FILE [DEPENDS FILE...]): compiles the text of FILE into TARGET as
# `extern const char* const reamsim::embedded::VARIABLE` (declare it where it is used). Lines `#include "..."` are replaced
# by the file beside it that they name, once each; name these files after DEPENDS.
function(reamsim_embed_text target variable file)
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  get_filename_component(path "${file}" ABSOLUTE)
  set(source "${CMAKE_CURRENT_BINARY_DIR}/embedded_${variable}.cpp")
  add_custom_command(
    OUTPUT "${source}"
    COMMAND ${CMAKE_COMMAND} -DVARIABLE=${variable} -DINPUT=${path} -DOUTPUT=${source}
            -P "${PROJECT_SOURCE_DIR}/cmake/EmbedTextScript.cmake"
    DEPENDS "${path}" ${ARG_DEPENDS} "${PROJECT_SOURCE_DIR}/cmake/EmbedTextScript.cmake"
    COMMENT "Embedding ${file}"
    VERBATIM)
  target_sources(${target} PRIVATE "${source}")
endfunction()

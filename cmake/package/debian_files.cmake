# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# CPack runs it when the components are staged, before they become packages: adds what only a Debian package has.
# Staged: CPACK_TEMPORARY_INSTALL_DIRECTORY/COMPONENT/usr.
cmake_minimum_required(VERSION 3.25)

# Compresses `from` as `to`, without name and time, so that the same sources give the same bytes.
function(compress from to)
  execute_process(COMMAND gzip -9nc ${from} OUTPUT_FILE ${to} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# The text of a licence as a paragraph of `copyright`: lines begin with a space, and empty ones have a full stop.
function(append_licence name to)
  file(READ ${CPACK_REAMSIM_LICENCES}/${name}.txt text)
  string(STRIP "${text}" text)
  string(REGEX REPLACE "\n[ \t]*\n" "\n.\n" text "${text}")
  string(REGEX REPLACE "\n[ \t]*\n" "\n.\n" text "${text}")  # every second of several empty lines
  string(REPLACE "\n" "\n " text "${text}")
  file(APPEND ${to} "\nLicense: ${name}\n ${text}\n")
endfunction()

function(add_documents usr package)
  set(folder ${usr}/share/doc/${package})
  file(MAKE_DIRECTORY ${folder})
  configure_file(${CPACK_REAMSIM_SOURCES}/copyright ${folder}/copyright COPYONLY)
  append_licence(CC-BY-3.0 ${folder}/copyright)
  append_licence(CC-BY-SA-3.0 ${folder}/copyright)
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # SOURCE_DATE_EPOCH, where it is set
  configure_file(${CPACK_REAMSIM_SOURCES}/changelog.Debian.in ${folder}/changelog.Debian @ONLY)
  compress(${folder}/changelog.Debian ${folder}/changelog.Debian.gz)
  compress(${CPACK_REAMSIM_CHANGELOG} ${folder}/changelog.gz)
  # The licence is in `copyright`, and the log of changes compressed: links lead there.
  file(REMOVE ${folder}/changelog.Debian ${folder}/CHANGELOG.md ${folder}/LICENSE)
  file(GLOB pages ${folder}/*.md)
  foreach(page ${pages})
    file(READ ${page} text)
    string(REPLACE "](LICENSE)" "](copyright)" text "${text}")
    string(REPLACE "](CHANGELOG.md)" "](changelog.gz)" text "${text}")
    file(WRITE ${page} "${text}")
  endforeach()
endfunction()

function(add_overrides usr package)
  set(overrides ${CPACK_REAMSIM_SOURCES}/${package}.lintian-overrides)
  if(EXISTS ${overrides})
    file(MAKE_DIRECTORY ${usr}/share/lintian/overrides)
    configure_file(${overrides} ${usr}/share/lintian/overrides/${package} COPYONLY)
  endif()
endfunction()

function(compress_man_pages usr)
  file(GLOB_RECURSE pages ${usr}/share/man/*.[1-9])
  foreach(page ${pages})
    compress(${page} ${page}.gz)
    file(REMOVE ${page})
  endforeach()
endfunction()

foreach(component program development python)
  string(TOUPPER ${component} upper)
  set(package ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(usr ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component}/usr)
  add_documents(${usr} ${package})
  add_overrides(${usr} ${package})
  compress_man_pages(${usr})
endforeach()

# Packages of Debian share one folder for all versions of Python.
set(staged ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/python/usr)
if(NOT CPACK_REAMSIM_PYTHON_DIR STREQUAL lib/python3/dist-packages)
  file(MAKE_DIRECTORY ${staged}/lib/python3)
  file(RENAME ${staged}/${CPACK_REAMSIM_PYTHON_DIR} ${staged}/lib/python3/dist-packages)
  cmake_path(GET CPACK_REAMSIM_PYTHON_DIR PARENT_PATH emptied)
  file(REMOVE_RECURSE ${staged}/${emptied})
endif()

# Whatever the umask of who packs: Debian's policy wants 755 for folders and programs and 644 for the rest.
foreach(component program development python)
  execute_process(COMMAND chmod -R u=rwX,go=rX ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component} COMMAND_ERROR_IS_FATAL ANY)
endforeach()

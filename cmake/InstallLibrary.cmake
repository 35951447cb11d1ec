# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# The installed library: reamsim/simulation.h, the static libraries behind it, and what CMake (`find_package(reamsim)`, target
# reamsim::simulation) and pkg-config (`reamsim`) need to link them. docs/library.md.
set(REAMSIM_LIBRARY_PARTS
  kernels sim_base sim_isolation sim_scenario sim_device sim_mesh sim_voxmap sim_bone_vdb sim_scan
  sim_bone sim_anatomy sim_tool sim_engine sim_scene sim_record sim_run sim_api)
# As GNUInstallDirs has it for the prefix /usr of Debian, which its package needs; CMake searches it below every prefix.
set(REAMSIM_LIBRARY_DIR lib/${CMAKE_LIBRARY_ARCHITECTURE})
set(REAMSIM_CMAKE_DIR ${REAMSIM_LIBRARY_DIR}/cmake/reamsim)

set_target_properties(sim_api PROPERTIES EXPORT_NAME simulation)
install(TARGETS reamsim_options ${REAMSIM_LIBRARY_PARTS} EXPORT reamsimTargets
        ARCHIVE DESTINATION ${REAMSIM_LIBRARY_DIR}/reamsim COMPONENT development)
install(EXPORT reamsimTargets NAMESPACE reamsim:: DESTINATION ${REAMSIM_CMAKE_DIR} COMPONENT development)
install(FILES sim/api/reamsim/simulation.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/reamsim COMPONENT development)

include(CMakePackageConfigHelpers)
configure_package_config_file(cmake/reamsimConfig.cmake.in reamsimConfig.cmake INSTALL_DESTINATION ${REAMSIM_CMAKE_DIR})
write_basic_package_version_file(reamsimConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/reamsimConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/reamsimConfigVersion.cmake
        DESTINATION ${REAMSIM_CMAKE_DIR} COMPONENT development)

# For pkg-config: the libraries of others by their files; those that they need themselves are found by the linker.
set(others ${ITK_LIBRARIES} gdcmMSFF gdcmDSED gdcmDICT OpenVDB::openvdb TBB::tbb yaml-cpp::yaml-cpp assimp::assimp
  OpenCL::OpenCL OpenSSL::Crypto ZLIB::ZLIB fmt::fmt)
list(REMOVE_DUPLICATES others)
set(REAMSIM_OTHERS "")
foreach(other ${others})
  if(IS_ABSOLUTE ${other})
    string(APPEND REAMSIM_OTHERS " ${other}")
    continue()
  endif()
  get_target_property(type ${other} TYPE)
  if(NOT type STREQUAL "INTERFACE_LIBRARY")
    string(APPEND REAMSIM_OTHERS " $<TARGET_LINKER_FILE:${other}>")
  endif()
endforeach()
list(TRANSFORM REAMSIM_LIBRARY_PARTS PREPEND "-l" OUTPUT_VARIABLE parts)
list(JOIN parts " " REAMSIM_PARTS)
file(RELATIVE_PATH REAMSIM_PC_PREFIX /${REAMSIM_LIBRARY_DIR}/pkgconfig /)
configure_file(cmake/reamsim.pc.in reamsim.pc.configured @ONLY)
file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/reamsim.pc INPUT ${CMAKE_CURRENT_BINARY_DIR}/reamsim.pc.configured)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/reamsim.pc DESTINATION ${REAMSIM_LIBRARY_DIR}/pkgconfig COMPONENT development)

# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# The Debian packages: `cpack -G DEB` in a build folder in which everything is built (docs/install.md). An install rule belongs to
# one of the components program, development and python; one without COMPONENT, as of a man page, belongs to program.
set(REAMSIM_MAINTAINER "reamsim authors <reamsim@example.org>" CACHE STRING
  "Maintainer of the packages: a name and the address of who answers for them")

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL program development python)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
# Documents, compressed pages and overrides of lintian, which belong to packages alone.
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/debian_files.cmake)
set(CPACK_REAMSIM_SOURCES ${CMAKE_CURRENT_LIST_DIR})
set(CPACK_REAMSIM_LICENCES ${PROJECT_SOURCE_DIR}/LICENSES)
set(CPACK_REAMSIM_CHANGELOG ${PROJECT_SOURCE_DIR}/CHANGELOG.md)
set(CPACK_REAMSIM_PYTHON_DIR ${REAMSIM_PYTHON_DIR})

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${REAMSIM_MAINTAINER}")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION TRUE)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
# CPack puts another summary before each description, whose first line is the package's own.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_NAME} built using CMake")
set(same_version "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")

# What the program opens or starts at run time, beside the libraries that it is linked with: an OpenCL device, off-screen OpenGL,
# gnuplot, a font, Python for the statistics. See setup.sh for the same of a build.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME reamsim)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(egl "libegl1, libegl-mesa0, libgl1-mesa-dri")
if(REAMSIM_OSMESA)
  set(offscreen_opengl "libosmesa6")
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS ${egl})  # render.context: egl
else()
  set(offscreen_opengl ${egl})
endif()
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS
  "pocl-opencl-icd | opencl-icd, ${offscreen_opengl}, gnuplot-nox | gnuplot, fonts-dejavu-core, python3, python3-numpy, python3-scipy, python3-matplotlib, python3-yaml")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "ffmpeg, python3-reamsim")
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "simulator of glenoid reaming
reamsim removes bone from a CT scan, a surface mesh or a generated phantom
along the motion of a reamer, on an OpenCL device, and writes the cutting
force over time, pictures, and the reamed bone as an OpenVDB grid and as
meshes. It needs no display and no GPU. A film of a run needs ffmpeg.")

# Who links the static libraries needs the libraries behind them.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libreamsim-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libinsighttoolkit5-dev, libopenvdb-dev, libtbb-dev, libboost-dev, libboost-iostreams-dev, libassimp-dev, libfmt-dev, libyaml-cpp-dev, libeigen3-dev, nlohmann-json3-dev, ocl-icd-opencl-dev, opencl-headers, libssl-dev, zlib1g-dev, libseccomp-dev, pkgconf | pkg-config")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS "pocl-opencl-icd | opencl-icd")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "reamsim ${same_version}")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "simulator of glenoid reaming - C++ library
The header reamsim/simulation.h moves a reamer through bone step by step where
a program puts it: a controller, a haptic device, a search. The package has
the static libraries behind it, and what CMake and pkg-config need.")

# The module is built for one version of Python.
execute_process(COMMAND ${REAMSIM_PYTHON} -c "import sys; x, y = sys.version_info[:2]; print(f'python3 (>= {x}.{y}), python3 (<< {x}.{y + 1})')"
  OUTPUT_VARIABLE python_versions OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-reamsim)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${python_versions}, python3-numpy, python3-yaml, reamsim ${same_version}")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-matplotlib, python3-scipy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-pandas, python3-openvdb")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
  ${CMAKE_CURRENT_LIST_DIR}/postinst ${CMAKE_CURRENT_LIST_DIR}/prerm)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "simulator of glenoid reaming - Python package
The package reamsim runs scenarios and studies, reads their results as numpy
arrays and tables, plots them, and has the simulator in process, step by step.")

include(CPack)

# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Third-party libraries, all from Debian's packages (cmake/setup.sh lists them). Their headers count as system headers.
# ITKAnisotropicSmoothing serves a test. ITK first: since 5.4 it brings VTK, whose FindTBB stops where that of OpenVDB has defined TBB::tbb before.
find_package(ITK REQUIRED QUIET COMPONENTS
  ITKCommon ITKIOImageBase ITKIONRRD ITKIONIFTI ITKIOMeta ITKIOGDCM ITKSmoothing ITKAnisotropicSmoothing ITKCurvatureFlow
  ITKImageGrid ITKImageFunction ITKThresholding ITKConnectedComponents ITKDistanceMap ITKLabelMap)
# Since ITK 5.4 its smoothing filters link Fourier transforms, and these FFTW, whose development files ITK does not bring. None of
# them is used.
if(TARGET ITKFFT)
  set_target_properties(ITKFFT PROPERTIES INTERFACE_LINK_LIBRARIES ITKCommon)
endif()

find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(Boost REQUIRED)  # headers: Sobol sequence, quantiles, R-tree, XML
find_package(OpenCL REQUIRED)
find_package(yaml-cpp REQUIRED)
if(NOT TARGET yaml-cpp::yaml-cpp)  # its name since 0.8
  add_library(yaml-cpp::yaml-cpp ALIAS yaml-cpp)
endif()
find_package(assimp REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(ZLIB REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(JPEG REQUIRED)
find_package(PNG REQUIRED)
find_package(meshoptimizer REQUIRED)

list(APPEND CMAKE_MODULE_PATH "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB")
find_package(OpenVDB REQUIRED QUIET)

# ITK reads DICOM through GDCM and brings its libraries; its headers serve to read tags without pixels.
find_path(GDCM_HEADERS gdcmReader.h PATH_SUFFIXES gdcm-3.0 gdcm REQUIRED)

pkg_check_modules(EGL REQUIRED IMPORTED_TARGET egl)  # headers
# Opened at run time, where it exists: Mesa has no OSMesa since 25.1.
find_library(REAMSIM_OSMESA NAMES libOSMesa.so.8 OSMesa NO_CACHE)
set(REAMSIM_OFFSCREEN EGL)
if(REAMSIM_OSMESA)
  set(REAMSIM_OFFSCREEN OSMesa)
  message(STATUS "reamsim: pictures are rendered with OSMesa (${REAMSIM_OSMESA})")
else()
  message(STATUS "reamsim: pictures are rendered with EGL; this system has no OSMesa")
endif()
pkg_check_modules(SECCOMP REQUIRED IMPORTED_TARGET libseccomp)
pkg_check_modules(PANGOCAIRO REQUIRED IMPORTED_TARGET pangocairo)

if(REAMSIM_TESTS)
  find_package(GTest REQUIRED)
  find_package(benchmark REQUIRED)
endif()

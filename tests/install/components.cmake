# SPDX-License-Identifier: Apache-2.0
#
# Called with -D SOURCE=… -D WORK=… -P: a component that is missing is named, with those that are installed.
cmake_minimum_required(VERSION 3.22)
include(CMakePackageConfigHelpers)

file(REMOVE_RECURSE ${WORK})
set(BUILD_SHARED_LIBS ON) # without dependencies
set(STEREOGRID_COMPONENTS core io mcap)
set(CMAKE_INSTALL_PREFIX ${WORK})
set(folder ${WORK}/lib/cmake/stereogrid)
configure_package_config_file(${SOURCE}/cmake/stereogridConfig.cmake.in ${folder}/stereogridConfig.cmake
                              INSTALL_DESTINATION lib/cmake/stereogrid)
foreach(component IN ITEMS core odometry io)
  file(WRITE ${folder}/stereogrid_${component}.cmake "")
endforeach()

find_package(stereogrid CONFIG REQUIRED COMPONENTS core io PATHS ${WORK} NO_DEFAULT_PATH)
find_package(stereogrid CONFIG QUIET COMPONENTS lidar mcap PATHS ${WORK} NO_DEFAULT_PATH)
set(expected "stereogrid has no component lidar, mcap here. Installed: core, io.")
if(stereogrid_FOUND OR NOT stereogrid_NOT_FOUND_MESSAGE STREQUAL expected)
  message(FATAL_ERROR "missing components: '${stereogrid_NOT_FOUND_MESSAGE}', expected '${expected}'")
endif()

# one that may be missing is no error
find_package(stereogrid CONFIG QUIET COMPONENTS core OPTIONAL_COMPONENTS lidar PATHS ${WORK} NO_DEFAULT_PATH)
if(NOT stereogrid_FOUND)
  message(FATAL_ERROR "an optional component is missing: ${stereogrid_NOT_FOUND_MESSAGE}")
endif()

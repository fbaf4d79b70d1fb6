# SPDX-License-Identifier: Apache-2.0
#
# cmake -D SOURCE=… -D WORK=… -P modules_test.cmake: the project's CMake files without a build.
cmake_minimum_required(VERSION 3.22)
include(CMakePackageConfigHelpers)

# the same sources have one build id wherever they are, others another
function(get_build_id root result)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -D VERSION=1.2.3 -D ROOT=${root} -D OUTPUT=${WORK}/build_id.cpp -P
            ${SOURCE}/cmake/build_id.cmake COMMAND_ERROR_IS_FATAL ANY)
  file(READ ${WORK}/build_id.cpp text)
  if(NOT text MATCHES "\"(1\\.2\\.3\\+[0-9a-f]+)\"")
    message(FATAL_ERROR "no build id in ${text}")
  endif()
  set(${result} ${CMAKE_MATCH_1} PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
file(COPY ${SOURCE}/src ${SOURCE}/include DESTINATION ${WORK}/copy)
get_build_id(${SOURCE} original)
get_build_id(${WORK}/copy copy)
if(NOT original STREQUAL copy)
  message(FATAL_ERROR "a copy has another build id: ${original}, ${copy}")
endif()

file(APPEND ${WORK}/copy/src/config.cpp "\n")
get_build_id(${WORK}/copy changed)
file(RENAME ${WORK}/copy/src/pipeline/cuda/stages.hpp ${WORK}/copy/src/stages.hpp)
get_build_id(${WORK}/copy renamed)
if(changed STREQUAL copy OR renamed STREQUAL changed)
  message(FATAL_ERROR "the build id does not change with the sources: ${copy}, ${changed}, ${renamed}")
endif()

# architectures that each nvcc supports: 10.0 to 12.1 need 12.8, the numbers of Thor and Spark 13
include(${SOURCE}/cmake/cuda.cmake)
foreach(expected IN ITEMS "x86_64 12.4 75-real|80-real|86-real|89-real|90" "x86_64 13.2 75-real|80-real|86-real|89-real|90-real|120"
                          "aarch64 12.6 87-real|90" "aarch64 13.0 87-real|110-real|121" "arm64 12.2 87-real|90")
  string(REPLACE " " ";" parts "${expected}")
  list(GET parts 0 processor)
  list(GET parts 1 version)
  list(GET parts 2 wanted)
  stereogrid_cuda_architectures(${processor} ${version} found)
  string(REPLACE ";" "|" found "${found}")
  if(NOT found STREQUAL wanted)
    message(SEND_ERROR "nvcc ${version} on ${processor}: ${found}, not ${wanted}")
  endif()
endforeach()

# a component that is missing is named, with those that are installed
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

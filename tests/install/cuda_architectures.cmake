# SPDX-License-Identifier: Apache-2.0
#
# Architectures that each nvcc supports: 10.0 to 12.1 need 12.8, the numbers of Thor and Spark 13.
include(${CMAKE_CURRENT_LIST_DIR}/../../cmake/cuda_architectures.cmake)
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

# SPDX-License-Identifier: Apache-2.0
#
# For STEREOGRID_GPU_ONLY: what the reference back end takes of oneTBB and of the vector code, without either.
foreach(header blocked_range info parallel_for task_arena)
  configure_file(${PROJECT_SOURCE_DIR}/tests/tbb.hpp ${PROJECT_BINARY_DIR}/bare/oneapi/tbb/${header}.h COPYONLY)
endforeach()
target_include_directories(stereogrid PUBLIC $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/bare>)
target_sources(stereogrid PRIVATE ${PROJECT_SOURCE_DIR}/tests/cuda/bare/vectors.cpp)
target_include_directories(stereogrid PRIVATE ${PROJECT_SOURCE_DIR}/tests/core)

# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# With STEREOGRID_CUDA: compiles the formulas of src/*/model.hpp for the GPU, so that those headers stay usable on both
# sides. nvcc is looked for in PATH, then where NVIDIA's packages put it.

if(NOT CMAKE_CUDA_COMPILER AND NOT DEFINED ENV{CUDACXX})
  find_program(STEREOGRID_NVCC nvcc PATHS /usr/local/cuda/bin REQUIRED)
  set(CMAKE_CUDA_COMPILER ${STEREOGRID_NVCC})
endif()
if(NOT CMAKE_CUDA_ARCHITECTURES)
  set(CMAKE_CUDA_ARCHITECTURES 75 80 90) # each with its PTX, for what comes later
endif()
enable_language(CUDA)
# older CMake, Debian 12's too, does not know how nvcc spells C++20
if(NOT CMAKE_CUDA20_STANDARD_COMPILE_OPTION)
  set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION -std=c++20)
  set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION -std=c++20)
endif()

add_library(stereogrid_cuda_models OBJECT ${PROJECT_SOURCE_DIR}/tests/cuda/models_compile.cu)
target_include_directories(stereogrid_cuda_models PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src)
set_target_properties(stereogrid_cuda_models PROPERTIES CUDA_STANDARD 20 CUDA_STANDARD_REQUIRED ON)
# host and device must round alike; a model that cannot run on the device must not pass with a warning
target_compile_options(stereogrid_cuda_models PRIVATE --fmad=false --Werror=all-warnings)

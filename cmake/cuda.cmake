# SPDX-License-Identifier: Apache-2.0
#
# With STEREOGRID_CUDA: the language CUDA and its settings. nvcc is looked for in PATH, then where NVIDIA's packages put
# it.

# Default CUDA architectures: machine code for each GPU that the compiler supports, and PTX of the last for later ones.
# `version`: of nvcc; "": unknown.
function(stereogrid_cuda_architectures processor version result)
  if(processor MATCHES "aarch64|arm64")
    if(version VERSION_LESS 13)
      set(architectures 87-real 90) # JetPack 6: Orin
    else()
      set(architectures 87-real 110-real 121)
    endif()
  elseif(version VERSION_LESS 12.8)
    set(architectures 75-real 80-real 86-real 89-real 90)
  else()
    set(architectures 75-real 80-real 86-real 89-real 90-real 120)
  endif()
  set(${result} ${architectures} PARENT_SCOPE)
endfunction()

if(NOT STEREOGRID_CUDA)
  return()
endif()
if(NOT CMAKE_CUDA_COMPILER AND NOT DEFINED ENV{CUDACXX})
  find_program(STEREOGRID_NVCC nvcc PATHS /usr/local/cuda/bin REQUIRED)
  set(CMAKE_CUDA_COMPILER ${STEREOGRID_NVCC})
endif()
if(NOT CMAKE_CUDA_ARCHITECTURES AND NOT DEFINED ENV{CUDAARCHS})
  set(nvcc ${CMAKE_CUDA_COMPILER})
  if(NOT nvcc)
    set(nvcc $ENV{CUDACXX})
  endif()
  execute_process(COMMAND ${nvcc} --version OUTPUT_VARIABLE nvcc_version)
  string(REGEX MATCH "release ([0-9.]+)" nvcc_version "${nvcc_version}")
  stereogrid_cuda_architectures("${CMAKE_SYSTEM_PROCESSOR}" "${CMAKE_MATCH_1}" CMAKE_CUDA_ARCHITECTURES)
endif()
if(STEREOGRID_CCACHE AND NOT CMAKE_CUDA_COMPILER_LAUNCHER)
  set(CMAKE_CUDA_COMPILER_LAUNCHER ${STEREOGRID_CCACHE})
endif()
enable_language(CUDA)
# older CMake, Debian 12's too, does not know how nvcc spells C++20
if(NOT CMAKE_CUDA20_STANDARD_COMPILE_OPTION)
  set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION -std=c++20)
  set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION -std=c++20)
endif()
set(CMAKE_CUDA_STANDARD 20)
set(CMAKE_CUDA_STANDARD_REQUIRED ON)
set(CMAKE_CUDA_RUNTIME_LIBRARY Static) # so that only the driver must be there at run time

# Link a CUDA target to it. Host and device must round alike.
add_library(stereogrid_cuda_compiler INTERFACE)
target_compile_options(stereogrid_cuda_compiler INTERFACE $<$<COMPILE_LANGUAGE:CUDA>:--fmad=false --expt-relaxed-constexpr
                                                          -Xcompiler=-ffp-contract=off,-Wall,-Wextra>)
if(STEREOGRID_WERROR)
  target_compile_options(stereogrid_cuda_compiler INTERFACE $<$<COMPILE_LANGUAGE:CUDA>:--Werror=all-warnings
                                                            -Xcompiler=-Werror>)
endif()

# SPDX-License-Identifier: Apache-2.0

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

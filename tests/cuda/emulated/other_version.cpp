// SPDX-License-Identifier: Apache-2.0
//
// Libraries that the core must not use.
#include "pipeline/cuda_library.hpp"

#if defined OTHER_SOURCES
#define FUNCTION stereogrid_cuda_library_4
#define BUILD "0.0.1+0123"
#define SIZES stereogrid::interface_sizes()
#elif defined OTHER_SIZES
#define FUNCTION stereogrid_cuda_library_4
#define BUILD stereogrid::build_id().data()
#define SIZES (stereogrid::interface_sizes() + 1)
#elif defined OTHER_FUNCTION
#define FUNCTION stereogrid_cuda_library_1
#define BUILD stereogrid::build_id().data()
#define SIZES stereogrid::interface_sizes()
#endif

extern "C" const stereogrid::CudaLibrary* FUNCTION() {
  static const stereogrid::CudaLibrary library{BUILD, SIZES, nullptr};
  return &library;
}

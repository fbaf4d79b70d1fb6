// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda_library.hpp"

extern "C" const stereogrid::CudaLibrary* stereogrid_cuda_library_1() {
  static const stereogrid::CudaLibrary library{"0.0.1", stereogrid::interface_sizes(), nullptr};
  return &library;
}

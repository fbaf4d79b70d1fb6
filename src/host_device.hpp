// SPDX-License-Identifier: Apache-2.0
#pragma once

// Marks the functions of the model.hpp files, which are compiled for CPU and GPU alike.
#if defined(__CUDACC__)
#define STEREOGRID_HD __host__ __device__
#else
#define STEREOGRID_HD
#endif

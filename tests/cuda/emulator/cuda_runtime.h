// SPDX-License-Identifier: Apache-2.0
//
// Stands in for CUDA's header of this name where .cu files are compiled as plain C++, so that kernels can be run and
// tested without a GPU. One operating-system thread; a block's threads are fibers that change at barriers, blocks run
// one after another. Device memory is the heap, filled with 0xA5.
#pragma once

#include "device.hpp"
#include "runtime.hpp"

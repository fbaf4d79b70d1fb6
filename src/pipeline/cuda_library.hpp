// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

#include "pipeline/stages.hpp"

namespace stereogrid {

/// What libstereogrid_cuda.so offers: the result of its function `cuda_library_function`, extern "C", without
/// arguments. The library is loaded when a pipeline asks for it, so that programs run where there is no GPU.
struct CudaLibrary {
  const char* build;  ///< build_id() there: both sides must come from the same sources
  std::size_t sizes;  ///< interface_sizes() there: and mean the same structures, whatever compiled them
  std::unique_ptr<Stages> (*stages)(const Config& config, const Rig& level_rig, int device,
                                    const StagesOptions& options);  ///< throws DeviceError
};

constexpr const char* cuda_library_function{"stereogrid_cuda_library_3"};

/// A number that changes with the structures that cross the interface: the same sources, built otherwise.
constexpr std::size_t interface_sizes() {
  return ((sizeof(Config) * 1024 + sizeof(FrameResult)) * 1024 + sizeof(LevelFrame)) * 1024 + sizeof(Rig);
}

/// Looks for the library beside this program or library, in the folder that `cmake --install` put it in, then where
/// the loader looks; the environment variable STEREOGRID_CUDA_LIBRARY names another file. Neither the folder that the
/// program is started in nor the name that it is called by matters. Throws DeviceError, which says what is missing.
std::unique_ptr<Stages> cuda_stages(const Config& config, const Rig& level_rig, int device,
                                    const StagesOptions& options);

}  // namespace stereogrid

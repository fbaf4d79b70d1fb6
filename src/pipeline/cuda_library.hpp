// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "pipeline/stages.hpp"

namespace stereogrid {

/// The version and a hash of all sources of the core, such as "0.1.0+2f7a…": equal in builds of the same sources, on
/// whatever machine. Written when the library is built (cmake/build_id.cmake). Ends with a zero.
[[nodiscard]] std::string_view build_id();

/// Interface of libstereogrid_cuda.so: the result of its function `cuda_library_function`, extern "C", without
/// arguments. The library is loaded when a pipeline requests it, so that programs run without a GPU.
struct CudaLibrary {
  const char* build;  ///< build_id() there: both sides must come from the same sources
  std::size_t sizes;  ///< interface_sizes() there: and mean the same structures, whatever compiled them
  std::unique_ptr<Stages> (*stages)(const Config& config, const Rig& level_rig, int device,
                                    const StagesOptions& options);  ///< throws DeviceError
};

constexpr const char* cuda_library_function{"stereogrid_cuda_library_4"};

/// A number that changes with the structures that cross the interface: the same sources, built otherwise.
constexpr std::size_t interface_sizes() {
  return ((sizeof(Config) * 1024 + sizeof(FrameResult)) * 1024 + sizeof(LevelFrame)) * 1024 + sizeof(Rig);
}

/// Loads the library. Search order: beside this program or library, in the folder of `cmake --install`, in the paths of
/// the loader; the environment variable STEREOGRID_CUDA_LIBRARY names another file. The result depends neither on the
/// current folder nor on the name of the program. Throws DeviceError with the reason.
std::unique_ptr<Stages> cuda_stages(const Config& config, const Rig& level_rig, int device,
                                    const StagesOptions& options);

}  // namespace stereogrid

// SPDX-License-Identifier: Apache-2.0
//
// Exported function of libstereogrid_cuda.so.
#include "pipeline/cuda/stages.hpp"
#include "pipeline/cuda_library.hpp"

namespace stereogrid {
namespace {

std::unique_ptr<Stages> start(const Config& config, const Rig& level_rig, int device, const StagesOptions& options) {
  return std::make_unique<CudaStages>(config, level_rig, device, options);
}

}  // namespace
}  // namespace stereogrid

extern "C" __attribute__((visibility("default"))) const stereogrid::CudaLibrary* stereogrid_cuda_library_4() {
  static const stereogrid::CudaLibrary library{stereogrid::build_id().data(), stereogrid::interface_sizes(),
                                               stereogrid::start};
  return &library;
}

// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include "pipeline/host_stages.hpp"

namespace stereogrid {

std::unique_ptr<Stages> reference_stages(const Config& config, const Rig& level_rig, Cpu& cpu,
                                         const StagesOptions& options) {
  static Reference reference;
  return std::make_unique<HostStages<Reference>>(config, level_rig, cpu, options, reference);
}

}  // namespace stereogrid

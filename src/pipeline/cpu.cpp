// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include "pipeline/host_stages.hpp"

namespace stereogrid {

std::unique_ptr<Stages> cpu_stages(const Config& config, const Rig& level_rig, Cpu& cpu, const StagesOptions& options) {
  return std::make_unique<HostStages<Cpu>>(config, level_rig, cpu, options, cpu);
}

}  // namespace stereogrid

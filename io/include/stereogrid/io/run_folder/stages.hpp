// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include "stereogrid/pipeline.hpp"

namespace stereogrid::io {

struct StageField {
  std::string_view name;
  double StageTimes::*milliseconds;
};

/// The names that timings carry in every file.
constexpr std::array<StageField, 9> stage_fields{{{"odometry", &StageTimes::odometry},
                                                  {"match", &StageTimes::match},
                                                  {"ground", &StageTimes::ground},
                                                  {"count", &StageTimes::count},
                                                  {"project", &StageTimes::project},
                                                  {"filter", &StageTimes::filter},
                                                  {"flow", &StageTimes::flow},
                                                  {"track", &StageTimes::track},
                                                  {"total", &StageTimes::total}}};

}  // namespace stereogrid::io

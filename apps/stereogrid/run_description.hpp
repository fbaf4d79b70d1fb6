// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "input.hpp"
#include "stereogrid/io/run_folder/description.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// Description of a run of `pipeline` over frames of an input; the caller sets preset and outputs.
[[nodiscard]] io::RunDescription describe_run(const Input& input, const InputOptions& options, const Pipeline& pipeline,
                                              io::FrameRange frames);

}  // namespace stereogrid::app

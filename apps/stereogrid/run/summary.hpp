// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/camera.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"

namespace stereogrid::app {

/// What a run has done, on stdout; silent under --quiet.
void print_summary(const io::RunRecord& record, double frames_per_second);

/// How many frames say nothing, and what would mend it. `rig`: as given; `mounted`: as it was found to be.
void warn_of_unknown_frames(const io::RunRecord& record, const Rig& rig, const Rig& mounted);

}  // namespace stereogrid::app

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/frame.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"

namespace stereogrid::app {

/// The first frame that can be loaded. Throws InputError where there is none.
[[nodiscard]] StereoFrame first_usable_frame(const FrameSource& source, io::FrameRange range);

/// Adds the skipped frames that the files of a killed run do not list: those missing between completed ones. Loads them
/// again for the reason.
void recall_skipped(const FrameSource& source, io::RunRecord& record);

}  // namespace stereogrid::app

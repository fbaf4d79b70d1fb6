// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "read/batch.hpp"

namespace stereogrid::mcap {

/// Summary section at the end of a file.
struct SummarySection {
  std::uint64_t data_end{0};  // end of the data section: start of the summary or the footer
  bool is_complete{false};    // all messages are indexed
  Contents contents;          // without header
  std::vector<Place> chunks;  // in the order of the file
};

/// Throws InputError: no MCAP file.
void require_mcap(const FileInput& file);

/// Profile and library. Throws Malformed.
void read_header(const FileInput& file, Contents& contents);

/// Throws Malformed where there is no whole end of a file, or what it says contradicts itself.
[[nodiscard]] SummarySection read_summary(const FileInput& file);

}  // namespace stereogrid::mcap

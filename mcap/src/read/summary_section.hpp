// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "read/batch.hpp"

namespace stereogrid::mcap {

/// What the end of a file says of the rest.
struct SummarySection {
  std::uint64_t data_end{0};  // where the data section ends, the summary or the footer begins
  bool is_complete{false};    // it tells of every message, and where it is
  Contents contents;          // without header
  std::vector<Place> chunks;  // in the order of the file
};

/// Throws InputError where it is no MCAP file at all.
void require_mcap(const FileInput& file);

/// Profile and library. Throws Malformed.
void read_header(const FileInput& file, Contents& contents);

/// Throws Malformed where there is no whole end of a file, or what it says contradicts itself.
[[nodiscard]] SummarySection read_summary(const FileInput& file);

}  // namespace stereogrid::mcap

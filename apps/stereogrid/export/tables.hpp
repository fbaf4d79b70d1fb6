// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid::app {

// Parts of files of comma-separated values (RFC 4180), each line with its end; docs/format.md has the columns. Numbers
// have as many digits as bring the same number back; inf and nan are spelled so, which NumPy and pandas read.

[[nodiscard]] std::string frame_header();
[[nodiscard]] std::string frame_row(const io::RunFrame& frame);

[[nodiscard]] std::string obstacle_header();
/// None: an empty text.
[[nodiscard]] std::string obstacle_rows(const io::RunFrame& frame);

/// Header line for scans with as many beams.
[[nodiscard]] std::string scan_header(const messages::sensor_msgs::LaserScan& scan);
[[nodiscard]] std::string scan_row(const io::RunFrame& frame, const messages::sensor_msgs::LaserScan& scan);

/// A line for each cell, and the header.
[[nodiscard]] std::string grid_table(const GridGeometry& geometry, const io::RunGrids& grids);

}  // namespace stereogrid::app

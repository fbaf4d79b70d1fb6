// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "stereogrid/io/recording.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/rosbag/topics.hpp"

namespace stereogrid::rosbag {

/// True for an .mcap, a .db3, or a folder of them.
[[nodiscard]] bool is_bag(const std::filesystem::path& path);

/// Options for a bag, as set by the user.
struct BagOptions {
  ImageTopics topics;  ///< "": found
  double pair_tolerance_ms{10};
};

/// Searches the whole bag, whose path is that of the arguments, for the images of both cameras. Throws InputError.
[[nodiscard]] std::unique_ptr<io::Recording> bag_recording(std::unique_ptr<mcap::Bag> bag,
                                                           const io::InputArguments& arguments,
                                                           const BagOptions& options);

/// The same of a path that is one. Throws InputError.
[[nodiscard]] std::unique_ptr<io::Recording> open_recording(const io::InputArguments& arguments,
                                                            const BagOptions& options);

}  // namespace stereogrid::rosbag

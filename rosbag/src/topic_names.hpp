// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stereogrid/rosbag/topics.hpp"

namespace stereogrid::rosbag {

inline constexpr const char* say_which{"Say which: --left-topic TOPIC --right-topic TOPIC."};

/// "/a/b/c" → "/a/b"
[[nodiscard]] std::string parent_of(const std::string& name);
/// Without the transport ("/compressed", "/compressedDepth").
[[nodiscard]] std::string base_of(const mcap::Topic& images);

/// The best pair of images and depth or disparities of them. `left`, `depth`: "": any. Throws InputError where several
/// cameras have one.
[[nodiscard]] std::optional<ImageTopics> find_depth(const std::string& bag, const std::vector<mcap::Topic>& topics,
                                                    const Encodings& encodings, const ImageTopics& asked);

/// "/a (CompressedVideo), /b (FFMPEGPacket)"; empty: no topic holds video.
[[nodiscard]] std::string list_of_videos(const std::vector<mcap::Topic>& topics);

}  // namespace stereogrid::rosbag

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/rosbag/rosbag.hpp"

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

[[noreturn]] void fail(const NamedInfo& info, const std::string& what, const std::string& mend = "");

/// Topics with messages of CameraInfo.
[[nodiscard]] std::vector<std::string> info_topics(const mcap::Bag& bag);
[[nodiscard]] NamedInfo named(const std::string& name, const std::string& topic);
/// The first message of a topic that can be decoded. Throws InputError: there is none.
[[nodiscard]] NamedInfo info_of(const mcap::Bag& bag, const std::string& name, const std::string& topic);

/// Cuts the region of interest out of the calibrated image; K and P are of the whole sensor. Binning is left to the
/// scaling of a calibration of larger images.
void crop(NamedInfo& info, int width_px, int height_px);

[[nodiscard]] io::RosCamera camera_of(const NamedInfo& info);

/// Calibration of images with depth, which have one camera. Throws InputError.
[[nodiscard]] io::Calibration depth_calibration_of(const mcap::Bag& bag, const std::string& name,
                                                   const ImageTopics& topics, int width_px, int height_px);

}  // namespace stereogrid::rosbag

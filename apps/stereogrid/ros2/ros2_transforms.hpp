// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "ros2/transform_buffer.hpp"
#include "stereogrid/dds/node.hpp"
#include "stereogrid/mcap/bag.hpp"

namespace stereogrid::app {

/// A buffer that receives /tf and /tf_static while the node exists.
[[nodiscard]] std::shared_ptr<TransformBuffer> subscribe_transforms(dds::Node& node);

/// frame_id of the next image on a topic; "": none has come within a second, or it has none.
[[nodiscard]] std::string frame_of_images(dds::Node& node, const mcap::Topic& images);

/// True: the frames are connected, which is waited for 0.1 s.
[[nodiscard]] bool are_connected(TransformBuffer& transforms, const std::string& target, const std::string& source);

/// Sets height, pitch and roll from base_footprint or base_link to the camera's frame; logs it. Returns false and
/// changes nothing where TF has neither, or the camera is not above z = 0 there.
[[nodiscard]] bool set_extrinsics_of_tf(Rig& rig, TransformBuffer& transforms, const std::string& camera_frame);

}  // namespace stereogrid::app

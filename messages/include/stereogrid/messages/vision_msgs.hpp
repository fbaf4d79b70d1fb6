// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

// Version 4, of Humble and later.
namespace stereogrid::messages::vision_msgs {

struct ObjectHypothesis {
  STEREOGRID_MESSAGE("vision_msgs/msg/ObjectHypothesis", class_id, score);

  std::string class_id;
  double score{0};
};

struct ObjectHypothesisWithPose {
  STEREOGRID_MESSAGE("vision_msgs/msg/ObjectHypothesisWithPose", hypothesis, pose);

  ObjectHypothesis hypothesis;
  geometry_msgs::PoseWithCovariance pose;
};

struct BoundingBox3D {
  STEREOGRID_MESSAGE("vision_msgs/msg/BoundingBox3D", center, size);

  geometry_msgs::Pose center;
  geometry_msgs::Vector3 size;  ///< m, along the axes of `center`
};

struct Detection3D {
  STEREOGRID_MESSAGE("vision_msgs/msg/Detection3D", header, results, bbox, id);

  std_msgs::Header header;
  std::vector<ObjectHypothesisWithPose> results;
  BoundingBox3D bbox;
  std::string id;  ///< the same in all messages about an object
};

struct Detection3DArray {
  STEREOGRID_MESSAGE("vision_msgs/msg/Detection3DArray", header, detections);

  std_msgs::Header header;
  std::vector<Detection3D> detections;
};

}  // namespace stereogrid::messages::vision_msgs

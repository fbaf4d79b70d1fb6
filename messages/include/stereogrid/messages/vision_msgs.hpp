// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

// Version 4, of Humble and later.
namespace stereogrid::messages::vision_msgs {

struct ObjectHypothesis {
  static constexpr std::string_view type_name{"vision_msgs/msg/ObjectHypothesis"};

  std::string class_id;
  double score{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("class_id", self.class_id);
    visit("score", self.score);
  }
};

struct ObjectHypothesisWithPose {
  static constexpr std::string_view type_name{"vision_msgs/msg/ObjectHypothesisWithPose"};

  ObjectHypothesis hypothesis;
  geometry_msgs::PoseWithCovariance pose;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("hypothesis", self.hypothesis);
    visit("pose", self.pose);
  }
};

struct BoundingBox3D {
  static constexpr std::string_view type_name{"vision_msgs/msg/BoundingBox3D"};

  geometry_msgs::Pose center;
  geometry_msgs::Vector3 size;  ///< m, along the axes of `center`

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("center", self.center);
    visit("size", self.size);
  }
};

struct Detection3D {
  static constexpr std::string_view type_name{"vision_msgs/msg/Detection3D"};

  std_msgs::Header header;
  std::vector<ObjectHypothesisWithPose> results;
  BoundingBox3D bbox;
  std::string id;  ///< the same in all messages about an object

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("results", self.results);
    visit("bbox", self.bbox);
    visit("id", self.id);
  }
};

struct Detection3DArray {
  static constexpr std::string_view type_name{"vision_msgs/msg/Detection3DArray"};

  std_msgs::Header header;
  std::vector<Detection3D> detections;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("detections", self.detections);
  }
};

}  // namespace stereogrid::messages::vision_msgs

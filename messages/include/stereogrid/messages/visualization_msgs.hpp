// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::visualization_msgs {

struct UVCoordinate {
  static constexpr std::string_view type_name{"visualization_msgs/msg/UVCoordinate"};

  float u{0};
  float v{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("u", self.u);
    visit("v", self.v);
  }
};

struct MeshFile {
  static constexpr std::string_view type_name{"visualization_msgs/msg/MeshFile"};

  std::string filename;
  std::vector<std::uint8_t> data;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("filename", self.filename);
    visit("data", self.data);
  }
};

struct Marker {
  static constexpr std::string_view type_name{"visualization_msgs/msg/Marker"};

  std_msgs::Header header;
  std::string ns;
  std::int32_t id{0};  ///< a marker replaces the one of the same ns and id
  std::int32_t type{0};
  std::int32_t action{0};
  geometry_msgs::Pose pose;
  geometry_msgs::Vector3 scale;  ///< m
  std_msgs::ColorRGBA color;
  builtin_interfaces::Duration lifetime;  ///< 0: for ever
  bool frame_locked{false};
  std::vector<geometry_msgs::Point> points;
  std::vector<std_msgs::ColorRGBA> colors;
  std::string texture_resource;
  sensor_msgs::CompressedImage texture;
  std::vector<UVCoordinate> uv_coordinates;
  std::string text;
  std::string mesh_resource;
  MeshFile mesh_file;
  bool mesh_use_embedded_materials{false};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("ns", self.ns);
    visit("id", self.id);
    visit("type", self.type);
    visit("action", self.action);
    visit("pose", self.pose);
    visit("scale", self.scale);
    visit("color", self.color);
    visit("lifetime", self.lifetime);
    visit("frame_locked", self.frame_locked);
    visit("points", self.points);
    visit("colors", self.colors);
    visit("texture_resource", self.texture_resource);
    visit("texture", self.texture);
    visit("uv_coordinates", self.uv_coordinates);
    visit("text", self.text);
    visit("mesh_resource", self.mesh_resource);
    visit("mesh_file", self.mesh_file);
    visit("mesh_use_embedded_materials", self.mesh_use_embedded_materials);
  }
};

struct MarkerArray {
  static constexpr std::string_view type_name{"visualization_msgs/msg/MarkerArray"};

  std::vector<Marker> markers;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("markers", self.markers);
  }
};

}  // namespace stereogrid::messages::visualization_msgs

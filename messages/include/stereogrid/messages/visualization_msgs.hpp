// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::visualization_msgs {

struct UVCoordinate {
  STEREOGRID_MESSAGE("visualization_msgs/msg/UVCoordinate", u, v);

  float u{0};
  float v{0};
};

struct MeshFile {
  STEREOGRID_MESSAGE("visualization_msgs/msg/MeshFile", filename, data);

  std::string filename;
  std::vector<std::uint8_t> data;
};

struct Marker {
  STEREOGRID_MESSAGE("visualization_msgs/msg/Marker", header, ns, id, type, action, pose, scale, color, lifetime,
                     frame_locked, points, colors, texture_resource, texture, uv_coordinates, text, mesh_resource,
                     mesh_file, mesh_use_embedded_materials);

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
};

struct MarkerArray {
  STEREOGRID_MESSAGE("visualization_msgs/msg/MarkerArray", markers);

  std::vector<Marker> markers;
};

}  // namespace stereogrid::messages::visualization_msgs

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "export/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <string_view>
#include <vector>

#include "stereogrid/io/run_folder/obstacle_fields.hpp"
#include "stereogrid/io/run_folder/stages.hpp"

namespace stereogrid::app {
namespace {

std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted{"\""};
  for (const char letter : text) quoted += letter == '"' ? std::string{"\"\""} : std::string{letter};
  return quoted + "\"";
}

std::string field(bool value) {
  return value ? "1" : "0";
}

template <class Number>
std::string field(const Number& number) {
  return fmt::format("{}", number);
}

/// Takes columns, of which it keeps the names or the values.
class Line {
 public:
  enum class Of { names, values };
  explicit Line(Of kept) : kept_{kept} {}

  template <class Value>
  void operator()(const std::string& name, const Value& value) {
    columns_.push_back({name, kept_ == Of::names ? name : field(value)});
  }
  template <class Value>
  void operator()(const io::ObstacleField& of, const Value& value) {
    (*this)(of.name, value);
  }
  void operator()(const io::ObstacleField& of, const ObstacleKind& kind) {
    (*this)(of.name, std::string{names_of(kind)[static_cast<std::size_t>(kind)]});
  }
  void operator()(const io::ObstacleField& of, const Covariance2& covariance) {
    const std::string_view name{of.name};
    const std::string_view quantity{name.substr(0, name.find('_'))};
    (*this)(fmt::format("{}_xx_{}", quantity, of.square_unit), covariance.xx);
    (*this)(fmt::format("{}_xy_{}", quantity, of.square_unit), covariance.xy);
    (*this)(fmt::format("{}_yy_{}", quantity, of.square_unit), covariance.yy);
  }
  void operator()(const io::ObstacleField& /*of*/, const Outline& /*outline*/) {}  // no column

  /// Sorts the columns; those that are not in `order` come last.
  void arrange(std::span<const std::string_view> order) {
    std::ranges::stable_sort(columns_, {}, [order](const Column& one) { return std::ranges::find(order, one.name); });
  }
  [[nodiscard]] std::string text() const {
    std::string text;
    for (const Column& column : columns_) text += (text.empty() ? "" : ",") + column.text;
    return text + '\n';
  }

 private:
  struct Column {
    std::string name;
    std::string text;
  };

  Of kept_;
  std::vector<Column> columns_;
};

void visit_instant(Line& line, const io::RunFrame& frame) {
  line("index", frame.index);
  line("name", frame.name);
  line("stamp_ns", frame.stamp_ns);
}

std::string words_of(const std::vector<FrameStatus>& status) {
  std::string words;
  for (const FrameStatus flag : status) {
    if (!words.empty()) words += ' ';
    words += names_of(flag)[static_cast<std::size_t>(flag)];
  }
  return words;
}

std::string frame_line(Line line, const io::RunFrame& frame) {
  visit_instant(line, frame);
  line("x_m", frame.world_from_vehicle.x_m);
  line("y_m", frame.world_from_vehicle.y_m);
  line("yaw_rad", frame.world_from_vehicle.yaw_rad);
  line("status", words_of(frame.status));
  line("obstacles", frame.obstacles.size());
  for (const io::StageField& stage : io::stage_fields) {
    line(fmt::format("{}_ms", stage.name), frame.timing_ms.*stage.milliseconds);
  }
  return line.text();
}

// A new field becomes the last column.
constexpr std::string_view obstacle_columns[]{"index",          "name",          "stamp_ns",      "id",
                                              "kind",           "x_m",           "y_m",           "world_x_m",
                                              "world_y_m",      "vx_mps",        "vy_mps",        "length_m",
                                              "width_m",        "height_m",      "yaw_rad",       "yaw_rate_radps",
                                              "length_sigma_m", "width_sigma_m", "yaw_sigma_rad", "age_s",
                                              "unseen_s",       "occupancy",     "confirmed",     "moving",
                                              "coasting"};

std::string obstacle_line(Line line, const io::RunFrame& frame, const Obstacle& obstacle) {
  const Point2 in_world{frame.world_from_vehicle * Point2{obstacle.x_m, obstacle.y_m}};
  visit_instant(line, frame);
  io::visit_fields(obstacle, line);
  line("world_x_m", in_world.x);
  line("world_y_m", in_world.y);
  line.arrange(obstacle_columns);
  return line.text();
}

std::string scan_line(Line line, const io::RunFrame& frame, const messages::sensor_msgs::LaserScan& scan) {
  line("stamp_ns", frame.stamp_ns);
  line("angle_min", scan.angle_min);
  line("angle_max", scan.angle_max);
  line("angle_increment", scan.angle_increment);
  line("range_min", scan.range_min);
  line("range_max", scan.range_max);
  for (std::size_t i{0}; i < scan.ranges.size(); ++i) line(fmt::format("range_{}", i), scan.ranges[i]);
  return line.text();
}

}  // namespace

std::string frame_header() {
  return frame_line(Line{Line::Of::names}, {});
}

std::string frame_row(const io::RunFrame& frame) {
  return frame_line(Line{Line::Of::values}, frame);
}

std::string obstacle_header() {
  return obstacle_line(Line{Line::Of::names}, {}, {});
}

std::string obstacle_rows(const io::RunFrame& frame) {
  std::string rows;
  for (const Obstacle& obstacle : frame.obstacles) rows += obstacle_line(Line{Line::Of::values}, frame, obstacle);
  return rows;
}

std::string scan_header(const messages::sensor_msgs::LaserScan& scan) {
  return scan_line(Line{Line::Of::names}, {}, scan);
}

std::string scan_row(const io::RunFrame& frame, const messages::sensor_msgs::LaserScan& scan) {
  return scan_line(Line{Line::Of::values}, frame, scan);
}

std::string grid_table(const GridGeometry& geometry, const io::RunGrids& grids) {
  std::string table{"ix,iy,x_m,y_m,observed,occupancy,vx_mps,vy_mps\n"};
  for (int iy{0}; iy < geometry.ny; ++iy) {
    for (int ix{0}; ix < geometry.nx; ++ix) {
      const Point2 centre{geometry.centre(ix, iy)};
      fmt::format_to(std::back_inserter(table), "{},{},{:.6g},{:.6g},{},{},{},{}\n", ix, iy, centre.x, centre.y,
                     grids.observed(ix, iy), grids.occupancy(ix, iy), grids.velocity_x(ix, iy),
                     grids.velocity_y(ix, iy));
    }
  }
  return table;
}

}  // namespace stereogrid::app

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "export/tables.hpp"

#include <fmt/format.h>

#include <iterator>
#include <string_view>

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
  void operator()(std::string_view name, const Value& value) {
    if (!text_.empty()) text_ += ',';
    text_ += kept_ == Of::names ? std::string{name} : field(value);
  }
  [[nodiscard]] std::string text() const { return text_ + '\n'; }

 private:
  Of kept_;
  std::string text_;
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

std::string obstacle_line(Line line, const io::RunFrame& frame, const Obstacle& obstacle) {
  const Point2 in_world{frame.world_from_vehicle * Point2{obstacle.x_m, obstacle.y_m}};
  visit_instant(line, frame);
  line("id", obstacle.id);
  line("kind", std::string{names_of(obstacle.kind)[static_cast<std::size_t>(obstacle.kind)]});
  line("x_m", obstacle.x_m);
  line("y_m", obstacle.y_m);
  line("world_x_m", in_world.x);
  line("world_y_m", in_world.y);
  line("vx_mps", obstacle.vx_mps);
  line("vy_mps", obstacle.vy_mps);
  line("length_m", obstacle.length_m);
  line("width_m", obstacle.width_m);
  line("height_m", obstacle.height_m);
  line("yaw_rad", obstacle.yaw_rad);
  line("yaw_rate_radps", obstacle.yaw_rate_radps);
  line("length_sigma_m", obstacle.length_sigma_m);
  line("width_sigma_m", obstacle.width_sigma_m);
  line("yaw_sigma_rad", obstacle.yaw_sigma_rad);
  line("age_s", obstacle.age_s);
  line("unseen_s", obstacle.unseen_s);
  line("occupancy", obstacle.occupancy);
  line("confirmed", obstacle.confirmed);
  line("moving", obstacle.moving);
  line("coasting", obstacle.coasting);
  line("position_xx_m2", obstacle.position_covariance.xx);
  line("position_xy_m2", obstacle.position_covariance.xy);
  line("position_yy_m2", obstacle.position_covariance.yy);
  line("velocity_xx_m2ps2", obstacle.velocity_covariance.xx);
  line("velocity_xy_m2ps2", obstacle.velocity_covariance.xy);
  line("velocity_yy_m2ps2", obstacle.velocity_covariance.yy);
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

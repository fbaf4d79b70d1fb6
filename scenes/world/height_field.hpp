// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "stereogrid/frame.hpp"
#include "world/shapes.hpp"

namespace stereogrid::scenes {

/// Height of the ground over (x, y): bilinear patches between the lines of a lattice. A vertical wall stands where two
/// neighbouring patches differ in height on their common side. Without patches: the plane z = 0.
class HeightField {
 public:
  /// z + slope_x·X + slope_y·Y + twist·X·Y, X and Y from the patch's corner of smallest x and y.
  struct Patch {
    double z{0};
    double slope_x{0};
    double slope_y{0};
    double twist{0};
  };
  /// Intersection of a ray with the ground, at origin + t · direction.
  struct Crossing {
    double t{0};
    Vector3 normal{0, 0, 1};
    bool is_wall{false};
  };

  HeightField() = default;
  /// Lines ascend, two or more each way. Patch (i, j) is patches[j · (lines_x.size() − 1) + i].
  HeightField(std::vector<double> lines_x, std::vector<double> lines_y, std::vector<Patch> patches);

  [[nodiscard]] bool is_flat() const { return patches_.empty(); }
  [[nodiscard]] double lowest_m() const { return lowest_m_; }
  [[nodiscard]] double highest_m() const { return highest_m_; }
  /// On a line between patches: the height of the patch with larger x or y.
  [[nodiscard]] double height_at(double x, double y) const;
  /// Finds the first crossing from above with t > 0. A ray that starts below the ground has none.
  [[nodiscard]] bool crosses(Vector3 origin, Vector3 direction, Crossing& crossing) const;

 private:
  class Walk;
  struct Place {
    std::size_t i{0};
    std::size_t j{0};
  };
  [[nodiscard]] Place place_of(double x, double y) const;
  [[nodiscard]] const Patch& patch(Place at) const { return patches_[at.j * (lines_x_.size() - 1) + at.i]; }

  std::vector<double> lines_x_;
  std::vector<double> lines_y_;
  std::vector<Patch> patches_;
  double lowest_m_{0};
  double highest_m_{0};
};

/// Axes and origin of a frame in the world.
struct Frame3 {
  Vector3 origin;
  Vector3 forward{1, 0, 0};
  Vector3 left{0, 1, 0};
  Vector3 up{0, 0, 1};

  [[nodiscard]] Vector3 into(Vector3 world) const {
    const Vector3 offset{world - origin};
    return {dot(forward, offset), dot(left, offset), dot(up, offset)};
  }
  [[nodiscard]] Vector3 back(Vector3 local) const { return origin + local.x * forward + local.y * left + local.z * up; }
};

/// Contact points of the wheels: ahead of the camera, behind it, and to either side.
struct Wheels {
  double front_m{0.9};
  double rear_m{1.8};
  double half_track_m{0.75};
};

/// The vehicle frame of a vehicle that stands on the ground: the plane of its wheels' contacts.
[[nodiscard]] Frame3 standing_at(const HeightField& ground, const Pose2& pose, const Wheels& wheels);

/// Straight pieces between points by ascending `at`, level before the first and after the last one. Two points of equal
/// `at` are a step. No points: 0.
class Polyline {
 public:
  struct Point {
    double at{0};
    double value{0};
  };

  Polyline() = default;
  Polyline(std::vector<Point> points) : points_{std::move(points)} {}

  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  [[nodiscard]] Point last() const { return points_.back(); }
  /// Value at `at` of the piece that holds `beside`.
  [[nodiscard]] double value(double at, double beside) const;

  /// Continues to a point.
  Polyline& to(double at, double value);
  /// Continues over `length_m` with a slope (tangent) that changes evenly, in eight pieces, from one to the other.
  Polyline& bend(double from_slope, double to_slope, double length_m);
  /// Continues over `length_m` by half a period of a cosine.
  Polyline& wave(double rise, double length_m);

 private:
  std::vector<Point> points_;
};

/// 1 everywhere.
[[nodiscard]] Polyline everywhere();
/// 1 between two places, 0 elsewhere.
[[nodiscard]] Polyline between(double low, double high);

/// Shapes whose heights add up to a height field. The height of a shape is along(x) · across(y).
class Relief {
 public:
  void add(Polyline along, Polyline across = everywhere());
  [[nodiscard]] HeightField field() const;

 private:
  struct Product {
    Polyline along;
    Polyline across;
  };
  std::vector<Product> shapes_;
};

}  // namespace stereogrid::scenes

// SPDX-License-Identifier: Apache-2.0
#include "world/height_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "world/numbers.hpp"

namespace stereogrid::scenes {
namespace {

constexpr double joined_m{1e-6};  ///< patches whose heights differ by less have no wall between them

double height_on(const HeightField::Patch& patch, double x, double y) {
  return patch.z + patch.slope_x * x + patch.slope_y * y + patch.twist * x * y;
}

/// Smallest root of a + b·t + c·t² in (0, t_max], a > 0.
bool first_root(double a, double b, double c, double t_max, double& root) {
  if (c == 0) {
    if (b >= 0) return false;
    root = -a / b;
    return root <= t_max;
  }
  const double discriminant{b * b - 4 * a * c};
  if (discriminant < 0) return false;
  const double q{-0.5 * (b + (b < 0 ? -1 : 1) * std::sqrt(discriminant))};
  root = std::numeric_limits<double>::infinity();
  for (const double t : {q / c, q == 0 ? -1.0 : a / q}) {
    if (t > 0 && t < root) root = t;
  }
  return root <= t_max;
}

std::size_t piece_of(const std::vector<double>& lines, double at) {
  const auto next = std::upper_bound(lines.begin(), lines.end(), at) - lines.begin();
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(next - 1, 0, std::ssize(lines) - 2));
}

constexpr double far_m{1e4};
constexpr double same_line_m{1e-9};

/// Values of a polyline at both ends of every piece between lines.
struct Ends {
  double low{0};
  double high{0};
};

std::vector<Ends> ends_of(const Polyline& polyline, const std::vector<double>& lines) {
  std::vector<Ends> ends;
  for (std::size_t i{0}; i + 1 < lines.size(); ++i) {
    const double middle{(lines[i] + lines[i + 1]) / 2};
    ends.push_back({polyline.value(lines[i], middle), polyline.value(lines[i + 1], middle)});
  }
  return ends;
}

std::vector<double> merged(std::vector<double> lines) {
  lines.insert(lines.end(), {-far_m, far_m});
  std::sort(lines.begin(), lines.end());
  const auto same = [](double a, double b) { return b - a < same_line_m; };
  lines.erase(std::unique(lines.begin(), lines.end(), same), lines.end());
  return lines;
}

/// Adds the product of two linear functions to a patch.
void add_product(Ends along, double length_x, Ends across, double length_y, HeightField::Patch& patch) {
  const double slope_x{(along.high - along.low) / length_x};
  const double slope_y{(across.high - across.low) / length_y};
  patch.z += along.low * across.low;
  patch.slope_x += slope_x * across.low;
  patch.slope_y += along.low * slope_y;
  patch.twist += slope_x * slope_y;
}

}  // namespace

/// A ray on its way from patch to patch.
class HeightField::Walk {
 public:
  Walk(const HeightField& field, Vector3 origin, Vector3 direction, double t)
      : field_{field}, origin_{origin}, direction_{direction}, t_{t} {
    at_ = field.place_of(origin.x + t * direction.x, origin.y + t * direction.y);
  }

  /// The crossing with the present patch, or with the wall before it.
  [[nodiscard]] bool meets(bool is_first, Crossing& crossing) const {
    const Patch& patch{field_.patch(at_)};
    const Vector3 p{origin_ + t_ * direction_};
    const double x{p.x - field_.lines_x_[at_.i]};
    const double y{p.y - field_.lines_y_[at_.j]};
    const double gap{p.z - height_on(patch, x, y)};
    if (gap < -joined_m) {
      crossing = {t_,
                  entered_along_x_ ? Vector3{direction_.x > 0 ? -1.0 : 1.0, 0, 0}
                                   : Vector3{0, direction_.y > 0 ? -1.0 : 1.0, 0},
                  true};
      return !is_first;
    }
    double root{0};
    if (gap > 0) {
      const double slope{direction_.z - patch.slope_x * direction_.x - patch.slope_y * direction_.y -
                         patch.twist * (x * direction_.y + y * direction_.x)};
      if (!first_root(gap, slope, -patch.twist * direction_.x * direction_.y, exit() - t_, root)) return false;
    }
    const Vector3 normal{-patch.slope_x - patch.twist * (y + root * direction_.y),
                         -patch.slope_y - patch.twist * (x + root * direction_.x), 1};
    crossing = {t_ + root, (1 / std::sqrt(dot(normal, normal))) * normal, false};
    return true;
  }

  /// To the next patch; false: there is none, or the ray has left the ground for good.
  [[nodiscard]] bool advance() {
    t_ = exit();
    if (!(t_ < std::numeric_limits<double>::infinity())) return false;
    if (direction_.z > 0 && origin_.z + t_ * direction_.z > field_.highest_m_) return false;
    entered_along_x_ = exit_x() <= exit_y();
    return entered_along_x_ ? step(at_.i, direction_.x, field_.lines_x_.size())
                            : step(at_.j, direction_.y, field_.lines_y_.size());
  }

 private:
  static bool step(std::size_t& place, double direction, std::size_t lines) {
    if (direction < 0) return place-- > 0;
    return ++place + 1 < lines;
  }
  static double exit_of(const std::vector<double>& lines, std::size_t place, double origin, double direction) {
    if (direction == 0) return std::numeric_limits<double>::infinity();
    return (lines[direction > 0 ? place + 1 : place] - origin) / direction;
  }
  [[nodiscard]] double exit_x() const { return exit_of(field_.lines_x_, at_.i, origin_.x, direction_.x); }
  [[nodiscard]] double exit_y() const { return exit_of(field_.lines_y_, at_.j, origin_.y, direction_.y); }
  [[nodiscard]] double exit() const { return std::max(t_, std::min(exit_x(), exit_y())); }

  const HeightField& field_;
  Vector3 origin_;
  Vector3 direction_;
  double t_;
  Place at_;
  bool entered_along_x_{true};
};

HeightField::HeightField(std::vector<double> lines_x, std::vector<double> lines_y, std::vector<Patch> patches)
    : lines_x_{std::move(lines_x)},
      lines_y_{std::move(lines_y)},
      patches_{std::move(patches)},
      lowest_m_{std::numeric_limits<double>::infinity()},
      highest_m_{-std::numeric_limits<double>::infinity()} {
  for (std::size_t j{0}; j + 1 < lines_y_.size(); ++j) {
    for (std::size_t i{0}; i + 1 < lines_x_.size(); ++i) {
      const double width{lines_x_[i + 1] - lines_x_[i]};
      const double depth{lines_y_[j + 1] - lines_y_[j]};
      for (const double x : {0.0, width}) {
        for (const double y : {0.0, depth}) {
          lowest_m_ = std::min(lowest_m_, height_on(patch({i, j}), x, y));
          highest_m_ = std::max(highest_m_, height_on(patch({i, j}), x, y));
        }
      }
    }
  }
}

HeightField::Place HeightField::place_of(double x, double y) const {
  return {piece_of(lines_x_, x), piece_of(lines_y_, y)};
}

double HeightField::height_at(double x, double y) const {
  if (is_flat()) return 0;
  const Place at{place_of(x, y)};
  return height_on(patch(at), x - lines_x_[at.i], y - lines_y_[at.j]);
}

bool HeightField::crosses(Vector3 origin, Vector3 direction, Crossing& crossing) const {
  double start{0};
  if (origin.z > highest_m_) {
    if (direction.z >= 0) return false;
    start = (highest_m_ - origin.z) / direction.z;
  }
  Walk walk{*this, origin, direction, start};
  bool is_first{true};
  do {
    if (walk.meets(is_first, crossing)) return true;
    is_first = false;
  } while (walk.advance());
  return false;
}

namespace {

Vector3 unit(Vector3 v) {
  return (1 / std::sqrt(dot(v, v))) * v;
}

}  // namespace

Frame3 standing_at(const HeightField& ground, const Pose2& pose, const Wheels& wheels) {
  const Direction heading{direction_of(pose.yaw_rad)};
  Frame3 frame{
      {pose.x_m, pose.y_m, 0}, {heading.cosine, heading.sine, 0}, {-heading.sine, heading.cosine, 0}, {0, 0, 1}};
  if (ground.is_flat()) return frame;
  const auto contact = [&](double ahead, double left) {
    return ground.height_at(pose.x_m + ahead * heading.cosine - left * heading.sine,
                            pose.y_m + ahead * heading.sine + left * heading.cosine);
  };
  const double track{wheels.half_track_m};
  const double front_left{contact(wheels.front_m, track)};
  const double front_right{contact(wheels.front_m, -track)};
  const double rear_left{contact(-wheels.rear_m, track)};
  const double rear_right{contact(-wheels.rear_m, -track)};
  const double base{wheels.front_m + wheels.rear_m};
  const double climb{(front_left + front_right - rear_left - rear_right) / (2 * base)};
  const double bank{(front_left + rear_left - front_right - rear_right) / (4 * track)};
  const double middle{(front_left + front_right + rear_left + rear_right) / 4};
  frame.origin.z = middle - climb * (wheels.front_m - wheels.rear_m) / 2;
  if (climb == 0 && bank == 0) return frame;
  const Vector3 ahead{frame.forward + climb * frame.up};
  const Vector3 left{frame.left + bank * frame.up};
  const Vector3 normal{frame.up - climb * frame.forward - bank * frame.left};
  frame.forward = unit(ahead);
  frame.up = unit(normal);
  frame.left = unit(left - dot(left, frame.forward) * frame.forward);
  return frame;
}

double Polyline::value(double at, double beside) const {
  if (points_.empty()) return 0;
  const auto next = std::upper_bound(points_.begin(), points_.end(), beside,
                                     [](double place, const Point& point) { return place < point.at; });
  if (next == points_.begin()) return points_.front().value;
  if (next == points_.end()) return points_.back().value;
  const Point& from{*(next - 1)};
  return from.value + (at - from.at) * (next->value - from.value) / (next->at - from.at);
}

Polyline& Polyline::to(double at, double value) {
  points_.push_back({at, value});
  return *this;
}

Polyline& Polyline::bend(double from_slope, double to_slope, double length_m) {
  constexpr int pieces{8};
  const Point start{last()};
  for (int i{1}; i <= pieces; ++i) {
    const double x{length_m * i / pieces};
    to(start.at + x, start.value + from_slope * x + (to_slope - from_slope) * x * x / (2 * length_m));
  }
  return *this;
}

Polyline& Polyline::wave(double rise, double length_m) {
  constexpr int pieces{12};
  const Point start{last()};
  for (int i{1}; i <= pieces; ++i) {
    const double share{static_cast<double>(i) / pieces};
    to(start.at + share * length_m, start.value + rise * (1 - direction_of(pi * share).cosine) / 2);
  }
  return *this;
}

Polyline everywhere() {
  return Polyline{{{0, 1}}};
}

Polyline between(double low, double high) {
  return Polyline{{{low, 0}, {low, 1}, {high, 1}, {high, 0}}};
}

void Relief::add(Polyline along, Polyline across) {
  shapes_.push_back({std::move(along), std::move(across)});
}

HeightField Relief::field() const {
  std::vector<double> lines_x;
  std::vector<double> lines_y;
  for (const Product& shape : shapes_) {
    for (const Polyline::Point& point : shape.along.points()) lines_x.push_back(point.at);
    for (const Polyline::Point& point : shape.across.points()) lines_y.push_back(point.at);
  }
  lines_x = merged(std::move(lines_x));
  lines_y = merged(std::move(lines_y));
  std::vector<HeightField::Patch> patches((lines_x.size() - 1) * (lines_y.size() - 1));
  for (const Product& shape : shapes_) {
    const std::vector<Ends> along{ends_of(shape.along, lines_x)};
    const std::vector<Ends> across{ends_of(shape.across, lines_y)};
    for (std::size_t j{0}; j < across.size(); ++j) {
      for (std::size_t i{0}; i < along.size(); ++i) {
        add_product(along[i], lines_x[i + 1] - lines_x[i], across[j], lines_y[j + 1] - lines_y[j],
                    patches[j * along.size() + i]);
      }
    }
  }
  return {std::move(lines_x), std::move(lines_y), std::move(patches)};
}

}  // namespace stereogrid::scenes

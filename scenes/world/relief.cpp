// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "world/relief.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "world/numbers.hpp"

namespace stereogrid::scenes {
namespace {

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

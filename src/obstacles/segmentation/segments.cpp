// SPDX-License-Identifier: Apache-2.0
#include "obstacles/segmentation/segments.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "clamped_to_int.hpp"
#include "motion/symmetric2.hpp"

namespace stereogrid {

namespace {

constexpr double gap_m{0.2};  // maximum gap between columns of one object
constexpr int gap_px_max{40};
constexpr double depth_m{0.35};   // maximum difference of neighbouring columns of one object …
constexpr double depth_px{0.75};  // … or in px, for noise
constexpr int tolerance_max{8};
constexpr int pixels_min{20};  // minimum pixels of a segment
constexpr double surface_min_m2{0.03};
constexpr double object_length_max_m{6};  // longer segments are cut where they are thin
constexpr double slice_m{0.5};
constexpr int slices_around{6};
constexpr double thin_share{0.2};

/// Direction in which places with weights spread most, and their mean.
struct Axis {
  Point2 mean;
  Point2 direction;

  [[nodiscard]] double along(Point2 place) const {
    return direction.x * (place.x - mean.x) + direction.y * (place.y - mean.y);
  }
};

// Marks of a row of the image from column u on, which is the lowest bit.
std::uint64_t marks_from(const std::uint64_t* marks, int u) {
  constexpr int bits{std::numeric_limits<std::uint64_t>::digits};
  const std::uint64_t* const word{marks + u / bits};
  const int shift{u % bits};
  return word[0] >> shift | (shift == 0 ? 0 : word[1] << (bits - shift));
}

Axis principal_axis(const Segmenter& segmenter, std::span<const int> nodes) {
  double sum{0};
  Axis axis;
  for (const int index : nodes) {
    const SegmentNode& node{segmenter.node(index)};
    sum += node.weight;
    axis.mean.x += node.weight * node.place.x;
    axis.mean.y += node.weight * node.place.y;
  }
  axis.mean = {axis.mean.x / sum, axis.mean.y / sum};
  Symmetric2 spread;
  for (const int index : nodes) {
    const SegmentNode& node{segmenter.node(index)};
    const Point2 away{node.place.x - axis.mean.x, node.place.y - axis.mean.y};
    spread.xx += node.weight * away.x * away.x;
    spread.xy += node.weight * away.x * away.y;
    spread.yy += node.weight * away.y * away.y;
  }
  axis.direction = principal_direction(spread);
  return axis;
}

/// Thinnest slice, and its surface relative to the slices on both sides.
struct Waist {
  int slice{-1};
  double share{std::numeric_limits<double>::max()};
};

Waist waist_of(const std::vector<double>& profile) {
  Waist waist;
  const int slices{static_cast<int>(profile.size())};
  const auto most = [&](int begin, int end) {
    return *std::max_element(profile.begin() + std::max(begin, 0), profile.begin() + std::min(end, slices));
  };
  for (int i{2}; i < slices - 2; ++i) {
    const double beside{std::min(most(i - slices_around, i), most(i + 1, i + 1 + slices_around))};
    const double share{profile[static_cast<std::size_t>(i)] / std::max(beside, 1e-9)};
    if (share < waist.share) waist = {i, share};
  }
  return waist;
}

}  // namespace

Segmenter::Segmenter(const Rig& level_rig, int disparities)
    : rig_{level_rig},
      labels_{level_rig.width_px, column_bins_per_px * disparities},
      marks_{labels_.width() / mark_bits + 2, labels_.height()} {
  const double focal_baseline{rig_.focal_px * rig_.baseline_m};
  for (int k{0}; k < labels_.height(); ++k) {
    const double d{(k + 0.5) / column_bins_per_px};
    const double depth{std::max(depth_px, depth_m * d * d / focal_baseline)};
    bins_.push_back({d, std::clamp(clamped_to_int(gap_m * (d / rig_.baseline_m)), 1, gap_px_max),
                     std::clamp(clamped_to_int(column_bins_per_px * depth), 1, tolerance_max)});
  }
  const std::size_t reserved{nodes_reserved(rig_.width_px, disparities)};
  nodes_.reserve(reserved);
  order_.reserve(reserved);
  rest_.reserve(reserved);
  segments_.reserve(1024);
  pieces_.reserve(segments_.capacity());
  profile_.reserve(std::max(static_cast<std::size_t>(4 * segments_far_m / slice_m), reserved));
}

void Segmenter::find(std::span<const ColumnNode> nodes, const Ground& ground, const Relief<Host>& relief) {
  place_nodes(nodes, ground, relief);
  separate();
}

// By ascending bin and column.
void Segmenter::place_nodes(std::span<const ColumnNode> nodes, const Ground& ground, const Relief<Host>& relief) {
  for (const SegmentNode& before : nodes_) labels_(before.u, before.bin) = 0;
  nodes_.clear();
  marks_.fill(0);
  int number{0};
  for (const ColumnNode& one : nodes) {
    labels_(one.u, one.bin) = ++number;
    marks_(one.u / mark_bits, one.bin) |= std::uint64_t{1} << one.u % mark_bits;
  }
  const RoadPlane plane{road_plane(rig_, ground)};
  for (int k{0}; k < marks_.height(); ++k) {
    const double disparity{bins_[static_cast<std::size_t>(k)].disparity};
    const double side_m{rig_.baseline_m / disparity};  // side of a pixel on an upright surface
    for (int word{0}; word < marks_.width(); ++word) {
      for (std::uint64_t left{marks_(word, k)}; left != 0; left &= left - 1) {
        const int u{word * mark_bits + std::countr_zero(left)};
        int& label{labels_(u, k)};
        const ColumnNode& one{nodes[static_cast<std::size_t>(label - 1)]};
        const int index{static_cast<int>(nodes_.size())};
        const int raised{relief.is_plane() ? 0 : relief.rows_at(u, static_cast<float>(disparity))};
        const double top_m{ground.height_m * (1 - plane.disparity(u, one.top + raised) / disparity)};
        const Point2 place{rig_.focal_px * side_m, (rig_.cx_px - u) * side_m};
        nodes_.push_back({u, k, one.pixels, top_m, index, none, place, one.pixels * side_m * side_m});
        label = index + 1;
      }
    }
  }
}

void Segmenter::separate() {
  for (int i{0}; i < static_cast<int>(nodes_.size()); ++i) join_right(i);
  gather();
  for (std::size_t i{0}; i < segments_.size();) {
    if (!cut(i)) ++i;
  }
  join_pieces();
  for (SegmentNode& one : nodes_) one.segment = none;
  for (std::size_t i{0}; i < segments_.size(); ++i) {
    for (const int index : of(i)) nodes_[static_cast<std::size_t>(index)].segment = static_cast<int>(i);
  }
}

int Segmenter::root_of(int index) {
  const auto parent = [this](int i) -> int& { return nodes_[static_cast<std::size_t>(i)].parent; };
  while (parent(index) != index) index = parent(index) = parent(parent(index));
  return index;
}

// Joins a node with the nearest one to the right, in each bin that may belong to the same surface.
void Segmenter::join_right(int index) {
  const SegmentNode& from{node(index)};
  const Bin& bin{bins_[static_cast<std::size_t>(from.bin)]};
  const int last_bin{std::min(from.bin + bin.tolerance, labels_.height() - 1)};
  const int last_u{std::min(from.u + bin.gap_px, labels_.width() - 1)};
  static_assert(gap_px_max < mark_bits);
  for (int k{std::max(from.bin - bin.tolerance, 0)}; k <= last_bin; ++k) {
    const int first_u{from.u + (k > from.bin ? 0 : 1)};
    if (first_u > last_u) continue;
    const int u{first_u + std::countr_zero(marks_from(marks_.row(k), first_u))};
    if (u > last_u) continue;
    const int a{root_of(index)};
    const int b{root_of(labels_(u, k) - 1)};
    nodes_[static_cast<std::size_t>(std::max(a, b))].parent = std::min(a, b);
  }
}

// Sorts nodes by segment. The root of a segment has the lowest index.
void Segmenter::gather() {
  segments_.clear();
  for (int i{0}; i < static_cast<int>(nodes_.size()); ++i) {
    const int root{root_of(i)};
    SegmentNode& one{nodes_[static_cast<std::size_t>(i)]};
    if (root == i) segments_.push_back({0, 0});
    one.segment = root == i ? static_cast<int>(segments_.size()) - 1 : node(root).segment;
    ++segments_[static_cast<std::size_t>(one.segment)].end;
  }
  std::size_t begin{0};
  for (Range& range : segments_) {
    begin += range.end;
    range = {begin - range.end, begin - range.end};
  }
  order_.resize(nodes_.size());
  for (int i{0}; i < static_cast<int>(nodes_.size()); ++i) {
    order_[segments_[static_cast<std::size_t>(node(i).segment)].end++] = i;
  }
  std::erase_if(segments_, [this](const Range& range) { return is_small(range); });
}

bool Segmenter::is_small(const Range& range) const {
  int pixels{0};
  double surface_m2{0};
  for (std::size_t i{range.begin}; i < range.end; ++i) {
    pixels += node(order_[i]).pixels;
    surface_m2 += node(order_[i]).weight;
  }
  return pixels < pixels_min || surface_m2 < surface_min_m2;
}

// Cuts a segment longer than an object at its thinnest slice. True: it was cut.
bool Segmenter::cut(std::size_t segment) {
  const Axis axis{principal_axis(*this, of(segment))};
  double least{std::numeric_limits<double>::max()};
  double most{std::numeric_limits<double>::lowest()};
  for (const int i : of(segment)) {
    least = std::min(least, axis.along(node(i).place));
    most = std::max(most, axis.along(node(i).place));
  }
  if (most - least < object_length_max_m) return false;
  const auto slice_of = [&](const SegmentNode& one) { return (axis.along(one.place) - least) / slice_m; };
  profile_.assign(static_cast<std::size_t>(std::ceil((most - least) / slice_m)) + 1, 0);
  for (const int i : of(segment)) profile_[static_cast<std::size_t>(slice_of(node(i)))] += node(i).weight;
  const Waist waist{waist_of(profile_)};
  if (waist.share > thin_share) return false;
  return split(segment, [&](const SegmentNode& one) { return slice_of(one) < waist.slice + 0.5; });
}

// True if another segment has nodes in the columns begin_u … end_u − 1, from a bin on.
bool Segmenter::has_nearer(int begin_u, int end_u, int bin, std::size_t than) const {
  const int first_u{std::max(begin_u, 0)};
  const int columns{std::min(end_u, labels_.width()) - first_u};
  if (columns <= 0) return false;
  const std::uint64_t mask{(std::uint64_t{1} << columns) - 1};
  for (int k{bin}; k < labels_.height(); ++k) {
    for (std::uint64_t left{marks_from(marks_.row(k), first_u) & mask}; left != 0; left &= left - 1) {
      const int u{first_u + std::countr_zero(left)};
      const int other{node(labels_(u, k) - 1).segment};
      if (other != none && other != static_cast<int>(than)) return true;
    }
  }
  return false;
}

Segmenter::Cuts Segmenter::cuts_of(std::size_t segment) const {
  constexpr int reach{2 * edge_reach_px};
  const auto before = [this](int a, int b) {
    return std::pair{node(a).u, -node(a).bin} < std::pair{node(b).u, -node(b).bin};
  };
  const auto [left, right] = std::minmax_element(of(segment).begin(), of(segment).end(), before);
  const SegmentNode& first{node(*left)};
  const SegmentNode& last{node(*right)};
  const auto beyond = [this](int bin) { return bin + 2 * bins_[static_cast<std::size_t>(bin)].tolerance; };
  // the right camera does not see the first columns of the left image: as many as the disparity
  return {first.u - first.bin / column_bins_per_px < reach ||
              has_nearer(first.u - reach, first.u, beyond(first.bin), segment),
          last.u >= labels_.width() - reach || has_nearer(last.u + 1, last.u + 1 + reach, beyond(last.bin), segment)};
}

Segmenter::Spot Segmenter::spot_of(Point2 place) const {
  return {clamped_to_int(std::round(rig_.cx_px - rig_.focal_px * place.y / place.x)),
          clamped_to_int(rig_.focal_px * rig_.baseline_m / place.x * column_bins_per_px)};
}

int Segmenter::segment_at(Point2 place) const {
  constexpr int reach{3};
  if (!(place.x > 0)) return none;
  const auto [u, k] = spot_of(place);
  int segment{none};
  int nearest{std::numeric_limits<int>::max()};
  for (int j{std::max(k - reach, 0)}; j <= std::min(k + reach, labels_.height() - 1); ++j) {
    for (int i{std::max(u - reach, 0)}; i <= std::min(u + reach, labels_.width() - 1); ++i) {
      const int distance{(i - u) * (i - u) + (j - k) * (j - k)};
      if (labels_(i, j) == 0 || distance >= nearest || node(labels_(i, j) - 1).segment == none) continue;
      nearest = distance;
      segment = node(labels_(i, j) - 1).segment;
    }
  }
  return segment;
}

}  // namespace stereogrid

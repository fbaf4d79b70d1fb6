// SPDX-License-Identifier: Apache-2.0
//
// Joins segments that together are no larger than a car. A car's side at a grazing angle, or with a window without
// texture, has several segments at consecutive depths. Cutting a long segment may divide an object. docs/method.md
// §11.1.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "obstacles/segmentation/clusters.hpp"
#include "obstacles/segmentation/segments.hpp"

namespace stereogrid {
namespace {

/// Maximum distance of a cluster's centre from the bounds of the same object in another camera's view.
constexpr double same_object_m{0.3};

bool are_one(const Cluster& one, const Cluster& other) {
  if (one.camera == other.camera || one.kind == ObstacleKind::drop || other.kind == ObstacleKind::drop) return false;
  const Cluster& larger{one.pixels >= other.pixels ? one : other};
  const Point2 centre{one.pixels >= other.pixels ? other.centre : one.centre};
  return larger.bounds.gap_to({centre, centre}, {}) <= same_object_m;
}

constexpr double long_m{5.5};
constexpr double wide_m{2.6};
constexpr double high_m{2.8};
constexpr double tops_m{0.7};     // maximum difference of two pieces' heights
constexpr double depth_gap_m{1};  // maximum gap between two pieces in depth …
constexpr int depth_bins{2};      // … or in bins, for noise
constexpr double top_share{0.9};

double spread(double a, double b, double other_a, double other_b) {
  return std::max(b, other_b) - std::min(a, other_a);
}

}  // namespace

bool Segmenter::Piece::is_near(const Piece& other) const {
  const int bins{std::max(far_bin, other.far_bin) - std::min(near_bin, other.near_bin)};
  return bins <= depth_bins || std::max(least.x, other.least.x) - std::min(most.x, other.most.x) <= depth_gap_m;
}

void Segmenter::Piece::take_in(const Piece& other) {
  root = std::min(root, other.root);
  left_u = std::min(left_u, other.left_u);
  right_u = std::max(right_u, other.right_u);
  near_bin = std::max(near_bin, other.near_bin);
  far_bin = std::min(far_bin, other.far_bin);
  least = {std::min(least.x, other.least.x), std::min(least.y, other.least.y)};
  most = {std::max(most.x, other.most.x), std::max(most.y, other.most.y)};
  top_m = std::max(top_m, other.top_m);
}

Segmenter::Piece Segmenter::piece_of(std::size_t segment) {
  const std::span<const int> nodes{of(segment)};
  const auto of_node = [&](int index) {
    const SegmentNode& one{node(index)};
    return Piece{segment, nodes.front(), one.u, one.u, one.bin, one.bin, one.place, one.place, 0};
  };
  Piece piece{of_node(nodes.front())};
  profile_.clear();
  for (const int index : nodes) {
    piece.take_in(of_node(index));
    profile_.push_back(node(index).top_m);
  }
  const auto at = profile_.begin() + static_cast<std::ptrdiff_t>(top_share * static_cast<double>(profile_.size() - 1));
  std::nth_element(profile_.begin(), at, profile_.end());
  piece.top_m = *at;
  return piece;
}

std::size_t Segmenter::first_of(std::size_t piece) const {
  while (pieces_[piece].joined != piece) piece = pieces_[piece].joined;
  return piece;
}

bool Segmenter::are_one(const Piece& one, const Piece& other) const {
  if (std::max(one.top_m, other.top_m) > high_m || std::abs(one.top_m - other.top_m) > tops_m) return false;
  const double x{spread(one.least.x, one.most.x, other.least.x, other.most.x)};
  const double y{spread(one.least.y, one.most.y, other.least.y, other.most.y)};
  if (std::max(x, y) > long_m || std::min(x, y) > wide_m) return false;
  const Bin& farther{bins_[static_cast<std::size_t>(std::min(one.near_bin, other.near_bin))]};
  if (std::max(one.left_u, other.left_u) - std::min(one.right_u, other.right_u) > farther.gap_px) return false;
  return one.is_near(other);
}

void Segmenter::join_pieces() {
  pieces_.clear();
  for (std::size_t i{0}; i < segments_.size(); ++i) {
    pieces_.push_back(piece_of(i));
    for (const int index : of(i)) nodes_[static_cast<std::size_t>(index)].parent = pieces_[i].root;
  }
  for (std::size_t i{0}; i < pieces_.size(); ++i) {
    for (std::size_t j{i + 1}; j < pieces_.size(); ++j) {
      const auto [first, second] = std::minmax({first_of(i), first_of(j)});
      Piece& one{pieces_[first]};
      Piece& other{pieces_[second]};
      if (first == second || !are_one(one, other)) continue;
      nodes_[static_cast<std::size_t>(std::max(one.root, other.root))].parent = std::min(one.root, other.root);
      other.joined = first;
      one.take_in(other);
    }
  }
  gather();
}

void fuse_clusters(std::vector<Cluster>& of_camera, std::uint8_t camera, std::vector<Cluster>& all) {
  for (Cluster& cluster : of_camera) {
    cluster.camera = camera;
    const auto same = std::ranges::find_if(all, [&](const Cluster& other) { return are_one(cluster, other); });
    if (same == all.end())
      all.push_back(cluster);
    else if (same->pixels < cluster.pixels)
      *same = cluster;
  }
}

}  // namespace stereogrid

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ground/model.hpp"
#include "ground/relief.hpp"
#include "held_bytes.hpp"
#include "obstacles/segmentation/upright_row.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Obstacle pixels of one image column whose disparities lie in one bin.
struct SegmentNode {
  int u;
  int bin;
  int pixels;     ///< between the heights of obstacles
  double top_m;   ///< of the highest of them, and of those above without a gap
  int parent;     ///< while nodes are joined: another one of the segment; itself where it stands for the segment
  int segment;    ///< Segmenter::none: of a segment too small to count
  Point2 place;   ///< vehicle frame
  double weight;  ///< surface that the pixels show, m²
};

/// Separates what stands on the ground into things, in the u-disparity plane: there the noise is the same everywhere,
/// and two things have a gap where the image has one. docs/method.md §11.1.
class Segmenter {
 public:
  static constexpr int bins_per_px{2};
  static constexpr int none{-1};
  /// Farther ones are not resolved.
  static constexpr double far_m{40};

  Segmenter(const Rig& level_rig, const UDisparityConfig& heights, int disparities);

  /// `obstacle`: (H, W) px, 0 = none. `for_ranges(count, work)` calls work(begin, end) on parts of [0, count), on
  /// threads of its own if it likes. What the other functions say is of the last call.
  template <class ForRanges>
  void find(View<const float> obstacle, const Ground& ground, const ForRanges& for_ranges,
            const Relief<Host>& relief = {}) {
    tallies_.fill({});
    const RoadPlane plane{road_plane(rig_, ground)};
    for_ranges(obstacle.width,
               [&](int begin, int end) { count(obstacle, plane, ground.height_m, relief, begin, end); });
    take_nodes(plane, ground.height_m, relief);
    separate();
  }

  [[nodiscard]] std::size_t size() const { return segments_.size(); }
  /// So many nodes have room from the start.
  [[nodiscard]] std::size_t nodes_reserved() const { return tallies_.size() / 8; }
  /// Indices of a segment's nodes, far ones first.
  [[nodiscard]] std::span<const int> of(std::size_t segment) const {
    return std::span{order_}.subspan(segments_[segment].begin, segments_[segment].end - segments_[segment].begin);
  }
  [[nodiscard]] const SegmentNode& node(int index) const { return nodes_[static_cast<std::size_t>(index)]; }
  /// Whether a segment may go on beyond its first, or its last column: the image ends, or something nearer is there.
  struct Cuts {
    bool left;
    bool right;
  };
  [[nodiscard]] Cuts cuts_of(std::size_t segment) const;
  /// Where a place of the vehicle frame, x > 0, is seen.
  struct Spot {
    int u;
    int bin;
  };
  [[nodiscard]] Spot spot_of(Point2 place) const;
  /// The segment that is seen at a place of the vehicle frame, or the nearest within a few pixels, or none.
  [[nodiscard]] int segment_at(Point2 place) const;
  /// Makes of the nodes for which `belongs(node)` does not hold a segment of their own, the last one. False: there are
  /// none, or no others.
  template <class Belongs>
  bool split(std::size_t segment, const Belongs& belongs) {
    const auto begin = order_.begin();
    const auto first = begin + static_cast<std::ptrdiff_t>(segments_[segment].begin);
    const auto last = begin + static_cast<std::ptrdiff_t>(segments_[segment].end);
    const auto middle = std::partition(first, last, [&](int i) { return belongs(node(i)); });
    std::sort(first, middle);
    std::sort(middle, last);
    if (middle == first || middle == last) return false;
    for (auto i = middle; i != last; ++i) nodes_[static_cast<std::size_t>(*i)].segment = static_cast<int>(size());
    segments_.push_back({static_cast<std::size_t>(middle - begin), segments_[segment].end});
    segments_[segment].end = static_cast<std::size_t>(middle - begin);
    return true;
  }

  [[nodiscard]] std::size_t held_bytes() const {
    return held_bytes_of(bins_, tallies_, labels_, nodes_, order_, segments_, pieces_, profile_);
  }

 private:
  /// What holds for a bin, whatever the frame.
  struct Bin {
    double disparity;  ///< of its middle, px
    int pixels_min;    ///< of a node, with its neighbours
    int gap_px;        ///< in the image, within a segment
    int gap_rows;      ///< below which it ends: what hangs above is another thing
    int tolerance;     ///< bins by which neighbours may differ
  };
  /// Of a bin in a column.
  struct Tally {
    std::uint16_t pixels{0};  ///< between the heights of obstacles
    std::uint16_t top{0};     ///< first row + 1 of the lowest run of rows of any height; 0: none
    std::uint16_t bottom{0};  ///< the last row so far
  };
  /// Of a thing. What else it says is of all pieces that have joined it.
  struct Piece {
    std::size_t joined;  ///< an earlier piece of the thing; itself where it is the first
    int root;            ///< node that stands for the segment
    int left_u;
    int right_u;
    int near_bin;
    int far_bin;
    Point2 least;  ///< vehicle frame
    Point2 most;
    double top_m;

    [[nodiscard]] bool is_near(const Piece& other) const;
    void take_in(const Piece& other);
  };
  struct Range {
    std::size_t begin;
    std::size_t end;
  };

  void count(View<const float> obstacle, const RoadPlane& plane, double camera_height_m, const Relief<Host>& relief,
             int begin, int end);
  void add(const UprightRow& row, int v, int u, float d);
  void take_nodes(const RoadPlane& plane, double camera_height_m, const Relief<Host>& relief);
  void separate();
  void join_right(int index);
  int root_of(int index);
  void gather();
  bool cut(std::size_t segment);
  void join_pieces();
  [[nodiscard]] bool is_small(const Range& range) const;
  [[nodiscard]] bool has_nearer(int begin_u, int end_u, int bin, std::size_t than) const;
  [[nodiscard]] Piece piece_of(std::size_t segment);
  [[nodiscard]] std::size_t first_of(std::size_t piece) const;
  [[nodiscard]] bool are_one(const Piece& one, const Piece& other) const;

  Rig rig_;
  double lowest_m_;
  double highest_m_;
  std::vector<Bin> bins_;
  Image<Tally> tallies_;  ///< (bins, W)
  Image<int> labels_;     ///< (bins, W): index of the node + 1; 0: none
  std::vector<SegmentNode> nodes_;
  std::vector<int> order_;  ///< nodes by segment
  std::vector<Range> segments_;
  std::vector<Piece> pieces_;    ///< the segments, as long as they are joined
  std::vector<double> profile_;  ///< of a segment: surface by slices, or tops of columns
};

}  // namespace stereogrid

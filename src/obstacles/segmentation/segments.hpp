// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/relief.hpp"
#include "geometry/road_plane.hpp"
#include "memory_bytes.hpp"
#include "obstacles/segmentation/columns.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// A node on the ground.
struct SegmentNode {
  int u;
  int bin;
  int pixels;     ///< see ColumnNode
  double top_m;   ///< height of the highest pixel without a gap below it
  int parent;     ///< while nodes are joined: another node of the segment; the node itself: root of the segment
  int segment;    ///< Segmenter::none: the segment is too small
  Point2 place;   ///< vehicle frame
  double weight;  ///< visible surface, m²
};

/// Segments obstacles into objects in the u-disparity plane, where noise is uniform and gaps are those of the image.
/// docs/method.md §11.1.
class Segmenter {
 public:
  static constexpr int none{-1};

  Segmenter(const Rig& level_rig, int disparities);

  /// `nodes`: each once, in any order; `relief`: the local ground by which they were found. All other functions return
  /// results of the last call.
  void find(std::span<const ColumnNode> nodes, const Ground& ground, const Relief<Host>& relief = {});

  [[nodiscard]] std::size_t size() const { return segments_.size(); }
  /// Indices of a segment's nodes, far ones first.
  [[nodiscard]] std::span<const int> of(std::size_t segment) const {
    return std::span{order_}.subspan(segments_[segment].begin, segments_[segment].end - segments_[segment].begin);
  }
  /// Number of nodes before a segment's, in segments or none: places of arrays that have one for each node.
  [[nodiscard]] std::size_t begin_of(std::size_t segment) const { return segments_[segment].begin; }
  [[nodiscard]] const SegmentNode& node(int index) const { return nodes_[static_cast<std::size_t>(index)]; }
  /// True: the segment may continue beyond its first (left) or last (right) column, hidden or outside the image.
  struct Cuts {
    bool left;
    bool right;
  };
  [[nodiscard]] Cuts cuts_of(std::size_t segment) const;
  struct Spot {
    int u;
    int bin;
  };
  /// Projection of a place of the vehicle frame, x > 0.
  [[nodiscard]] Spot spot_of(Point2 place) const;
  /// Segment visible at a place of the vehicle frame, or the nearest within a few pixels, or none.
  [[nodiscard]] int segment_at(Point2 place) const;
  /// Moves the nodes for which `belongs(node)` is false to a new last segment. False: unchanged, since all or none
  /// belong.
  template <class Belongs>
  bool split(std::size_t segment, const Belongs& belongs) {
    const auto begin = order_.begin();
    const auto first = begin + static_cast<std::ptrdiff_t>(segments_[segment].begin);
    const auto last = begin + static_cast<std::ptrdiff_t>(segments_[segment].end);
    rest_.clear();  // as std::stable_partition, which allocates
    auto middle = first;
    for (auto i = first; i != last; ++i) {
      if (belongs(node(*i)))
        *middle++ = *i;
      else
        rest_.push_back(*i);
    }
    std::ranges::copy(rest_, middle);
    if (middle == first || middle == last) return false;
    for (auto i = middle; i != last; ++i) nodes_[static_cast<std::size_t>(*i)].segment = static_cast<int>(size());
    segments_.push_back({static_cast<std::size_t>(middle - begin), segments_[segment].end});
    segments_[segment].end = static_cast<std::size_t>(middle - begin);
    return true;
  }

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(bins_, labels_, marks_, nodes_, order_, rest_, segments_, pieces_, profile_);
  }

 private:
  static constexpr int mark_bits{64};

  struct Bin {
    double disparity;  ///< middle of the bin, px
    int gap_px;        ///< maximum gap within a segment in the image
    int tolerance;     ///< maximum difference of neighbours, bins
  };
  /// Part of an object. All members but `joined` and `root` include the pieces that have joined it.
  struct Piece {
    std::size_t joined;  ///< an earlier piece of the object; its own index: the first piece
    int root;            ///< root node of the segment
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

  void place_nodes(std::span<const ColumnNode> nodes, const Ground& ground, const Relief<Host>& relief);
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
  std::vector<Bin> bins_;
  Image<int> labels_;           ///< (bins, W): index of the node + 1; 0: none
  Image<std::uint64_t> marks_;  ///< (bins, W / mark_bits): a bit for each node
  std::vector<SegmentNode> nodes_;
  std::vector<int> order_;  ///< nodes by segment
  std::vector<int> rest_;   ///< nodes that split() moves
  std::vector<Range> segments_;
  std::vector<Piece> pieces_;    ///< segments, while they are joined
  std::vector<double> profile_;  ///< surface by slices, or tops of columns, of a segment
};

}  // namespace stereogrid

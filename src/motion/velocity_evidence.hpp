// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "filter/filter.hpp"
#include "filter/joint/evidence.hpp"
#include "memory_bytes.hpp"
#include "motion/scene_flow.hpp"
#include "motion/symmetric2.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// Velocities of points, spread over the cells around them.
class EvidenceMap {
 public:
  /// A window of `cells` × `cells`, with room for `points`. `axis_mps`: velocities of the filter's lattice along an
  /// axis; faster ones are clamped.
  EvidenceMap(int cells, std::vector<double> axis_mps, std::size_t points = 0);

  /// Evidence for cells of the window, by ascending cell. `for_ranges`: see SceneFlow::follow. `view`: of the camera
  /// since the frame before; unknown: no view is repeated.
  template <class ForRanges>
  const std::vector<VelocityEvidence>& gather(const std::vector<FlowVector>& vectors, const GridGeometry& window,
                                              const ForRanges& for_ranges, const CameraView& view = {}) {
    view_ = view;
    take(vectors, window);
    for_ranges(window.ny, [this](int begin, int end) { spread(begin, end); });
    make_room();
    for_ranges(window.ny, [this](int begin, int end) { conclude(begin, end); });
    return evidence_;
  }

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(sums_, axis_mps_, touched_, rows_, averages_, points_, evidence_);
  }

 private:
  struct Sum {
    double weight{0};
    double points{0};  ///< independent ones, by weight
    int supported{0};
    InformationSum velocity;
  };
  /// Sum over a point and those that agree with it.
  struct Average {
    InformationSum own;
    int points{1};
    InformationSum velocity{own};

    void add(const InformationSum& other) {
      ++points;
      velocity.add(other);
    }
    /// Number of independent points for which they count: errors of four are like one.
    [[nodiscard]] double independent() const { return std::max(points / 4.0, 1.0); }
    [[nodiscard]] Symmetric2 information() const { return independent() / points * velocity.information; }
  };
  /// Cells from `first` to `last` along an axis.
  struct CellRange {
    int first;
    int last;
  };
  /// Measurement of a point, and its range.
  struct Point {
    Point2 place;
    Symmetric2 distance;
    InformationSum measured;
    double independent;
    int supported;  ///< 1: several others agree
    CellRange columns;
    CellRange rows;
  };
  /// Reached cells of a row of the window: their number from its first place in touched_ on, and the place of their
  /// evidence.
  struct Row {
    int touched{0};
    int evidence{0};
  };

  static CellRange cells_around(double at, double half, double min, double cell_size_m, int count);
  void average(const std::vector<FlowVector>& vectors);
  void take(const std::vector<FlowVector>& vectors, const GridGeometry& window);
  void spread(int begin_row, int end_row);
  void spread(const Point& point, int row);
  void make_room();
  void conclude(int begin_row, int end_row);
  [[nodiscard]] VelocityEvidence evidence_of(int cell, const Sum& sum) const;

  Image<Sum> sums_;
  std::vector<double> axis_mps_;
  std::vector<int> touched_;  // cells, by row, from its first cell's position on
  std::vector<Row> rows_;
  std::vector<VelocityEvidence> evidence_;

  // window of a frame
  GridGeometry window_;
  CameraView view_;
  std::vector<Average> averages_;
  std::vector<Point> points_;
};

}  // namespace stereogrid

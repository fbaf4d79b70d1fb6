// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "assignment.hpp"

#include <limits>

namespace stereogrid::evaluation {
namespace {

/// Rows are given columns one after another; potentials keep every reduced cost at 0 or above. Row and column 0 stand
/// for none.
class Assignment {
 public:
  Assignment(const std::vector<double>& costs, std::size_t rows, std::size_t columns)
      : costs_{costs},
        columns_{columns},
        row_potential_(rows + 1),
        column_potential_(columns + 1),
        row_of_(columns + 1),
        way_(columns + 1) {}

  void add(std::size_t row) {
    row_of_[0] = row;
    smallest_.assign(columns_ + 1, std::numeric_limits<double>::infinity());
    used_.assign(columns_ + 1, false);
    std::size_t column{0};
    do {
      used_[column] = true;
      column = step_from(column);
    } while (row_of_[column] != 0);
    while (column != 0) {
      const std::size_t before{way_[column]};
      row_of_[column] = row_of_[before];
      column = before;
    }
  }

  [[nodiscard]] std::size_t row_of(std::size_t column) const { return row_of_[column]; }

 private:
  /// The free column that is reached at the least cost.
  std::size_t step_from(std::size_t column) {
    const std::size_t row{row_of_[column]};
    double delta{std::numeric_limits<double>::infinity()};
    std::size_t next{0};
    for (std::size_t j{1}; j <= columns_; ++j) {
      if (used_[j]) continue;
      const double reduced{costs_[(row - 1) * columns_ + j - 1] - row_potential_[row] - column_potential_[j]};
      if (reduced < smallest_[j]) {
        smallest_[j] = reduced;
        way_[j] = column;
      }
      if (smallest_[j] < delta) {
        delta = smallest_[j];
        next = j;
      }
    }
    shift(delta);
    return next;
  }

  void shift(double delta) {
    for (std::size_t j{0}; j <= columns_; ++j) {
      if (used_[j]) {
        row_potential_[row_of_[j]] += delta;
        column_potential_[j] -= delta;
      } else {
        smallest_[j] -= delta;
      }
    }
  }

  const std::vector<double>& costs_;
  std::size_t columns_;
  std::vector<double> row_potential_;
  std::vector<double> column_potential_;
  std::vector<std::size_t> row_of_;
  std::vector<std::size_t> way_;
  std::vector<double> smallest_;
  std::vector<bool> used_;
};

}  // namespace

std::vector<std::size_t> cheapest_columns(const std::vector<double>& costs, std::size_t rows, std::size_t columns) {
  Assignment assignment{costs, rows, columns};
  for (std::size_t row{1}; row <= rows; ++row) assignment.add(row);
  std::vector<std::size_t> column_of(rows);
  for (std::size_t j{1}; j <= columns; ++j) {
    if (assignment.row_of(j) != 0) column_of[assignment.row_of(j) - 1] = j - 1;
  }
  return column_of;
}

}  // namespace stereogrid::evaluation

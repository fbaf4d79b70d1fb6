// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "host_device.hpp"

namespace stereogrid {

struct Vector3 {
  double element[3];

  STEREOGRID_HD double& operator[](std::size_t i) { return element[i]; }
  STEREOGRID_HD const double& operator[](std::size_t i) const { return element[i]; }
};

struct Matrix3 {
  Vector3 row[3];

  STEREOGRID_HD Vector3& operator[](std::size_t i) { return row[i]; }
  STEREOGRID_HD const Vector3& operator[](std::size_t i) const { return row[i]; }
};

STEREOGRID_HD inline Matrix3 operator*(const Matrix3& a, const Matrix3& b) {
  Matrix3 product{};
  for (int i{0}; i < 3; ++i) {
    for (int j{0}; j < 3; ++j) product[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
  }
  return product;
}

STEREOGRID_HD inline Vector3 operator*(const Matrix3& a, const Vector3& x) {
  Vector3 product{};
  for (int i{0}; i < 3; ++i) product[i] = a[i][0] * x[0] + a[i][1] * x[1] + a[i][2] * x[2];
  return product;
}

STEREOGRID_HD inline Matrix3 operator+(Matrix3 a, const Matrix3& b) {
  for (int i{0}; i < 3; ++i) {
    for (int j{0}; j < 3; ++j) a[i][j] += b[i][j];
  }
  return a;
}

STEREOGRID_HD inline Vector3 operator+(const Vector3& a, const Vector3& b) {
  return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
}

STEREOGRID_HD inline Vector3 operator-(const Vector3& a, const Vector3& b) {
  return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}};
}

STEREOGRID_HD inline Matrix3 scaled(double factor, Matrix3 a) {
  for (int i{0}; i < 3; ++i) {
    for (int j{0}; j < 3; ++j) a[i][j] *= factor;
  }
  return a;
}

STEREOGRID_HD inline Matrix3 transposed(const Matrix3& a) {
  Matrix3 result{};
  for (int i{0}; i < 3; ++i) {
    for (int j{0}; j < 3; ++j) result[i][j] = a[j][i];
  }
  return result;
}

STEREOGRID_HD inline Matrix3 diagonal(const Vector3& elements) {
  Matrix3 result{};
  for (int i{0}; i < 3; ++i) result[i][i] = elements[i];
  return result;
}

/// Covariance of A·x, where C is that of x.
STEREOGRID_HD inline Matrix3 carried(const Matrix3& a, const Matrix3& covariance) {
  return a * covariance * transposed(a);
}

/// By cofactors; the result for a singular matrix is not finite.
STEREOGRID_HD inline Matrix3 inverse(const Matrix3& a) {
  const auto cofactor = [&](int row, int column) {
    const int r1{(row + 1) % 3}, r2{(row + 2) % 3}, c1{(column + 1) % 3}, c2{(column + 2) % 3};
    return a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1];
  };
  const double determinant{a[0][0] * cofactor(0, 0) + a[0][1] * cofactor(0, 1) + a[0][2] * cofactor(0, 2)};
  Matrix3 result{};
  for (int i{0}; i < 3; ++i) {
    for (int j{0}; j < 3; ++j) result[j][i] = cofactor(i, j) / determinant;
  }
  return result;
}

/// For a symmetric matrix: all pivots of its elimination above 0, and above what rounding makes of 0.
STEREOGRID_HD inline bool is_positive_definite(const Matrix3& a) {
  constexpr double rounding{1e-9};  // share of the diagonal
  const double minor2{a[0][0] * a[1][1] - a[0][1] * a[1][0]};
  const double determinant{a[2][0] * (a[0][1] * a[1][2] - a[0][2] * a[1][1]) -
                           a[2][1] * (a[0][0] * a[1][2] - a[0][2] * a[1][0]) + a[2][2] * minor2};
  return a[0][0] > 0 && minor2 > rounding * a[0][0] * a[1][1] && determinant > rounding * minor2 * a[2][2];
}

}  // namespace stereogrid

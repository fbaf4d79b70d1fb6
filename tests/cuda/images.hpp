// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "backend/cuda.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::test {

/// The same numbers on every machine.
class Random {
 public:
  explicit Random(unsigned seed) : generator_{seed} {}

  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(generator_()) / 4294967296.0);
  }
  int whole(int low, int high) {
    return low + static_cast<int>(generator_() % static_cast<unsigned long>(high - low + 1));
  }
  bool happens(double share) { return between(0, 1) < share; }

  Image<float> image(int width, int height, double low, double high) {
    Image<float> result{width, height};
    for (float& value : result) value = static_cast<float>(between(low, high));
    return result;
  }

 private:
  std::mt19937 generator_;
};

template <class T>
DeviceImage<T> on_device(Cuda& cuda, const Image<T>& image) {
  DeviceImage<T> result{image.width(), image.height()};
  upload(cuda, image.data(), image.size(), result.data());
  cuda.synchronize();
  return result;
}

template <class T>
DeviceBuffer<T> one_on_device(Cuda& cuda, const T& value) {
  DeviceBuffer<T> result{1};
  upload(cuda, &value, 1, result.data());
  cuda.synchronize();
  return result;
}

template <class T>
Image<T> on_host(Cuda& cuda, const DeviceImage<T>& image) {
  Image<T> result{image.width(), image.height()};
  download(cuda, image.data(), image.size(), result.data());
  cuda.synchronize();
  return result;
}

template <class T>
T first_on_host(Cuda& cuda, const DeviceBuffer<T>& buffer) {
  T result{};
  download(cuda, buffer.data(), 1, &result);
  cuda.synchronize();
  return result;
}

/// Elements that differ.
template <class T>
int differences(const Image<T>& a, const Image<T>& b) {
  if (a.width() != b.width() || a.height() != b.height()) return -1;
  int different{0};
  for (std::size_t i{0}; i < a.size(); ++i) different += a.data()[i] == b.data()[i] ? 0 : 1;
  return different;
}

/// Largest difference; where one of them is infinite or no number, the other must be the same.
inline double largest_difference(const Image<float>& a, const Image<float>& b) {
  if (a.width() != b.width() || a.height() != b.height()) return 1e30;
  double largest{0};
  for (std::size_t i{0}; i < a.size(); ++i) {
    const double difference{std::abs(static_cast<double>(a.data()[i]) - static_cast<double>(b.data()[i]))};
    if (a.data()[i] == b.data()[i]) continue;
    largest = difference < 1e30 ? std::max(largest, difference) : 1e30;
  }
  return largest;
}

}  // namespace stereogrid::test

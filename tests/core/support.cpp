// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

namespace stereogrid::test {

Rig small_kitti_rig() {
  return {621, 188, 360.5, 304.8, 86.4, 0.537, 1.65, 0, 0};
}

std::vector<double> uniform_speeds(double step_mps, int count) {
  std::vector<double> speeds;
  for (int i{1}; i <= count; ++i) speeds.push_back(i * step_mps);
  return speeds;
}

Texture::Texture(unsigned seed) {
  std::mt19937 generator{seed};
  for (int wave{0}; wave < 40; ++wave) {
    const double length_px{uniform(generator, 3.5, 25)};
    const double direction{uniform(generator, 0, 2 * pi)};
    waves_.push_back({std::cos(direction) / length_px, std::sin(direction) / length_px, uniform(generator, 0, 1)});
  }
}

double Texture::at(double u, double v) const {
  constexpr double to_whole{0x1.8p52};
  double sum{0};
  for (const Wave& wave : waves_) {
    const double turns{wave.per_u * u + wave.per_v * v + wave.phase};
    const double half_turns{2 * (turns - ((turns + to_whole) - to_whole))};  // −1 … 1
    const double parabola{4 * half_turns * (1 - std::abs(half_turns))};
    sum += parabola * (0.775 + 0.225 * std::abs(parabola));  // a sine but for 0.001, in a tenth of its time
  }
  return 100 + 80 * std::tanh(sum / 6);
}

Image<std::uint8_t> noise_image(int width, int height, std::mt19937& generator) {
  Image<std::uint8_t> image{width, height};
  for (std::uint8_t& pixel : image) pixel = static_cast<std::uint8_t>(generator() >> 24);
  return image;
}

double uniform(std::mt19937& generator, double low, double high) {
  return low + (high - low) * (static_cast<double>(generator()) / 4294967296.0);
}

int uniform_int(std::mt19937& generator, int low, int high) {
  return low + static_cast<int>(generator() % static_cast<unsigned>(high - low + 1));
}

double gaussian(std::mt19937& generator) {
  double sum{-6};
  for (int i{0}; i < 12; ++i) sum += uniform(generator, 0, 1);
  return sum;
}

}  // namespace stereogrid::test

// SPDX-License-Identifier: Apache-2.0
// Four distortion coefficients without a lens model: the images decide.
#include <cmath>
#include <random>

#include "stereogrid/io/recording.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

constexpr int width_px{256};
constexpr int height_px{160};
constexpr double focal_px{93};
constexpr double cx_px{127.5};
constexpr double cy_px{79.5};
constexpr double baseline_m{0.25};

/// Noise on a wall 1 m ahead, bilinear between points 2 cm apart.
class Wall {
 public:
  Wall() {
    std::mt19937 random{7};
    for (double& grey : greys_) grey = static_cast<double>(random() % 256);
  }
  [[nodiscard]] double at(double x_m, double y_m) const {
    constexpr double apart_m{0.02};
    const double u{x_m / apart_m + side_ / 2.0};
    const double v{y_m / apart_m + side_ / 2.0};
    if (!(u >= 0 && v >= 0 && u < side_ - 1 && v < side_ - 1)) return 0;
    const auto i{static_cast<std::size_t>(u)};
    const auto j{static_cast<std::size_t>(v)};
    const double du{u - static_cast<double>(i)};
    const double dv{v - static_cast<double>(j)};
    const auto grey{[&](std::size_t a, std::size_t b) { return greys_[b * side_ + a]; }};
    return (1 - dv) * ((1 - du) * grey(i, j) + du * grey(i + 1, j)) +
           dv * ((1 - du) * grey(i, j + 1) + du * grey(i + 1, j + 1));
  }

 private:
  static constexpr std::size_t side_{400};
  std::vector<double> greys_ = std::vector<double>(side_ * side_);
};

/// As cv::fisheye with coefficients near 0 images the wall (r = f θ), or a pinhole (r = f tan θ).
Image<std::uint8_t> image_of(const Wall& wall, double camera_x_m, bool is_fisheye) {
  Image<std::uint8_t> image{width_px, height_px};
  for (const auto [u, v] : raster(width_px, height_px)) {
    const double x{(u - cx_px) / focal_px};
    const double y{(v - cy_px) / focal_px};
    const double r{std::hypot(x, y)};
    const double scale{is_fisheye && r > 0 ? std::tan(r) / r : 1};
    image(u, v) = static_cast<std::uint8_t>(std::lround(wall.at(camera_x_m + scale * x, scale * y)));
  }
  return image;
}

struct LensChoice : FolderTest {
  void put_drive(bool is_fisheye) const {
    const Wall wall;
    for (const char* const side : {"left", "right"}) {
      fs::create_directories(folder / side);
      const double x_m{side[0] == 'l' ? 0 : baseline_m};
      write_png(folder / side / "1.png", image_of(wall, x_m, is_fisheye));
    }
    put(folder / "stereo.json", R"({"K1": [[93, 0, 127.5], [0, 93, 79.5], [0, 0, 1]], "D1": [1e-9, 0, 0, 0],
      "K2": [[93, 0, 127.5], [0, 93, 79.5], [0, 0, 1]], "D2": [1e-9, 0, 0, 0],
      "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "T": [-0.25, 0, 0]})");
  }
  [[nodiscard]] std::unique_ptr<Recording> open() const { return open_recording({{folder.path()}, {}, "none"}); }
};

TEST_F(LensChoice, FollowsTheRowsOfThePair) {
  for (const bool is_fisheye : {true, false}) {
    put_drive(is_fisheye);
    const auto recording{open()};
    const Calibration& calibration{recording->contents().calibration};
    EXPECT_FALSE(calibration.is_lens_unnamed);
    EXPECT_EQ(calibration.raw->left.lens, is_fisheye ? LensModel::fisheye : LensModel::perspective);
    EXPECT_THAT(calibration.notes, ::testing::Contains(::testing::HasSubstr("lens: four coefficients")));
  }
}

TEST_F(LensChoice, AsksWhereImagesDoNotShowIt) {
  put_drive(true);
  for (const char* const side : {"left", "right"}) {
    write_png(folder / side / "1.png", Image<std::uint8_t>{width_px, height_px, 90});
  }
  expect_error([&] { return open(); }, {"stereo.json", "lens: fisheye", "from: FILE"});
  put(folder / "calibration.yaml", "from: stereo.json\nlens: fisheye\n");
  EXPECT_EQ(open()->contents().calibration.raw->left.lens, LensModel::fisheye);
}

}  // namespace
}  // namespace stereogrid::io::testing

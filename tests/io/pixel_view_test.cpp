// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Views of OpenCV's images become what OpenCV itself makes of them.
#include "stereogrid/pixel_view.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "stereogrid/error.hpp"
#include "stereogrid/opencv.hpp"

namespace stereogrid::test {
namespace {

cv::Mat random_image(int rows, int columns, int type) {
  cv::Mat image(rows, columns, type);
  cv::RNG random{7};
  random.fill(image, cv::RNG::UNIFORM, 0, type == CV_16UC1 ? 65536 : 256);
  return image;
}

void expect_equal(const Image<std::uint8_t>& image, const cv::Mat& expected) {
  ASSERT_EQ(image.width(), expected.cols);
  ASSERT_EQ(image.height(), expected.rows);
  for (int v{0}; v < image.height(); ++v) {
    for (int u{0}; u < image.width(); ++u) ASSERT_EQ(image(u, v), expected.at<std::uint8_t>(v, u)) << u << " " << v;
  }
}

TEST(PixelView, ColourIsGreyAsOpencvMakesIt) {
  Image<std::uint8_t> image;
  cv::Mat grey;
  const cv::Mat bgr{random_image(700, 1001, CV_8UC3)};
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  assign(image, view_of(bgr));
  expect_equal(image, grey);

  PixelView as_rgb{view_of(bgr)};
  as_rgb.format = PixelFormat::rgb8;
  cv::cvtColor(bgr, grey, cv::COLOR_RGB2GRAY);
  assign(image, as_rgb);
  expect_equal(image, grey);

  const cv::Mat bgra{random_image(60, 41, CV_8UC4)};
  cv::cvtColor(bgra, grey, cv::COLOR_BGRA2GRAY);
  assign(image, view_of(bgra));
  expect_equal(image, grey);
}

TEST(PixelView, HalvesOfOneImageAreTakenInPlace) {
  const cv::Mat both{random_image(40, 62, CV_8UC1)};
  Image<std::uint8_t> right;
  assign(right, view_of(both.colRange(31, 62)));
  expect_equal(right, both.colRange(31, 62));
}

TEST(PixelView, SixteenBitImagesAreScaled) {
  const cv::Mat deep{random_image(30, 33, CV_16UC1)};
  Image<std::uint8_t> image;
  assign(image, view_of(deep));
  for (int v{0}; v < deep.rows; ++v) {
    for (int u{0}; u < deep.cols; ++u) ASSERT_EQ(image(u, v), deep.at<std::uint16_t>(v, u) >> 8);
  }
  assign(image, view_of(deep, 12));
  EXPECT_EQ(image(4, 5), std::min(deep.at<std::uint16_t>(5, 4) >> 4, 255));
}

TEST(PixelView, OtherMatsAreRefused) {
  for (const int type : {CV_8SC1, CV_32FC1, CV_64FC1, CV_8UC2, CV_16UC3, CV_16SC1}) {
    EXPECT_THROW(static_cast<void>(view_of(cv::Mat(4, 4, type))), InputError) << type;
  }
  const int sizes[3]{2, 3, 4};
  EXPECT_THROW(static_cast<void>(view_of(cv::Mat(3, sizes, CV_8UC1))), InputError);
  Image<std::uint8_t> image{2, 2};
  assign(image, view_of(cv::Mat{}));
  EXPECT_TRUE(image.empty());
}

}  // namespace
}  // namespace stereogrid::test

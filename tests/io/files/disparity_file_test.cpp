// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

constexpr int width_px{31};
constexpr int height_px{17};

// Multiples of 1/256, so that every format holds them exactly; some pixels without a disparity.
Image<float> sample() {
  Image<float> image{width_px, height_px};
  for (const auto [u, v] : raster(width_px, height_px)) {
    image(u, v) = (u + v) % 7 == 0 ? 0.0F : static_cast<float>(64 + 128 * u + v) / 256;
  }
  return image;
}

cv::Mat mat_of(const Image<float>& image) {
  return {image.height(), image.width(), CV_32FC1, const_cast<float*>(image.data())};
}

void write_kitti_png(const fs::path& path, const Image<float>& image) {
  Image<std::uint16_t> scaled{image.width(), image.height()};
  std::ranges::transform(image, scaled.begin(), [](float d) { return static_cast<std::uint16_t>(d * 256); });
  write_png(path, scaled);
}

std::string pfm_of(const Image<float>& image, std::endian order) {
  std::string bytes{"Pf\n" + std::to_string(image.width()) + " " + std::to_string(image.height()) +
                    (order == std::endian::little ? "\n-1.0\n" : "\n1.0\n")};
  for (int v{image.height() - 1}; v >= 0; --v) {
    for (int u{0}; u < image.width(); ++u) {
      auto bits{std::bit_cast<std::uint32_t>(image(u, v))};
      for (int i{0}; i < 4; ++i) {
        const int shift{order == std::endian::little ? 8 * i : 24 - 8 * i};
        bytes += static_cast<char>(bits >> shift & 0xff);
      }
    }
  }
  return bytes;
}

template <class T>
std::string npy_of(const std::string& descr, const std::string& shape, const std::vector<T>& values,
                   const std::string& fortran = "False") {
  std::string head{"{'descr': '" + descr + "', 'fortran_order': " + fortran + ", 'shape': (" + shape + "), }"};
  head.resize(117, ' ');
  head += '\n';
  std::string bytes{std::string{"\x93NUMPY\x01\x00", 8} + static_cast<char>(head.size()) + '\0' + head};
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  return bytes;
}

struct DisparityFile : FolderTest {
  [[nodiscard]] fs::path file(const char* name) const { return folder / name; }
  void expect_sample(const char* name) const { EXPECT_EQ(read_disparity(file(name)), sample()) << name; }
  void expect_refused(const char* name, std::initializer_list<std::string_view> parts) const {
    expect_error([&] { return read_disparity(file(name)); }, parts);
    expect_error([&] { return read_disparity(file(name)); }, {name});
  }
  void cut(const char* name, double share) const {
    const std::string whole{read_file(file(name))};
    put(file(name), whole.substr(0, static_cast<std::size_t>(static_cast<double>(whole.size()) * share)));
  }
};

TEST_F(DisparityFile, KittiPng) {
  write_kitti_png(file("a.png"), sample());
  expect_sample("a.png");
}

TEST_F(DisparityFile, PfmOfEitherByteOrder) {
  put(file("little.pfm"), pfm_of(sample(), std::endian::little));
  put(file("big.pfm"), pfm_of(sample(), std::endian::big));
  expect_sample("little.pfm");
  expect_sample("big.pfm");
  cv::imwrite(file("opencv.pfm").string(), mat_of(sample()));
  expect_sample("opencv.pfm");
}

TEST_F(DisparityFile, TiffOfFloats) {
  cv::imwrite(file("a.tiff").string(), mat_of(sample()));
  expect_sample("a.tiff");
  cv::Mat wide;
  mat_of(sample()).convertTo(wide, CV_64F);
  cv::imwrite(file("b.tif").string(), wide);
  expect_sample("b.tif");
}

TEST_F(DisparityFile, NumpyOfFloatsAndDoubles) {
  const Image<float> image{sample()};
  put(file("f.npy"), npy_of("<f4", "17, 31", std::vector<float>{image.begin(), image.end()}));
  put(file("d.npy"), npy_of("<f8", "17, 31", std::vector<double>{image.begin(), image.end()}));
  expect_sample("f.npy");
  expect_sample("d.npy");
}

TEST_F(DisparityFile, WhatNumpyWrites) {
  if (!has_numpy()) GTEST_SKIP() << "/usr/bin/python3 has no numpy";
  ASSERT_TRUE(run_python("import numpy as np\nd = np.arange(12, dtype=np.float32).reshape(3, 4) / 4 + 1\nf = '" +
                         folder.path().string() +
                         "/'\nnp.save(f + 'a.npy', d)\nnp.save(f + 'h.npy', d.astype(np.float16))\n"
                         "np.save(f + 't.npy', np.asfortranarray(d))\nnp.save(f + 'one.npy', d[None])\n"));
  const Image<float> image{read_disparity(file("a.npy"))};
  EXPECT_EQ(image.width(), 4);
  EXPECT_EQ(image(1, 2), 3.25F);
  for (const char* const name : {"h.npy", "t.npy", "one.npy"}) EXPECT_EQ(read_disparity(file(name)), image) << name;
  ASSERT_TRUE(run_python("import numpy as np\nd = np.arange(24).reshape(2, 3, 4) * 250\nf = '" +
                         folder.path().string() +
                         "/'\nnp.save(f + 'three.npy', d)\nnp.save(f + 'mm.npy', d[0].astype(np.uint16))\n"));
  expect_refused("three.npy", {"3 dimensions", "(height, width)"});
  EXPECT_EQ(read_depth(file("mm.npy"), 1000)(1, 2), 2.25F);
}

TEST_F(DisparityFile, WhatIsNoDisparityIsNone) {
  Image<float> image{4, 2, 3};
  image(0, 0) = std::numeric_limits<float>::infinity();
  image(1, 0) = std::numeric_limits<float>::quiet_NaN();
  image(2, 0) = -3;
  image(3, 0) = -std::numeric_limits<float>::infinity();
  put(file("a.pfm"), pfm_of(image, std::endian::little));
  put(file("a.npy"), npy_of("<f4", "2, 4", std::vector<float>{image.begin(), image.end()}));
  cv::imwrite(file("a.tiff").string(), mat_of(image));
  Image<float> expected{4, 2, 3};
  for (int u{0}; u < 4; ++u) expected(u, 0) = 0;
  for (const char* const name : {"a.pfm", "a.npy", "a.tiff"}) EXPECT_EQ(read_disparity(file(name)), expected) << name;
}

TEST_F(DisparityFile, WithoutAnyDisparityIsFine) {
  put(file("a.pfm"), pfm_of(Image<float>{5, 4}, std::endian::little));
  EXPECT_EQ(read_disparity(file("a.pfm")), (Image<float>{5, 4}));
}

TEST_F(DisparityFile, OtherTypesAreRefused) {
  write_png(file("eight.png"), Image<std::uint8_t>{9, 8, 7});
  expect_refused("eight.png", {"16 bits", "256"});
  write_png(file("colour.png"), RgbImage{3, 8, Image<std::uint8_t>{9, 8, 7}});
  expect_refused("colour.png", {"one channel"});
  cv::imwrite(file("colour.pfm").string(), cv::Mat(8, 9, CV_32FC3, cv::Scalar(1, 2, 3)));
  expect_refused("colour.pfm", {"colour"});
  cv::imwrite(file("whole.tiff").string(), cv::Mat(8, 9, CV_16UC1, cv::Scalar(3)));
  expect_refused("whole.tiff", {"floats"});
  put(file("whole.npy"), npy_of("<i4", "1, 2", std::vector<std::int32_t>{5, 6}));
  expect_refused("whole.npy", {"<i4", "divide them by 16"});
  put(file("text.pfm"), "hello");
  expect_refused("text.pfm", {"kind that can be read", "PFM"});
  put(file("nothing.npy"), "");
  expect_refused("nothing.npy", {"empty"});
  put(file("no_pixels.npy"), npy_of("<f4", "0, 4", std::vector<float>{}));
  expect_refused("no_pixels.npy", {"no pixels"});
  expect_refused("not_there.png", {"no such file"});
}

TEST_F(DisparityFile, TruncatedFilesAreRefused) {
  const Image<float> image{sample()};
  for (const double share : {0.98, 0.5, 0.05}) {
    write_kitti_png(file("a.png"), image);
    put(file("a.pfm"), pfm_of(image, std::endian::little));
    cv::imwrite(file("a.tiff").string(), mat_of(image));
    put(file("a.npy"), npy_of("<f4", "17, 31", std::vector<float>{image.begin(), image.end()}));
    for (const char* const name : {"a.png", "a.pfm", "a.tiff", "a.npy"}) {
      cut(name, share);
      expect_refused(name, {"again"});
    }
  }
}

TEST_F(DisparityFile, DamagedHeadersAreRefused) {
  for (const char* const head : {"Pf\n0 5\n-1.0\n", "Pf\n-3 5\n-1.0\n", "Pf\nfive 5\n-1.0\n", "Pf\n5 5\n0\n",
                                 "Pf\n99999999 99999999\n-1.0\n", "Pf\n1 1\n-1.0", "Pf"}) {
    put(file("a.pfm"), head);
    expect_refused("a.pfm", {"header"});
  }
}

TEST_F(DisparityFile, NumbersThatAreNoPixelsAreRefused) {
  Image<float> image{sample()};
  for (float& d : image) d *= 256;
  put(file("scaled.pfm"), pfm_of(image, std::endian::little));
  expect_refused("scaled.pfm", {"exceed the image's width", "scale"});
  for (float& d : image) d /= 65536 * 8;
  put(file("shares.pfm"), pfm_of(image, std::endian::little));
  expect_refused("shares.pfm", {"no value reaches 1 px"});
}

}  // namespace
}  // namespace stereogrid::io::testing

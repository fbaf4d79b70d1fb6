// SPDX-License-Identifier: Apache-2.0
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "files/formats.hpp"
#include "stereogrid/io/ros_image.hpp"
#include "stereogrid/opencv.hpp"
#include "stereogrid/pixel_view.hpp"
#include "support.hpp"

// OpenCV's imgcodecs is the oracle.
namespace stereogrid::io::testing {
namespace {

/// A PNG of noise whose rows have the filters 0 to 4 in turn, in two IDAT chunks.
std::string png_with_every_filter(std::uint32_t width, std::uint32_t height, int bits, int colour_type) {
  constexpr int channels_of_type[]{1, 0, 3, 1, 2, 0, 4};
  const std::size_t row_bytes{(width * static_cast<std::size_t>(bits * channels_of_type[colour_type]) + 7) / 8};
  std::string rows;
  std::mt19937 generator{7};
  for (std::uint32_t v{0}; v < height; ++v) {
    rows += static_cast<char>(v % 5);
    for (std::size_t i{0}; i < row_bytes; ++i) rows += static_cast<char>(generator() & 0xff);
  }
  const std::string packed{deflate(rows, DeflateForm::zlib)};
  const std::string header{big_endian(width) + big_endian(height) + static_cast<char>(bits) +
                           static_cast<char>(colour_type) + std::string(3, '\0')};
  std::string palette;
  for (int i{0}; i < 3 << bits && colour_type == 3; ++i) palette += static_cast<char>(generator() & 0xff);
  const std::size_t half{packed.size() / 2};
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + (palette.empty() ? "" : png_chunk("PLTE", palette)) +
         png_chunk("IDAT", packed.substr(0, half)) + png_chunk("IDAT", packed.substr(half)) + png_chunk("IEND", "");
}

void expect_as_opencv(const std::string& bytes, const std::string& what) {
  const cv::Mat read{decode_image("image", bytes)};
  cv::Mat wanted{cv::imdecode(std::vector<uchar>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED)};
  if (wanted.channels() == 4) cv::cvtColor(wanted, wanted, cv::COLOR_BGRA2BGR);
  if (wanted.channels() == 3 && read.channels() == 1)
    cv::cvtColor(wanted, wanted, cv::COLOR_BGR2GRAY);  // grey with alpha
  ASSERT_EQ(read.type(), wanted.type()) << what;
  ASSERT_EQ(read.size(), wanted.size()) << what;
  EXPECT_EQ(cv::norm(read, wanted, cv::NORM_INF), 0) << what;
}

cv::Mat noise(int type, int width = 37, int height = 23) {
  cv::Mat image(height, width, type);
  cv::RNG generator{5};
  generator.fill(image, cv::RNG::UNIFORM, 0, image.depth() == CV_8U ? 256 : 65536);
  return image;
}

TEST(DecodeImage, PngsOfEveryKindAreWhatOpenCvReads) {
  for (const int colour_type : {0, 2, 3, 4, 6}) {
    for (const int bits : {1, 2, 4, 8, 16}) {
      if ((bits < 8 && colour_type != 0 && colour_type != 3) || (bits == 16 && colour_type == 3)) continue;
      for (const auto& [width, height] : {std::pair{1u, 1u}, {1u, 12u}, {37u, 23u}}) {
        expect_as_opencv(png_with_every_filter(width, height, bits, colour_type),
                         std::to_string(bits) + " " + std::to_string(colour_type) + " " + std::to_string(width));
      }
    }
  }
}

TEST(DecodeImage, OtherFormatsAreWhatOpenCvReads) {
  std::vector<uchar> bytes;
  const auto expect{[&](const std::string& ending, const cv::Mat& image, const std::vector<int>& options = {}) {
    cv::imencode(ending, image, bytes, options);
    expect_as_opencv({bytes.begin(), bytes.end()}, ending + " of type " + std::to_string(image.type()));
  }};
  for (const int type : {CV_8UC1, CV_8UC3}) {
    expect(".bmp", noise(type));
    for (const int quality : {50, 95}) expect(".jpg", noise(type), {cv::IMWRITE_JPEG_QUALITY, quality});
    expect(".jpg", noise(type), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
    for (const int is_binary : {0, 1})
      expect(type == CV_8UC1 ? ".pgm" : ".ppm", noise(type), {cv::IMWRITE_PXM_BINARY, is_binary});
  }
  expect(".bmp", noise(CV_8UC4));
  for (const int is_binary : {0, 1}) {
    expect(".pgm", noise(CV_16UC1), {cv::IMWRITE_PXM_BINARY, is_binary});
    expect(".ppm", noise(CV_16UC3), {cv::IMWRITE_PXM_BINARY, is_binary});
  }
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3, CV_32FC1, CV_64FC1}) {
    for (const int compression : {1, 5, 32946})
      expect(".tiff", noise(type), {cv::IMWRITE_TIFF_COMPRESSION, compression});
  }
  for (const int quality : {50, 101}) {  // 101: lossless
    for (const int type : {CV_8UC3, CV_8UC4}) expect(".webp", noise(type), {cv::IMWRITE_WEBP_QUALITY, quality});
  }
  for (const char* const text :
       {"P2 2 2 100 0 50 99 100\n", "P2 2 2 7 0 3 6 9\n", "P3 1 2 1000 0 1 999 1000 1001 7\n"}) {
    expect_as_opencv(text, text);
  }
}

TEST(DecodeImage, WrittenPngsAreWhatOpenCvReads) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3}) {
    const cv::Mat image{noise(type)};
    const std::string bytes{encode_png(image)};
    const cv::Mat read{cv::imdecode(std::vector<uchar>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED)};
    ASSERT_EQ(read.type(), type);
    EXPECT_EQ(cv::norm(read, image, cv::NORM_INF), 0);
  }
}

TEST(DecodeImage, WrittenJpegsAreWhatOpenCvWrites) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    std::vector<uchar> wanted;
    cv::imencode(".jpg", noise(type), wanted, {cv::IMWRITE_JPEG_QUALITY, 80});
    EXPECT_EQ(encode_jpeg(view_of(noise(type)), 80), wanted);
  }
}

TEST(DecodeImage, DamagedAndInterlacedPngs) {
  const auto expect{[](std::string bytes, std::initializer_list<std::string_view> parts) {
    expect_error([&] { return decode_image("a.png", bytes); }, parts);
  }};
  const std::string sound{png_with_every_filter(5, 5, 8, 0)};
  const auto with_header{[&](std::size_t at, char value) {
    std::string header{sound.substr(16, 13)};
    header[at] = value;
    return sound.substr(0, 8) + png_chunk("IHDR", header) + sound.substr(33);
  }};
  expect(with_header(7, 9), {"damaged"});     // rows are missing
  expect(with_header(8, 3), {"damaged"});     // bits
  expect(with_header(9, 3), {"damaged"});     // no palette
  expect(with_header(6, 0x7f), {"damaged"});  // more rows than the data can hold
  expect(with_header(12, 1), {"interlaced PNG", "Convert"});
}

TEST(DecodeImage, FormatsThatNoCameraRecordsAreRefused) {
  const TemporaryFolder folder;
  cv::imwrite((folder / "a.ras").string(), noise(CV_8UC1));
  expect_error([&] { return read_grey(folder / "a.ras"); }, {"a.ras", "not an image of a kind", "to PNG"});
}

TEST(Deflate, InflatesToWhatWasCompressed) {
  std::mt19937 generator{3};
  for (const std::size_t size : {0, 1, 15, 16, 17, 300, 70000}) {
    std::string bytes;
    while (bytes.size() < size) bytes += static_cast<char>(generator() % 7);
    std::vector<std::uint8_t> inflated(size);
    EXPECT_TRUE(inflate_zlib(deflate(bytes, DeflateForm::zlib), inflated));
    EXPECT_EQ(std::string(inflated.begin(), inflated.end()), bytes);
  }
}

TEST(RosImage, ReadsBayerPatterns) {
  constexpr std::uint32_t width{8};
  constexpr std::uint32_t height{6};
  for (const std::string pattern : {"rggb", "bggr", "gbrg", "grbg"}) {
    for (const std::uint32_t bytes : {1U, 2U}) {
      const std::string encoding{"bayer_" + pattern + (bytes == 1 ? "8" : "16")};
      std::vector<std::uint8_t> data;
      for (std::size_t v{0}; v < height; ++v) {
        for (std::size_t u{0}; u < width; ++u) {
          // red pixels are brighter: 0.299 of the difference remains
          data.push_back(pattern[v % 2 * 2 + u % 2] == 'r' ? 200 : 100);
          if (bytes == 2) data.push_back(0);
        }
      }
      const RosImage image{encoding, data, false, width, height, width * bytes, true};
      EXPECT_NEAR(decode_ros_image(image, "image").grey(4, 3), 130, 2) << encoding;
    }
  }
}

TEST(DecodeImage, ExifTurnsAJpegAsOpenCvDoes) {
  std::vector<uchar> jpeg;
  cv::Mat image{noise(CV_8UC1, 48, 32)};
  cv::GaussianBlur(image, image, {}, 3);
  cv::imencode(".jpg", image, jpeg);
  for (char orientation{1}; orientation <= 8; ++orientation) {
    for (const bool is_little : {true, false}) {
      const std::string tiff{is_little ? std::string{"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0", 18} +
                                             orientation + std::string(7, '\0')
                                       : std::string{"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0", 19} +
                                             orientation + std::string(6, '\0')};
      const std::string exif{std::string{"Exif\0\0", 6} + tiff};
      const std::string segment{std::string{"\xff\xe1\0", 3} + static_cast<char>(exif.size() + 2) + exif};
      std::string bytes{jpeg.begin(), jpeg.end()};
      bytes.insert(2, segment);
      const cv::Mat expected{cv::imdecode(std::vector<uchar>(bytes.begin(), bytes.end()), cv::IMREAD_GRAYSCALE)};
      const cv::Mat read{decode_image("image", bytes)};
      ASSERT_EQ(read.size(), expected.size()) << int{orientation};
      EXPECT_EQ(cv::norm(read, expected, cv::NORM_INF), 0) << int{orientation};
    }
  }
}

TEST(DecodeImage, WrongByteOrderIsCorrected) {
  constexpr int width{64};
  constexpr int height{48};
  cv::Mat smooth(height, width, CV_16UC1);
  for (const auto [u, v] : raster(width, height))
    smooth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(300 + 37 * u + 11 * v);
  const auto decoded{[&](const cv::Mat& samples, bool is_bigendian) {
    return decode_ros_image(
        {"mono16", {samples.data, samples.total() * 2}, false, width, height, 2 * width, is_bigendian}, "image");
  }};
  const ScaledImage right{decoded(smooth, false)};
  const ScaledImage wrong{decoded(smooth, true)};
  EXPECT_FALSE(right.has_other_byte_order);
  EXPECT_TRUE(wrong.has_other_byte_order);
  EXPECT_EQ(right.grey, wrong.grey);
  EXPECT_FALSE(decoded(noise(CV_16UC1, width, height), true).has_other_byte_order) << "noise is as rough in both";
}

}  // namespace
}  // namespace stereogrid::io::testing

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
  for (const auto [u, v] : raster(image)) ASSERT_EQ(image(u, v), expected.at<std::uint8_t>(v, u)) << u << " " << v;
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
  for (const auto [u, v] : raster(deep.cols, deep.rows)) ASSERT_EQ(image(u, v), deep.at<std::uint16_t>(v, u) >> 8);
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

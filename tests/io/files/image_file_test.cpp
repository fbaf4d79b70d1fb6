// SPDX-License-Identifier: Apache-2.0
#include <sys/resource.h>

#include <csignal>
#include <opencv2/imgcodecs.hpp>

#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using File = FolderTest;
using ImageFile = FolderTest;

using namespace std::string_view_literals;  // for text with zeros in it

template <class T>
Image<T> ramp(int width, int height, int step) {
  Image<T> image{width, height};
  int value{0};
  for (T& pixel : image) pixel = static_cast<T>(value += step);
  return image;
}

TEST_F(ImageFile, GreyPngRoundTripsAtOddSizes) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 5}, {1241, 3}, {33, 17}}) {
    const auto image{ramp<std::uint8_t>(width, height, 7)};
    write_png(folder / "a.png", image);
    EXPECT_EQ(read_grey(folder / "a.png"), image) << width;
  }
}

TEST_F(ImageFile, SixteenBitPngRoundTrips) {
  const auto image{ramp<std::uint16_t>(31, 9, 251)};
  write_png(folder / "a.png", image);
  EXPECT_EQ(read_u16(folder / "a.png"), image);
}

TEST_F(ImageFile, EightBitFilesAreWidenedByReadU16) {
  write_png(folder / "a.png", Image<std::uint8_t>{3, 2, 200});
  EXPECT_EQ(read_u16(folder / "a.png"), (Image<std::uint16_t>{3, 2, 200}));
}

TEST_F(ImageFile, ColourPngRoundTripsAndBecomesLuma) {
  RgbImage colour{3, 1, Image<std::uint8_t>{9, 1}};
  colour.pixels(0, 0) = colour.pixels(4, 0) = colour.pixels(8, 0) = 255;  // red, green, blue
  write_png(folder / "a.png", colour);
  EXPECT_EQ(read_rgb(folder / "a.png").pixels, colour.pixels);
  const auto grey{read_grey(folder / "a.png")};
  EXPECT_EQ(grey(0, 0), 76);
  EXPECT_EQ(grey(1, 0), 150);
  EXPECT_EQ(grey(2, 0), 29);
  expect_error([&] { return read_u16(folder / "a.png"); }, {"a.png", "colour"});
}

TEST_F(ImageFile, SixteenBitColourBecomesEightBits) {
  cv::imwrite((folder / "a.png").string(), cv::Mat(2, 3, CV_16UC3, cv::Scalar(0x1234, 0x1234, 0x1234)));
  EXPECT_EQ(sample_bits(folder / "a.png"), 13);
  EXPECT_EQ(read_grey(folder / "a.png", 16)(2, 1), 0x12);
  EXPECT_EQ(read_rgb(folder / "a.png").pixels(8, 1), 0x12);
}

TEST_F(ImageFile, AlphaIsLeftOut) {
  cv::imwrite((folder / "a.png").string(), cv::Mat(2, 3, CV_8UC4, cv::Scalar(90, 90, 90, 0)));
  EXPECT_EQ(read_grey(folder / "a.png"), (Image<std::uint8_t>{3, 2, 90}));
}

TEST_F(ImageFile, ScaleOfSixteenBitFiles) {
  Image<std::uint16_t> image{4, 1, 0};
  image(1, 0) = 1000;
  image(2, 0) = 4095;
  write_png(folder / "a.png", image);
  EXPECT_EQ(sample_bits(folder / "a.png"), 12);
  const auto own{read_grey(folder / "a.png")};
  EXPECT_EQ(own(1, 0), 62);
  EXPECT_EQ(own(2, 0), 255);
  const auto saturated{read_grey(folder / "a.png", 10)};
  EXPECT_EQ(saturated(1, 0), 250);
  EXPECT_EQ(saturated(2, 0), 255) << "brighter than 10 bits: saturates";
  for (const auto& [brightest, bits] : {std::pair{3, 10}, {1023, 10}, {1024, 11}, {16383, 14}, {65535, 16}}) {
    write_png(folder / "b.png", Image<std::uint16_t>{2, 2, static_cast<std::uint16_t>(brightest)});
    EXPECT_EQ(sample_bits(folder / "b.png"), bits);
  }
  write_png(folder / "c.png", Image<std::uint8_t>{2, 2, 255});
  EXPECT_EQ(sample_bits(folder / "c.png"), 8);
}

TEST_F(ImageFile, Pgm) {
  put(folder / "a.pgm", "P5\n# a comment\n3 2\n255\n\x01\x02\x03\x04\x05\xff"sv);
  EXPECT_EQ(read_grey(folder / "a.pgm")(2, 1), 255);
  EXPECT_EQ(read_grey(folder / "a.pgm")(0, 0), 1);
  put(folder / "b.pgm", "P5 2 1 65535\n\x01\x00\x0f\xff"sv);
  EXPECT_EQ(read_u16(folder / "b.pgm")(0, 0), 256) << "PGM is big-endian";
  EXPECT_EQ(read_grey(folder / "b.pgm")(1, 0), 255);
  put(folder / "c.pgm", "P2\n2 1\n255\n7 9\n");
  EXPECT_EQ(read_grey(folder / "c.pgm")(1, 0), 9);
}

TEST_F(ImageFile, Jpeg) {
  cv::imwrite((folder / "a.jpg").string(), cv::Mat(37, 51, CV_8UC3, cv::Scalar(120, 120, 120)));
  const auto grey{read_grey(folder / "a.jpg")};
  EXPECT_EQ(grey.width(), 51);
  EXPECT_EQ(grey.height(), 37);
  EXPECT_NEAR(grey(20, 20), 120, 2);
}

TEST_F(ImageFile, AJpegIsReadDespiteWarningsButNotDespiteErrorsAfterThem) {
  cv::imwrite((folder / "a.jpg").string(), cv::Mat(30, 40, CV_8UC1, cv::Scalar(120)));
  std::string bytes{read_file(folder / "a.jpg")};
  const std::size_t table{bytes.find("\xff\xdb\x00\x43"sv)};
  ASSERT_NE(table, std::string::npos);
  bytes.insert(table, "xyz");  // "extraneous bytes before marker" is a warning
  put(folder / "warning.jpg", bytes);
  EXPECT_EQ(read_grey(folder / "warning.jpg"), read_grey(folder / "a.jpg"));
  bytes[table + 4] = '\xfe';  // the quantization table becomes a comment: the decoder cannot continue
  put(folder / "error.jpg", bytes);
  expect_error([&] { return read_grey(folder / "error.jpg"); }, {"error.jpg", "damaged"});
}

TEST_F(ImageFile, EveryTruncationIsSeenInSilence) {
  const StereoFrame frame{textured_pair(40, 30, 0)};
  write_png(folder / "a.png", frame.left);
  cv::imwrite((folder / "a.jpg").string(), cv::Mat(30, 40, CV_8UC1, const_cast<uchar*>(frame.left.data())));
  cv::imwrite((folder / "a.pgm").string(), cv::Mat(30, 40, CV_8UC1, const_cast<uchar*>(frame.left.data())));
  ::testing::internal::CaptureStderr();
  cv::imwrite((folder / "a.bmp").string(), cv::Mat(30, 40, CV_8UC1, const_cast<uchar*>(frame.left.data())));
  cv::imwrite((folder / "a.tiff").string(), cv::Mat(30, 40, CV_8UC1, const_cast<uchar*>(frame.left.data())));
  for (const char* const name : {"a.png", "a.jpg", "a.pgm", "a.bmp", "a.tiff"}) {
    const std::string whole{read_file(folder / name)};
    for (std::size_t length{0}; length < whole.size(); length += 1 + length / 40) {
      put(folder / "cut", whole.substr(0, length));
      expect_error([&] { return read_grey(folder / "cut"); }, {"cut"});
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST_F(ImageFile, EveryFlippedByteOfAPngIsSeenInSilence) {
  write_png(folder / "a.png", textured_pair(20, 10, 0).left);
  const std::string whole{read_file(folder / "a.png")};
  ::testing::internal::CaptureStderr();
  for (std::size_t at{0}; at < whole.size(); ++at) {
    std::string damaged{whole};
    damaged[at] = static_cast<char>(damaged[at] ^ 0x24);
    put(folder / "damaged.png", damaged);
    EXPECT_THROW(static_cast<void>(read_grey(folder / "damaged.png")), InputError) << "byte " << at;
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST_F(ImageFile, OddSideChunksOfAPngAreNotMentioned) {
  const Image<std::uint8_t> image{5, 4, 77};
  write_png(folder / "a.png", image);
  std::string bytes{read_file(folder / "a.png")};
  // a broken colour profile with its right checksum, behind IHDR: libpng warns of it
  bytes.insert(33, "\x00\x00\x00\x04iCCPa\x00\x00z\x5d\xf0\xb4\x50"sv);
  put(folder / "b.png", bytes);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(read_grey(folder / "b.png"), image);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST_F(ImageFile, NoImages) {
  put(folder / "text.png", "hello");
  put(folder / "empty.png", "");
  expect_error([&] { return read_grey(folder / "text.png"); }, {"text.png", "not an image", "PNG"});
  expect_error([&] { return read_grey(folder / "empty.png"); }, {"empty.png", "empty"});
  expect_error([&] { return read_grey(folder / "none.png"); }, {"none.png", "no such file"});
  expect_error([&] { return read_grey(folder.path()); }, {"folder"});
}

/// Files cannot grow beyond `bytes` while it lives: what a full disk looks like to a writer.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  rlimit before_{};
  void (*old_handler_)(int){};
};

TEST_F(File, FullDiskIsADeviceErrorAndLeavesTheOldFile) {
  write_file(folder / "a.txt", "old");
  {
    const SmallDisk disk{1000};
    expect_error<DeviceError>([&] { write_file(folder / "a.txt", std::string(5000, 'x')); },
                              {"a.txt", "cannot be written", "space"});
  }
  EXPECT_EQ(read_file(folder / "a.txt"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator{folder.path()}, {}), 1) << "the temporary file is gone";
}

TEST_F(File, MissingFolderIsADeviceError) {
  expect_error<DeviceError>(
      [&] {
        write_png(folder / "none" / "a.png", Image<std::uint8_t>{2, 2});
      },
      {"a.png", "cannot be written"});
  put(folder / "file", "");
  expect_error<DeviceError>([&] { create_folder(folder / "file" / "inside"); }, {"inside"});
}

TEST_F(File, RoundTripsAnyBytes) {
  const std::string bytes{"a\0b\r\n\xff", 6};
  write_file(folder / "a", bytes);
  EXPECT_EQ(read_file(folder / "a"), bytes);
}

}  // namespace
}  // namespace stereogrid::io::testing

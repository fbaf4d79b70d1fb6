// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstring>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/config_file.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/recording.hpp"
#include "support.hpp"

// Malicious files, and some accidental ones.
namespace stereogrid::io::testing {
namespace {

using namespace std::string_literals;
using namespace std::string_view_literals;

/// A PNG that says how many pixels it has, and has none.
std::string png_of(std::uint32_t width, std::uint32_t height) {
  const std::string signature{"\x89PNG\r\n\x1a\n"};
  return signature + png_chunk("IHDR", big_endian(width) + big_endian(height) + std::string{"\x08\0\0\0\0", 5}) +
         png_chunk("IDAT", "") + png_chunk("IEND", "");
}

struct Hostile : FolderTest {
  void refused(const std::function<void(const fs::path&)>& read, const std::string& name, std::string_view bytes,
               std::initializer_list<std::string_view> parts) const {
    put(folder / name, bytes);
    expect_error([&] { read(folder / name); }, parts);
  }
};

void read_image(const fs::path& path) {
  static_cast<void>(read_grey(path));
}

TEST_F(Hostile, PngWithAFlippedBitInTheNameOfAChunk) {
  write_png(folder / "a.png", Image<std::uint8_t>{4, 3, 9});
  std::string bytes{read_file(folder / "a.png")};
  bytes[bytes.find("IDAT")] = static_cast<char>('I' | 0x80);
  refused(read_image, "b.png", bytes, {"b.png", "\\xC9DAT"});
}

TEST_F(Hostile, ImagesThatDeclareAbsurdSizes) {
  for (const auto& [width, height] : {std::pair{100'000U, 100'000U}, {1U << 31, 1U}, {8192U, 8193U}}) {
    refused(read_image, "bomb.png", png_of(width, height), {"bomb.png", "says that it has", "can be read"});
  }
  refused(read_image, "none.png", png_of(0, 7), {"none.png", "no pixels"});
  refused(read_image, "bomb.pgm", "P5\n9999999999 9999999999\n255\n", {"bomb.pgm"});
  refused(read_image, "bomb.pgm", "P2\n32768 32768\n255\n1 2 3", {"bomb.pgm", "says that it has 32768 × 32768 px"});

  cv::imwrite((folder / "a.jpg").string(), cv::Mat(30, 40, CV_8UC1, cv::Scalar(99)));
  std::string jpeg{read_file(folder / "a.jpg")};
  const std::size_t frame{jpeg.find("\xff\xc0")};
  ASSERT_NE(frame, std::string::npos);
  const std::string sound{jpeg};
  jpeg.replace(frame + 5, 4, "\xff\xdc\xff\xdc");
  refused(read_image, "bomb.jpg", jpeg, {"bomb.jpg", "says that it has 65500 × 65500 px"});
  // a marker without length, before a comment that a reader of its length would land in
  const std::string comment{"\xff\xfe\xea\x60" + std::string(59'998, 'x') + "\xff\xfe\x2e\xe2"};
  std::string landing(12'000, 'y');
  landing.replace(0xfffe - 60'002 - 4, sound.size() - 2, sound.substr(2));
  for (const std::string_view hidden : {"\xff\x01"sv, "\xff\xd0"sv, "\xff\0"sv, "xyz\xff\xff"sv}) {
    refused(read_image, "bomb.jpg", "\xff\xd8" + std::string{hidden} + comment + landing + jpeg.substr(2),
            {"bomb.jpg", "says that it has 65500 × 65500 px"});
  }
}

TEST_F(Hostile, JpegWithHundredsOfScans) {
  const std::vector<int> progressive{cv::IMWRITE_JPEG_PROGRESSIVE, 1};
  cv::imwrite((folder / "a.jpg").string(), cv::Mat(30, 40, CV_8UC1, cv::Scalar(99)), progressive);
  std::string jpeg{read_file(folder / "a.jpg")};
  EXPECT_EQ(read_grey(folder / "a.jpg").width(), 40);
  const std::size_t scan{jpeg.rfind("\xff\xda")};
  ASSERT_NE(scan, std::string::npos);
  const std::string last{jpeg.substr(scan, jpeg.size() - 2 - scan)};
  for (int i{0}; i < 40; ++i) jpeg.insert(scan, last);
  refused(read_image, "scans.jpg", jpeg, {"scans.jpg", "more than 32 scans"});
}

void read_disparities(const fs::path& path) {
  static_cast<void>(read_disparity(path));
}

TEST_F(Hostile, DisparitiesThatDeclareAbsurdSizes) {
  refused(read_disparities, "a.pfm", "Pf\n32000 32000\n-1\nxxxx", {"a.pfm", "truncated"});
  for (const std::string_view head : {"II", "II*\0\x08\0\0\0", "II*\0\xff\xff\xff\xff"}) {
    refused(read_disparities, "a.tif", head, {"a.tif", "damaged"});
  }
  refused(read_disparities, "b.tif", "MM\0+\0\x08\0\0\xff\xff\xff\xff\xff\xff\xff\xff"s, {"b.tif", "damaged"});
  cv::imwrite((folder / "c.tif").string(), cv::Mat(5, 5, CV_8UC1, cv::Scalar(9)));
  const std::string sound{read_file(folder / "c.tif")};
  const auto tiff{[&](std::string_view tag, std::string_view value) {
    std::string bytes{sound};
    const std::size_t entry{bytes.find(std::string{tag} + "\x03\0\x01\0\0\0"s)};
    return entry == std::string::npos ? "" : bytes.replace(entry + 2, 10, "\x04\0\x01\0\0\0"s + std::string{value});
  }};
  refused(read_disparities, "width.tif", tiff("\x00\x01"sv, "\0\0\x01\0"sv), {"65536 × 5 px"});
  refused(read_disparities, "height.tif", tiff("\x01\x01"sv, "\xff\xff\xff\x7f"sv), {"height.tif"});
  refused(read_disparities, "both.tif", tiff("\x00\x01"sv, "\0\x70\0\0"sv), {"both.tif"});
  refused(read_disparities, "samples.tif", tiff("\x15\x01"sv, "\x09\0\0\0"sv), {"samples.tif"});
  std::string npy{"\x93NUMPY\x01\0\x56\0{'descr': '<f4', 'fortran_order': False, 'shape': (0, 9999999999999), }"s};
  npy.resize(10 + 0x56, ' ');
  refused(read_disparities, "a.npy", npy, {"a.npy", "along a side"});
}

TEST_F(Hostile, HeadOfAnArrayThatIsNoText) {
  std::string npy{"\x93NUMPY\x01\0\x10\0{\xff\xfe\x1b[31m}         "s};
  refused([](const fs::path& path) { return read_npy(path); }, "a.npy", npy,
          {"a.npy", "not understood", "\\xFF\\xFE\\x1B[31m"});
}

TEST_F(Hostile, ArchiveThatWouldUnfoldIntoGigabytes) {
  const std::vector<float> zeros(100'000);
  write_npz(folder / "a.npz", std::vector<NpzArray>{{"a", {zeros.size()}, zeros}});
  std::string bytes{read_file(folder / "a.npz")};
  // the size before packing, as the entry and the directory at the end declare it
  const auto size{static_cast<std::uint32_t>(zeros.size() * sizeof(float) + 128)};
  std::string old(4, '\0');
  std::memcpy(old.data(), &size, 4);
  int declared{0};
  for (std::size_t at{bytes.find(old)}; at != std::string::npos; at = bytes.find(old, at + 4), ++declared) {
    bytes.replace(at, 4, "\xff\xff\xff\xf0");
  }
  ASSERT_EQ(declared, 2);
  refused([](const fs::path& path) { return read_npz(path); }, "bomb.npz", bytes,
          {"bomb.npz", "array a.npy", "holds more than 512 MB"});
}

void read_any_calibration(const fs::path& path) {
  static_cast<void>(read_calibration(path, 64, 32));
}

constexpr const char* good_calibration{
    "focal_px: 60\ncx_px: 32\ncy_px: 16\nbaseline_m: 0.2\nmount: {camera_height_m: 1.2}\n"};

TEST_F(Hostile, CalibrationsThatAreNone) {
  put(folder / "good.yaml", "\xef\xbb\xbf"s + good_calibration);
  EXPECT_NO_THROW(read_any_calibration(folder / "good.yaml"));
  const std::string good{good_calibration};
  for (const auto& [text, said] : std::vector<std::pair<std::string, std::string_view>>{
           {good + "{a: 1}: 2\n", "key in line 6"},
           {good + "[1, 2]: 3\n", "key in line 6"},
           {good + "? &x {a: *x}\n: 2\n", "bad.yaml"},
           {"&x {mount: *x}\n", "bad.yaml"},
           {"&x {left: *x, right: *x, image: *x}\n", "bad.yaml"},
           {"&x [*x]\n", "not a YAML mapping"},
           {good + "left: &x [*x]\n", "bad.yaml"},
           {std::string(200'000, '['), "nested too deeply"},
           {std::string(200'000, '{'), "bad.yaml"},
           {std::string(2 << 20, ' '), "more than 1 MB"},
           {good + "k\xff\x1b: 3\n", "bad.yaml"},
           {"focal_px: 1e-300\n" + good.substr(13), "focal length"},
           {"focal_px: 1e300\n" + good.substr(13), "'focal_px'"},
           {"focal_px: [1, 2\n", "is not YAML"},
           {good.substr(0, good.find("mount")) + "mount: {camera_height_m: 1e-300}\n", "camera height"},
           {good.substr(0, good.find("base")) + "baseline_m: 1e-300\nmount: {camera_height_m: 1}\n", "baseline"},
           {good.substr(0, good.find("base")) + "baseline_m: [1]\nmount: [1]\n", "bad.yaml"}}) {
    refused(read_any_calibration, "bad.yaml", text, {"bad.yaml", said});
  }
}

TEST_F(Hostile, LidarThatIsFarAway) {
  const std::string rest{small_calib};
  put(folder / "good.txt", "\xef\xbb\xbf"s + rest + "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\r\n");
  EXPECT_TRUE(read_calibration(folder / "good.txt", 65, 33).camera_from_velodyne);
  const auto read{[](const fs::path& path) { return read_calibration(path, 65, 33); }};
  refused(read, "far.txt", rest + "Tr: 0 -1 0 2e9 0 0 -1 0 1 0 0 0\n", {"far.txt", "2e+09 m away", "metres"});
  refused(read, "flat.txt", rest + "Tr: 0 0 0 1 0 0 0 1 0 0 0 1\n", {"flat.txt", "not a rotation"});
}

TEST_F(Hostile, SweepWithPointsThatNoLidarSees) {
  const std::array<float, 12> points{1, 2, 3, 0, 2e9F, 0, 0, 0, 0, 0, -1e38F, 0};
  put(folder / "a.bin", {reinterpret_cast<const char*>(points.data()), sizeof points});
  EXPECT_EQ(read_scan(folder / "a.bin").size(), 1U);
}

TEST_F(Hostile, SettingsThatAreNone) {
  for (const auto& [text, said] : std::vector<std::pair<std::string, std::string_view>>{
           {"{a: 1}: 2\n", "a key is a word"},
           {"[1, 2]: 3\n", "a key is a word"},
           {"grid: &x {length_m: 30, more: *x}\n", "grid.more.length_m"},
           {"&x {grid: *x}\n", "groups in groups"},
           {std::string(200'000, '['), "bad.yaml"},
           {"grid: {length_m: .nan}\n", "grid.length_m"},
           {"grid: {length_m: \"\"}\n", "grid.length_m has no value"},
           {"grid: 3\n", "'grid' is a group"},
           {"grid: {length_m: 30}\ngrid: {width_m: 20}\n", "line 2: has 'grid' again"},
           {"grid: {length_m: 30}\ngrid.length_m: 31\n", "line 2: has 'grid.length_m' again"},
           {"grid: {length_m: " + std::string(100'000, '7') + "x}\n", "…"},
           {"gr\xff: 3\n", "bad.yaml"}}) {
    put(folder / "bad.yaml", text);
    Config config;
    try {
      load_config(folder / "bad.yaml", config);
      ADD_FAILURE() << "taken: " << text.substr(0, 80);
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(std::string{said}));
      EXPECT_LT(std::string_view{error.what()}.size(), 1000U);
    }
  }
  put(folder / "large.yaml", std::string(2 << 20, '#'));
  Config config;
  expect_error([&] { load_config(folder / "large.yaml", config); }, {"large.yaml", "more than 1 MB"});
  put(folder / "marked.yaml", "\xef\xbb\xbfgrid: {length_m: 31}\r\n");
  load_config(folder / "marked.yaml", config);
  EXPECT_EQ(config.grid.length_m, 31);
}

/// An alias for a large group, many times over: a quadratic number of keys in a small file.
TEST_F(Hostile, SettingsWithAliasesThatMultiply) {
  std::string text{"a: &a {"};
  for (int i{0}; i < 5000; ++i) text += "k" + std::to_string(i) + ": {},";
  text += "}\n";
  for (int i{0}; i < 5000; ++i) text += "b" + std::to_string(i) + ": *a\n";
  put(folder / "many.yaml", text);
  Config config;
  expect_error<ConfigError>([&] { load_config(folder / "many.yaml", config); }, {"more keys than parameters"});
}

TEST_F(Hostile, PosesThatLeadOutOfTheWorld) {
  const auto read{[](const fs::path& path) { return read_poses_csv(path); }};
  const std::string head{"\xef\xbb\xbfname,stamp_ns,x_m,y_m,yaw_rad\r\n"};
  put(folder / "good.csv", head + "a,1,0,0,0\r\n");
  EXPECT_NO_THROW(read(folder / "good.csv"));
  refused(read, "far.csv", head + "a,1,1e300,0,0\n", {"far.csv", "line 2", "100 million"});
  refused(read, "late.csv", head + "a,9223372036854775807,0,0,0\n", {"late.csv", "line 2", "2096"});
  refused(read, "early.csv", head + "a,-9223372036854775808,0,0,0\n", {"early.csv", "line 2"});
}

TEST_F(Hostile, AMillionLinesOfPosesTakeNoLongerThanTheyMust) {
  std::string text{"name,stamp_ns,x_m,y_m,yaw_rad\n"};
  for (int i{0}; i < 1'000'000; ++i) text += std::to_string(i) + "," + std::to_string(i) + ",0,0,0\n";
  put(folder / "many.csv", text);
  EXPECT_EQ(read_poses_csv(folder / "many.csv").size(), 1'000'000U);
}

struct HostileFrames : FolderTest {
  [[nodiscard]] std::unique_ptr<Recording> open() const { return open_recording({{folder.path()}, {}, "none"}); }
  void refused(const std::string& frames, std::initializer_list<std::string_view> parts) const {
    put(folder / "frames.txt", frames);
    expect_error([&] { return open(); }, parts);
  }
};

TEST_F(HostileFrames, FramesFileAsEditorsLeaveIt) {
  put_plain(folder.path());
  put(folder / "frames.txt",
      "\xef\xbb\xbf"
      "a.png\r\n\r\n  c\t\r\n");
  const auto recording{open()};
  ASSERT_EQ(recording->size(), 2U);
  EXPECT_EQ(recording->name(0), "a");
  EXPECT_EQ(recording->name(1), "c");
  EXPECT_NO_THROW(static_cast<void>(recording->load(1)));
  refused("", {"frames.txt", "names no frames", "without the file every image is taken"});
  refused("\n \n", {"frames.txt", "names no frames"});
  refused("a\nb\na.png\n", {"frames.txt", "names frame a twice"});
  refused("x\ny\n", {"frames.txt", "names no frame that is there", "first is x", "such as a"});
  refused("\xff\xfe\n", {"frames.txt", "\\xFF\\xFE"});
}

TEST_F(HostileFrames, NamesThatAreNoUtf8AreReportedAsNumbersEverywhere) {
  put_pairs(folder / "left", folder / "right", {"fr\xe4me", "new\nline"});
  put(folder / "calibration.yaml", small_yaml);
  put(folder / "poses.csv", "name,stamp_ns,x_m,y_m,yaw_rad\nfr\xe4me,5,1,0,0\n");
  const auto recording{open()};
  ASSERT_EQ(recording->size(), 2U);
  EXPECT_EQ(recording->name(0), "fr\\xE4me");
  EXPECT_EQ(recording->name(1), "new\\x0Aline");
  EXPECT_NO_THROW(static_cast<void>(recording->load(0)));
  put(folder / "frames.txt", "fr\xe4me\n");
  const auto with_pose{open_recording({{folder.path()}, {}, "file"})};
  EXPECT_EQ(with_pose->load(0).world_from_vehicle->x_m, 1);
}

TEST_F(HostileFrames, NamesThatAreTooLongForTheResults) {
  put_pairs(folder / "left", folder / "right", {std::string(100, '\xff')});
  put(folder / "calibration.yaml", small_yaml);
  expect_error([&] { return open(); }, {"400 bytes", "shorter name"});
}

TEST_F(HostileFrames, AnImageThatIsAFifoIsLeftOutAndOneThatIsGoneIsNot) {
  put_plain(folder.path());
  const auto recording{open()};
  fs::remove(folder / "left" / "b.png");
  expect_error<DeviceError>([&] { return recording->load(1); }, {"b.png", "no such file"});
  fs::create_symlink("/dev/zero", folder / "left" / "b.png");
  expect_error([&] { return recording->load(1); }, {"b.png", "device"});
  fs::create_directory(folder / "velodyne");
  fs::create_symlink("a.bin", folder / "velodyne" / "a.bin");
  EXPECT_EQ(open()->contents().frames[0].scan, folder / "velodyne" / "a.bin") << "told of when it is read";
  fs::remove_all(folder / "right");
  expect_error<DeviceError>([&] { return recording->load(2); }, {"c.png", "no such file"});
}

}  // namespace
}  // namespace stereogrid::io::testing

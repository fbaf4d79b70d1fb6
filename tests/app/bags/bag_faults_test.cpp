// SPDX-License-Identifier: Apache-2.0
//
// Bags of ROS 2 as input: their faults are reported and the rest is used; images in the encodings of cameras give the
// grid of grey images.
#include "bag_drive.hpp"

namespace stereogrid::app::testing {
namespace {

TEST_F(Bags, WhatIsWrongWithTheCalibrationIsNamed) {
  using Infos = std::function<void(CameraInfo&, CameraInfo&)>;
  const auto with = [&](const Infos& spoil) { return entries({.spoil_infos = spoil}); };
  expect_error(entries({.has_infos = false}), "/left/camera_info: there is no CameraInfo for /left/image_rect");
  expect_error(with([](CameraInfo& left, CameraInfo&) { left.k = {}, left.p = {}; }),
               "not calibrated: K[0] and P[0] are 0");
  expect_error(with([](CameraInfo&, CameraInfo& right) { right.p[3] = 0; }), "the baseline is zero");
  expect_error(with([](CameraInfo&, CameraInfo& right) { right.p[3] = 32; }), "a negative baseline");
  expect_error(with([](CameraInfo&, CameraInfo& right) { right.p[3] = std::nan(""); }), "numbers that are none");
  expect_error(with([](CameraInfo& left, CameraInfo& right) { left.width = right.width = 320; }),
               "is for images of 320×100 px, but the images have 160×100");
  expect_error(with([](CameraInfo& left, CameraInfo&) { left.width = 0; }), "is for images of 0×100 px");
  expect_error(with([](CameraInfo&, CameraInfo& right) { right.p[0] += 0.5; }), "another focal length in 'P'");
  expect_error(entries({.left = "/left/image_raw",
                        .right = "/right/image_raw",
                        .spoil_infos = [](CameraInfo& left, CameraInfo&) { left.distortion_model = "thin_prism"; }}),
               "none of plumb_bob, rational_polynomial and equidistant");
  expect_error(entries({.left = "/left/image_raw",
                        .right = "/right/image_raw",
                        .spoil_infos = [](CameraInfo&, CameraInfo& right) { right.r[0] = 2; }}),
               "/right/camera_info: has in 'R' a rotation that is not a rotation matrix");
  // a file mends all of it
  write_mcap(bag(), entries({.has_infos = false}));
  const std::string file{drive() / "calibration.yaml"};
  ASSERT_EQ(run_bag(bag(), {"--poses", "none", "--calibration", file}).exit_code, 0);
  expect_equal_runs(plain(), *folder / "out");
}

TEST_F(Bags, ThousandsOfImageTopicsAreRefusedAtOnce) {
  std::vector<Entry> many;
  Entry image{entries({}).front()};
  image.type = "sensor_msgs/msg/Image";
  for (int i{0}; i < 1001; ++i) {
    image.topic = "/c" + std::to_string(i) + "/left/image_rect";
    many.push_back(image);
  }
  expect_error(many, "has images and CameraInfo on 1001 topics (allowed up to 1000)");
}

// The right camera is turned by 3°, so that rectification moves rows.
TEST_F(Bags, ImagesThatAreRectifiedTwiceAreNoticed) {
  const double s{std::sin(0.052)};
  const double c{std::cos(0.052)};
  write_mcap(bag(),
             entries({.left = "/left/image_raw",
                      .right = "/right/image_raw",
                      .spoil_infos = [&](CameraInfo&, CameraInfo& right) { right.r = {1, 0, 0, 0, c, -s, 0, s, c}; }}));
  const Outcome outcome{run_tool({"info", bag()})};
  EXPECT_EQ(outcome.exit_code, 65) << outcome.output << outcome.errors;
  EXPECT_THAT(outcome.output + outcome.errors, HasSubstr("these are rectified already"));
}

/// An image that is not what it says.
Entry spoilt(const std::string& topic, std::int64_t stamp_ns,
             const std::function<void(messages::sensor_msgs::Image&)>& spoil) {
  messages::sensor_msgs::Image message{image_of({160, 100}, "mono8")};
  message.header = header(stamp_ns);
  spoil(message);
  return entry(topic, start_ns + stamp_ns, message);
}

TEST_F(Bags, ImagesThatCannotBeAreLeftOut) {
  const auto with_left = [](const std::function<void(messages::sensor_msgs::Image&)>& spoil) {
    std::vector<Entry> all{entries({})};
    for (Entry& one : all) {
      const bool is_second{one.topic == "/left/image_rect" && one.log_ns > start_ns + stamp_of(1) &&
                           one.log_ns < start_ns + stamp_of(2)};
      if (is_second) one = spoilt("/left/image_rect", stamp_of(1), spoil);
    }
    return all;
  };
  const std::pair<std::function<void(messages::sensor_msgs::Image&)>, const char*> ways[]{
      {[](auto& image) { image.data.resize(100); }, "160×100 px, 162 bytes a row, but has 100 bytes"},
      {[](auto& image) { image.step = 10; }, "10 bytes a row"},
      {[](auto& image) { image.encoding = "mono16", image.width = 80, image.step = 161; }, "161 bytes a row hold no"},
      {[](auto& image) { image.width = 4'000'000'000; }, "4000000000×100 px"},
      {[](auto& image) { image.height = 0; }, "160×0 px"},
      {[](auto& image) { image.encoding = "64FC1"; }, "the encoding \"64FC1\" is not read"},
      {[](auto& image) { image.width = 80; }, "160×100"}};
  for (const auto& [spoil, said] : ways) {
    write_mcap(bag(), with_left(spoil));
    const Outcome outcome{run_bag(bag())};
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    EXPECT_THAT(outcome.errors, HasSubstr(said));
    EXPECT_EQ(lines_of(*folder / "out").size(), 3U) << said;
  }
}

TEST_F(Bags, OfACutBagTheWholeChunksAreTaken) {
  write_mcap(bag(), entries({}));
  fs::resize_file(bag(), fs::file_size(bag()) * 6 / 10);
  const Outcome outcome{run_bag(bag())};
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, HasSubstr("warning"));
  const std::size_t read{lines_of(*folder / "out").size()};
  EXPECT_GT(read, 0U);
  EXPECT_LT(read, frames);
  write_db3(*folder / "cut", entries({}));
  fs::resize_file(*folder / "cut" / "bag_0.db3", 20'000);
  EXPECT_EQ(run_bag(*folder / "cut").exit_code, 65);
  std::ofstream{*folder / "empty.mcap"};
  EXPECT_EQ(run_bag(*folder / "empty.mcap").exit_code, 65);
  EXPECT_EQ(run_bag(*folder / "missing.mcap").exit_code, 65);
}

/// The pixels of a mono8 message in another encoding: `bytes_of` a grey value.
void recode(Entry& one, const std::string& encoding, std::size_t pixel_bytes,
            const std::function<std::vector<std::uint8_t>(std::uint8_t)>& bytes_of, std::size_t rows_behind = 0) {
  messages::sensor_msgs::Image message;
  messages::decode(one.data, message);
  std::vector<std::uint8_t> data;
  for (std::uint32_t v{0}; v < message.height; ++v) {
    for (std::uint32_t u{0}; u < message.width; ++u) {
      const auto bytes{bytes_of(message.data[v * message.step + u])};
      data.insert(data.end(), bytes.begin(), bytes.end());
    }
  }
  message.step = message.width * static_cast<std::uint32_t>(pixel_bytes);
  data.resize(data.size() + rows_behind * message.step, 128);
  message.encoding = encoding;
  message.data = data;
  one = entry(one.topic, one.log_ns, message);
}

TEST_F(Bags, LuminanceAndSixteenBitsGiveWhatGreyGives) {
  using Pixel = std::vector<std::uint8_t>;
  struct Coding {
    const char* name;
    std::size_t pixel_bytes;
    std::function<Pixel(std::uint8_t)> bytes_of;
    std::size_t rows_behind{0};
  };
  const auto twelve_bits = [](std::uint8_t y) {
    Pixel pixel;
    for (int i{0}; i < 3; ++i) {
      pixel.push_back(static_cast<std::uint8_t>(y << 4));
      pixel.push_back(static_cast<std::uint8_t>(y >> 4));
    }
    return pixel;
  };
  const auto only = [](std::uint8_t y) { return Pixel(1, y); };
  const auto before = [](std::uint8_t chroma) { return [chroma](std::uint8_t y) { return Pixel({y, chroma}); }; };
  const auto behind = [](std::uint8_t chroma) { return [chroma](std::uint8_t y) { return Pixel({chroma, y}); }; };
  for (const Coding& coding :
       {Coding{"yuyv", 2, before(128)}, Coding{"yuv422_yuy2", 2, before(90)}, Coding{"uyvy", 2, behind(128)},
        Coding{"yuv422", 2, behind(90)}, Coding{"YUYV", 2, before(128)}, Coding{"i420", 1, only, 50},
        Coding{"nv12", 1, only, 50}, Coding{"nv21", 1, only, 50}, Coding{"nv24", 1, only, 200},
        Coding{"rgb16", 6, twelve_bits}, Coding{"bgr16", 6, twelve_bits}}) {
    SCOPED_TRACE(coding.name);
    std::vector<Entry> all{entries({})};
    for (Entry& one : all) {
      if (one.type != CameraInfo::type_name)
        recode(one, coding.name, coding.pixel_bytes, coding.bytes_of, coding.rows_behind);
    }
    expect_plain(all);
  }
}

TEST_F(Bags, BothImagesMayBeOnOneTopic) {
  std::vector<Entry> all{entries({})};
  std::vector<Entry> joined;
  std::map<std::int64_t, messages::sensor_msgs::Image> left;
  for (const Entry& one : all) {
    if (one.type == CameraInfo::type_name) {
      joined.push_back(one);
      continue;
    }
    messages::sensor_msgs::Image message;
    messages::decode(one.data, message);
    if (one.topic.starts_with("/left")) {
      left[one.log_ns] = message;
      continue;
    }
    const messages::sensor_msgs::Image& first{left.at(one.log_ns)};
    const messages::sensor_msgs::Image& second{message};
    messages::sensor_msgs::Image both{first};
    both.data.clear();
    both.width = both.step = 2 * first.width;
    for (std::uint32_t v{0}; v < first.height; ++v) {
      for (const messages::sensor_msgs::Image* const half : {&first, &second}) {
        const auto row{half->data.begin() + v * half->step};
        both.data.insert(both.data.end(), row, row + half->width);
      }
    }
    joined.push_back(entry("/stereo/image_rect", one.log_ns, both));
  }
  expect_plain(joined);
  std::erase_if(all, [](const Entry& one) { return one.topic.starts_with("/right"); });
  expect_error(all, "has the images of one camera alone: /left/image_rect, 160×100 px");
}

}  // namespace
}  // namespace stereogrid::app::testing

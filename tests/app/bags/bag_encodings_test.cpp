// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Images of bags in the encodings of cameras: the grid is that of grey images.
#include <functional>
#include <map>

#include "bag_drive.hpp"

namespace stereogrid::app::testing {
namespace {

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
  const auto only = [](std::uint8_t y) { return Pixel{y}; };
  for (const Coding& coding :
       {Coding{"yuyv", 2,
               [](std::uint8_t y) {
                 return Pixel{y, 128};
               }},
        Coding{"yuv422_yuy2", 2,
               [](std::uint8_t y) {
                 return Pixel{y, 90};
               }},
        Coding{"uyvy", 2,
               [](std::uint8_t y) {
                 return Pixel{128, y};
               }},
        Coding{"yuv422", 2,
               [](std::uint8_t y) {
                 return Pixel{90, y};
               }},
        Coding{"YUYV", 2,
               [](std::uint8_t y) {
                 return Pixel{y, 128};
               }},
        Coding{"i420", 1, only, 50}, Coding{"nv12", 1, only, 50}, Coding{"nv21", 1, only, 50},
        Coding{"nv24", 1, only, 200}, Coding{"rgb16", 6, twelve_bits}, Coding{"bgr16", 6, twelve_bits}}) {
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

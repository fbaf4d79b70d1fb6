// SPDX-License-Identifier: Apache-2.0
//
// Bags of depth cameras: images and depth or disparities of them.
#include "depth_bags.hpp"
#include "stereogrid/io/image_file.hpp"

namespace stereogrid::app::testing {
namespace {

class BagDepth : public DepthBags {
 protected:
  static Image<float> occupancy_of_last(const fs::path& run) {
    return io::read_npz(run / "grids" / "000003.npz").at("occupancy").to_image<float>();
  }

  static void expect_equal_grids(const fs::path& a, const fs::path& b, double mean_max) {
    const Image<float> first{occupancy_of_last(a)};
    const Image<float> second{occupancy_of_last(b)};
    ASSERT_EQ(first.size(), second.size());
    double sum{0};
    for (std::size_t i{0}; i < first.size(); ++i) sum += std::abs(first.data()[i] - second.data()[i]);
    EXPECT_LE(sum / static_cast<double>(first.size()), mean_max);
  }
};

TEST_F(BagDepth, GivesTheGridOfTheSameDisparities) {
  write("/camera/left/image_rect", "/camera/disparity", disparities());
  const fs::path of_disparities{run_bag_well("of_disparities")};
  EXPECT_NEAR(json_of(of_disparities / "run.json")["rig"]["baseline_m"], rig().baseline_m, 1e-6);

  write("/camera/left/image_rect", "/camera/depth/depth_registered", metres());
  const fs::path of_depth{run_bag_well("of_depth")};
  EXPECT_EQ(json_of(of_depth / "run.json")["matcher"], "given");
  expect_equal_grids(of_disparities, of_depth, 1e-4);

  write("/camera/left/image_rect", "/camera/depth/image_rect_raw", millimetres());
  expect_equal_grids(of_disparities, run_bag_well("of_millimetres"), 2e-3);
}

// As compressed_depth_image_transport writes it: a header with two numbers, then a PNG; of floats it has a / z + b.
TEST_F(BagDepth, MayBeCompressed) {
  write("/camera/left/image_rect", "/camera/depth/image_rect_raw", metres());
  const fs::path plain_depth{run_bag_well("plain_depth")};
  constexpr float a{10100};
  constexpr float b{1 - a / 10};
  for (const bool is_of_floats : {false, true}) {
    const Image<float> depth{depth_m()};
    Image<std::uint16_t> values{depth.width(), depth.height()};
    std::transform(depth.begin(), depth.end(), values.begin(), [&](float z) {
      if (!std::isfinite(z) || z <= 0) return std::uint16_t{0};
      return static_cast<std::uint16_t>(std::lround(is_of_floats ? a / z + b : 1000 * z));
    });
    io::write_png(*folder / "depth.png", values);
    messages::sensor_msgs::CompressedImage message_of;
    message_of.format = is_of_floats ? "32FC1; compressedDepth png" : "16UC1; compressedDepth";
    message_of.data.resize(12);
    std::memcpy(&message_of.data[4], &a, sizeof a);
    std::memcpy(&message_of.data[8], &b, sizeof b);
    const std::string png{text_of(*folder / "depth.png")};
    message_of.data.insert(message_of.data.end(), png.begin(), png.end());
    write("/camera/left/image_rect", "/camera/depth/image_rect_raw/compressedDepth", message_of);
    expect_equal_grids(plain_depth, run_bag_well("compressed"), 5e-3);
  }
}

/// RVL of an image whose pixels are all there: width, height, no zeros, a run of all, and then the differences.
std::vector<std::uint8_t> rvl_of(const Image<std::uint16_t>& image) {
  std::vector<std::uint32_t> nibbles;
  const auto add = [&](std::uint32_t number) {
    for (; number > 7; number >>= 3U) nibbles.push_back((number & 7U) | 8U);
    nibbles.push_back(number);
  };
  add(0);
  add(static_cast<std::uint32_t>(image.size()));
  int last{0};
  for (const std::uint16_t value : image) {
    const int step{value - std::exchange(last, value)};
    add(step < 0 ? static_cast<std::uint32_t>(-2 * step - 1) : static_cast<std::uint32_t>(2 * step));
  }
  nibbles.resize((nibbles.size() + 7) / 8 * 8);
  std::vector<std::uint32_t> words{static_cast<std::uint32_t>(image.width()),
                                   static_cast<std::uint32_t>(image.height())};
  for (std::size_t i{0}; i < nibbles.size(); ++i) {
    if (i % 8 == 0) words.push_back(0);
    words.back() = words.back() << 4U | nibbles[i];
  }
  std::vector<std::uint8_t> bytes(12 + 4 * words.size());
  std::memcpy(&bytes[12], words.data(), 4 * words.size());
  return bytes;
}

TEST_F(BagDepth, MayBeRvl) {
  const Image<float> depth{depth_m()};
  Image<std::uint16_t> values{depth.width(), depth.height()};
  std::transform(depth.begin(), depth.end(), values.begin(), [](float z) {
    return std::isfinite(z) && z > 0 ? static_cast<std::uint16_t>(std::lround(1000 * z)) : std::uint16_t{60000};
  });
  messages::sensor_msgs::CompressedImage packed;
  packed.format = "16UC1; compressedDepth rvl";
  packed.data = rvl_of(values);
  write("/camera/left/image_rect", "/camera/depth/image_rect_raw", metres());
  const fs::path plain_depth{run_bag_well("plain_depth")};
  write("/camera/left/image_rect", "/camera/depth/image_rect_raw/compressedDepth", packed);
  expect_equal_grids(plain_depth, run_bag_well("rvl"), 5e-3);
  packed.data.resize(packed.data.size() / 2);
  write("/camera/left/image_rect", "/camera/depth/image_rect_raw/compressedDepth", packed);
  EXPECT_THAT(run_bag(bag()).errors, HasSubstr("the RVL depth is damaged"));
}

TEST_F(BagDepth, IsSaidByInfo) {
  write("/camera/infra1/image_rect_raw", "/camera/depth/image_rect_raw", millimetres(), false);
  const Outcome outcome{run_well({"info", bag()})};
  EXPECT_THAT(outcome.output, HasSubstr("depth of /camera/depth/image_rect_raw"));
  EXPECT_THAT(outcome.output, HasSubstr("a virtual one of"));
}

// A short baseline at a low resolution would put all depth into few disparities.
TEST_F(BagDepth, TakesAVirtualBaselineInsteadOfAShortOne) {
  std::vector<Entry> all;
  CameraInfo right{info(true)};
  right.p[3] /= 4;
  for (std::size_t i{0}; i < frames; ++i) {
    all.push_back(image("/camera/left/image_rect", "left", i, "mono8", 0));
    messages::sensor_msgs::Image depth{metres()};
    depth.header = header(stamp_of(i));
    all.push_back(entry("/camera/depth/depth_registered", start_ns, depth));
  }
  all.push_back(entry("/camera/left/camera_info", start_ns, info(false)));
  all.push_back(entry("/camera/right/camera_info", start_ns, right));
  write_mcap(bag(), all);
  const Outcome outcome{run_bag(bag())};
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, HasSubstr("baseline: 0.0625 m would resolve depth coarsely"));
}

TEST_F(BagDepth, OfAnotherSizeIsScaledOrRefused) {
  messages::sensor_msgs::Image half{millimetres()};
  half.width = 80;  // every second pixel and row
  half.height = 50;
  half.step = 4 * 160;
  write("/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw", half, false);
  EXPECT_EQ(run_bag(bag()).exit_code, 0);
  half.height = 40;
  write("/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw", half, false);
  const Outcome outcome{run_bag(bag())};
  EXPECT_EQ(outcome.exit_code, 65);
  EXPECT_THAT(outcome.errors, HasSubstr("depth has 80×40 px, but the images have 160×100"));
}

TEST_F(BagDepth, WithoutABaselineInTheDisparitiesIsRefused) {
  messages::stereo_msgs::DisparityImage none{disparities()};
  none.t = 0;
  write("/camera/left/image_rect", "/camera/disparity", none);
  const Outcome outcome{run_bag(bag())};
  EXPECT_EQ(outcome.exit_code, 65);
  EXPECT_THAT(outcome.errors, HasSubstr("T 0 m"));
}

TEST_F(BagDepth, OfAnotherCameraIsRefused) {
  write("/camera/color/image_raw", "/camera/depth/image_rect_raw", millimetres(), false);
  std::vector<Entry> all;
  CameraInfo other{info(false)};
  other.k[0] *= 1.4;
  for (std::size_t i{0}; i < frames; ++i) {
    all.push_back(image("/camera/color/image_raw", "left", i, "mono8", 0));
    all.push_back(entry("/camera/color/camera_info", start_ns, info(false)));
    all.push_back(entry("/camera/depth/camera_info", start_ns, other));
    messages::sensor_msgs::Image depth{millimetres()};
    depth.header = header(stamp_of(i));
    all.push_back(entry("/camera/depth/image_rect_raw", start_ns, depth));
  }
  expect_error(all, "depth is of another camera than /camera/color/image_raw");
}

TEST_F(BagDepth, VideoIsRefusedByItsTopic) {
  std::vector<Entry> all{entries({})};
  std::erase_if(all, [](const Entry& one) { return one.type != CameraInfo::type_name; });
  all.push_back({"/left/image/ffmpeg", "ffmpeg_image_transport_msgs/msg/FFMPEGPacket", start_ns, {}});
  expect_error(all, "holds video (H.264 or the like) on /left/image/ffmpeg (FFMPEGPacket)");
}

}  // namespace
}  // namespace stereogrid::app::testing

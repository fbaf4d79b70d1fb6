// SPDX-License-Identifier: Apache-2.0
//
// bare_peer pairs NAMESPACE RELIABILITY WIDTHxHEIGHT HZ SECONDS [FIRST [WORD]]: sensor_msgs/Image and CameraInfo
// of two cameras, whose images are a pattern 8 px apart, and nav_msgs/Odometry on NAMESPACE/odom at five times that
// rate, 2 m/s along x; the same on /tf, and /clock. FIRST: the first stamp, s, or "now", the default. WORD: compressed:
// images are CompressedImage; halved: every other quaternion has length 0.5; shared: both cameras' CameraInfo is on one
// topic; one_of_several: the frame of the images is NAMESPACE with "_optical" behind, and there are neither TF nor
// /clock.
#include <cmath>
#include <vector>

#include "bare_peer.hpp"
#include "ros.h"

namespace peer {
namespace {

constexpr double focal_px{100};
constexpr double baseline_m{0.25};
constexpr int disparity_px{8};

struct Size {
  int width{0};
  int height{0};
};

std_msgs_msg_dds__Header_ header_at(std::int64_t stamp_ns, const char* frame) {
  return {{static_cast<std::int32_t>(stamp_ns / 1'000'000'000), static_cast<std::uint32_t>(stamp_ns % 1'000'000'000)},
          const_cast<char*>(frame)};
}

/// A camera's topics.
struct Camera {
  dds_entity_t images;
  dds_entity_t infos;
  int shift_px;
  bool is_compressed;
  std::string frame;
};

std::vector<std::uint8_t> picture(const Size& size, int shift_px, int frame) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(size.width) * size.height);
  for (int v{0}; v < size.height; ++v) {
    for (int u{0}; u < size.width; ++u) {
      const auto at{static_cast<unsigned>((u + shift_px) * 2654435761U ^ (v * 40503U) ^ (frame * 7919U))};
      pixels[static_cast<std::size_t>(v) * size.width + u] = static_cast<std::uint8_t>(at >> 13);
    }
  }
  return pixels;
}

/// Sends the image as a PGM, one of the formats of CompressedImage.
void send_compressed(const Camera& camera, const Size& size, std::int64_t stamp_ns, std::vector<std::uint8_t>& pixels) {
  const std::string head{"P5\n" + std::to_string(size.width) + " " + std::to_string(size.height) + "\n255\n"};
  std::vector<std::uint8_t> bytes{head.begin(), head.end()};
  bytes.insert(bytes.end(), pixels.begin(), pixels.end());
  sensor_msgs_msg_dds__CompressedImage_ image{};
  image.header = header_at(stamp_ns, camera.frame.c_str());
  image.format = const_cast<char*>("pgm");
  image.data = {static_cast<std::uint32_t>(bytes.size()), static_cast<std::uint32_t>(bytes.size()), bytes.data(),
                false};
  checked(dds_write(camera.images, &image), "write");
}

void send_image(const Camera& camera, const Size& size, std::int64_t stamp_ns, std::vector<std::uint8_t>& pixels) {
  if (camera.is_compressed) return send_compressed(camera, size, stamp_ns, pixels);
  sensor_msgs_msg_dds__Image_ image{};
  image.header = header_at(stamp_ns, camera.frame.c_str());
  image.width = size.width;
  image.height = size.height;
  image.encoding = const_cast<char*>("mono8");
  image.step = size.width;
  image.data = {static_cast<std::uint32_t>(pixels.size()), static_cast<std::uint32_t>(pixels.size()), pixels.data(),
                false};
  checked(dds_write(camera.images, &image), "write");
}

void send_info(const Camera& camera, const Size& size, std::int64_t stamp_ns) {
  sensor_msgs_msg_dds__CameraInfo_ info{};
  info.header = header_at(stamp_ns, camera.frame.c_str());
  info.width = size.width;
  info.height = size.height;
  info.distortion_model = const_cast<char*>("plumb_bob");
  std::vector<double> none(5, 0.0);
  info.d = {5, 5, none.data(), false};
  const double u{size.width / 2.0}, v{size.height / 2.0};
  const double k[9]{focal_px, 0, u, 0, focal_px, v, 0, 0, 1};
  const double r[9]{1, 0, 0, 0, 1, 0, 0, 0, 1};
  const double p[12]{focal_px, 0, u, camera.shift_px == 0 ? 0 : -focal_px * baseline_m, 0, focal_px, v, 0, 0, 0, 1, 0};
  std::copy(std::begin(k), std::end(k), info.k);
  std::copy(std::begin(r), std::end(r), info.r);
  std::copy(std::begin(p), std::end(p), info.p);
  checked(dds_write(camera.infos, &info), "write");
}

void send_odometry(dds_entity_t odometry, std::int64_t stamp_ns, double seconds, double length) {
  nav_msgs_msg_dds__Odometry_ message{};
  message.header = header_at(stamp_ns, "odom");
  message.child_frame_id = const_cast<char*>("base_link");
  message.pose.pose.position.x = 2 * seconds;
  message.pose.pose.orientation.w = length;
  checked(dds_write(odometry, &message), "write");
}

void send_transform(dds_entity_t tf, std::int64_t stamp_ns, double seconds) {
  geometry_msgs_msg_dds__TransformStamped_ one{};
  one.header = header_at(stamp_ns, "odom");
  one.child_frame_id = const_cast<char*>("base_link");
  one.transform.translation.x = 2 * seconds;
  one.transform.rotation.w = 1;
  tf2_msgs_msg_dds__TFMessage_ message{};
  message.transforms._maximum = message.transforms._length = 1;
  message.transforms._buffer = &one;
  checked(dds_write(tf, &message), "write");
}

void send_clock(dds_entity_t clock, std::int64_t stamp_ns) {
  const rosgraph_msgs_msg_dds__Clock_ message{header_at(stamp_ns, "").stamp};
  checked(dds_write(clock, &message), "write");
}

/// `side` "/left" has topics below it; "/left_" beside it, with one camera_info for both sides.
Camera camera_of(dds_entity_t of, const std::string& at, const std::string& side, dds_qos_t* qos, int shift_px,
                 bool is_compressed, const std::string& frame) {
  const std::string folder{at + side + (side.ends_with('_') ? "" : "/")};
  const std::string infos{side.ends_with('_') ? at + "/camera_info" : folder + "camera_info"};
  return {is_compressed ? writer(of, sensor_msgs_msg_dds__CompressedImage__desc, folder + "image_rect/compressed", qos)
                        : writer(of, sensor_msgs_msg_dds__Image__desc, folder + "image_rect", qos),
          writer(of, sensor_msgs_msg_dds__CameraInfo__desc, infos, qos), shift_px, is_compressed, frame};
}

}  // namespace

int publish_pairs(int argc, char** argv) {
  if (argc < 7) return 1;
  const std::string at{std::string{"rt"} + argv[2]};
  Size size;
  if (std::sscanf(argv[4], "%dx%d", &size.width, &size.height) != 2) return 1;
  const double hz{std::atof(argv[5])}, seconds{std::atof(argv[6])};
  const dds_entity_t of{participant()};
  dds_qos_t* const qos{qos_of(argv[3], "volatile", 5)};
  const std::string word{argc > 8 ? argv[8] : ""};
  const bool is_compressed{word == "compressed"};
  const bool is_one_of_several{word == "one_of_several"};
  const std::string frame{is_one_of_several ? std::string{argv[2]}.substr(1) + "_optical" : "left_optical"};
  const std::string end{word == "shared" ? "_" : ""};
  const Camera left{camera_of(of, at, "/left" + end, qos, 0, is_compressed, frame)};
  const Camera right{camera_of(of, at, "/right" + end, qos, disparity_px, is_compressed, frame)};
  const dds_entity_t odometry{writer(of, nav_msgs_msg_dds__Odometry__desc, at + "/odom", qos)};
  const dds_entity_t tf{writer(of, tf2_msgs_msg_dds__TFMessage__desc, "rt/tf", qos)};
  const dds_entity_t clock{writer(of, rosgraph_msgs_msg_dds__Clock__desc, "rt/clock", qos)};
  constexpr int poses_per_frame{5};
  const auto begin{Clock::now()};
  const bool is_simulated{argc > 7 && std::string{argv[7]} != "now"};
  const std::int64_t begin_ns{is_simulated ? std::llround(std::atof(argv[7]) * 1e9) : now_ns()};
  for (int i{0}; i / poses_per_frame / hz < seconds; ++i) {
    const double now_s{i / poses_per_frame / hz + (i % poses_per_frame) / (hz * poses_per_frame)};
    std::this_thread::sleep_until(begin +
                                  std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>{now_s}));
    const std::int64_t stamp_ns{begin_ns + std::llround(now_s * 1e9)};
    if (!is_one_of_several) send_clock(clock, stamp_ns);
    send_odometry(odometry, stamp_ns, now_s, word == "halved" && i % 2 == 1 ? 0.5 : 1);
    if (!is_one_of_several) send_transform(tf, stamp_ns, now_s);
    if (i % poses_per_frame != 0) continue;
    std::vector<std::uint8_t> left_pixels{picture(size, left.shift_px, i)};
    std::vector<std::uint8_t> right_pixels{picture(size, right.shift_px, i)};
    const std::int64_t taken_ns{is_simulated ? stamp_ns : now_ns()};
    send_image(left, size, taken_ns, left_pixels);
    send_image(right, size, taken_ns, right_pixels);
    send_info(left, size, taken_ns);
    send_info(right, size, taken_ns);
    std::cout << "pair " << taken_ns << std::endl;
  }
  dds_delete(of);
  return 0;
}

}  // namespace peer

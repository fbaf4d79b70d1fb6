// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Prints where the page is, and sends it 30 frames of the built-in street as they are made, until its standard input
// ends.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>
#include <vector>

#include "connect/server_sink.hpp"
#include "connect/viewer.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

using namespace stereogrid;

std::vector<std::uint8_t> jpeg_of(const Image<std::uint8_t>& grey) {
  cv::Mat image(grey.height(), grey.width(), CV_8UC1);
  std::copy(grey.begin(), grey.end(), image.begin<std::uint8_t>());
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", image, bytes);
  return bytes;
}

/// Until `goes_on` says no, or the street ends.
void drive(messages::Sink& sink, const std::function<bool()>& goes_on) {
  const scenes::Scene scene{scenes::parse_scene("scene:street?frames=30")};
  Pipeline pipeline{Config{}, scene.rig(), {.stages = false, .horizons_s = {0.5}}};
  messages::FrameMessages messages{sink, pipeline.rig()};
  for (std::size_t i{0}; i < scene.size() && goes_on(); ++i) {
    const StereoFrame frame{scene.load(i)};
    const FrameResult& result{pipeline.process(frame)};
    const auto jpeg{jpeg_of(frame.left)};
    messages.send(result, {.stamp_ns = frame.stamp_ns,
                           .left_jpeg = [&jpeg] { return std::as_bytes(std::span{jpeg}); },
                           .latency = {{result.timing_ms.total + 5, 0, 0}},
                           .frames = static_cast<std::int64_t>(i) + 1});
  }
}

void serve() {
  server::ServerOptions options;
  options.port = 0;
  options.name = "street";
  options.http.assets = app::viewer_assets();
  server::Server server{options};
  std::printf("%s\n", server.url().c_str());
  std::fflush(stdout);
  std::atomic<bool> ends{false};
  std::jthread sender{[&] {
    app::ServerSink sink{server};
    drive(sink, [&] { return !ends; });
  }};
  while (std::getchar() != EOF) {
  }
  ends = true;
}

}  // namespace

int main() {
  try {
    serve();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "street: %s\n", error.what());
    return 70;
  }
  return 0;
}

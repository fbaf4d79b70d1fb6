// SPDX-License-Identifier: Apache-2.0
//
// A program for each component, which is made of this file with USES_<COMPONENT>: the component and the libraries that
// it needs have to link and work.
#if defined(USES_CAPTURE)
// A pipeline of GStreamer that does not exist is refused, one that does gives a frame.
#include <stereogrid/capture/camera_pair.hpp>
#include <stereogrid/error.hpp>

#include <chrono>
#include <cstdio>

using namespace stereogrid;

int main() {
  io::Calibration calibration;
  calibration.rig = {.width_px = 32, .height_px = 16, .focal_px = 30, .cx_px = 16, .cy_px = 8, .baseline_m = 1};
  try {
    static_cast<void>(capture::open_gstreamer("nosuchelement", calibration));
    return 1;
  } catch (const ConfigError& error) {  // across the library's border
    std::printf("%s\n", error.what());
  }
  const auto source{capture::open_gstreamer("videotestsrc ! video/x-raw,width=64,height=16", calibration)};
  for (int i{0}; i < 100; ++i) {
    if (source->next(std::chrono::milliseconds{100})) return 0;
  }
  std::printf("no frame: %s\n", source->fault().c_str());
  return 1;
}

#elif defined(USES_EVALUATION)
#include <stereogrid/evaluation/motion.hpp>
#include <stereogrid/evaluation/scores.hpp>

#include <cstdio>

int main() {
  namespace evaluation = stereogrid::evaluation;
  const stereogrid::GridGeometry grid{3, 0, 1, 2, 1};
  stereogrid::Rig rig;
  rig.width_px = 10;
  rig.focal_px = 10;
  evaluation::Labels labels{grid, rig, {2, 1, evaluation::labelled_free}, {2, 1}};
  labels.cells(1, 0) = evaluation::labelled_occupied;
  stereogrid::Image<float> probability{2, 1, 0.1F};
  probability(1, 0) = 0.9F;
  evaluation::Scores scores;
  scores.add("only", probability.view(), labels);
  const double auc{scores.summary({3, 20}).auc.value};
  std::printf("AUC %.1f, %zu hidden objects\n", auc, evaluation::MotionScores{}.summary().hidden_episodes);
  return auc == 1 ? 0 : 1;
}

#elif defined(USES_IO)
// Uses a part of stereogrid::io for each library that it links to: PNG, .npz, YAML and JSON have to link and work.
#include <stereogrid/io/config_file.hpp>
#include <stereogrid/io/file.hpp>
#include <stereogrid/io/image_file.hpp>
#include <stereogrid/io/npz.hpp>

#include <cstdio>
#include <vector>

int main() {
  stereogrid::Image<std::uint8_t> image{7, 5, 100};
  image(3, 2) = 200;
  stereogrid::io::write_png("image.png", image);
  const bool png{stereogrid::io::read_grey("image.png") == image};

  const std::vector<stereogrid::io::NpzArray> arrays{{"image", image}};
  stereogrid::io::write_npz("image.npz", arrays);
  const bool npz{stereogrid::io::read_npz("image.npz").at("image").to_image<std::uint8_t>() == image};

  stereogrid::Config config;
  config.grid.length_m = 33;
  stereogrid::io::write_file("config.yaml", stereogrid::io::to_yaml(config));
  stereogrid::Config read;
  stereogrid::io::load_config("config.yaml", read);
  const bool yaml{read.grid.length_m == 33};
  const bool json{stereogrid::io::to_json(read).find("33") != std::string::npos};

  std::printf("png %d, npz %d, yaml %d, json %d\n", png, npz, yaml, json);
  return png && npz && yaml && json ? 0 : 1;
}

#elif defined(USES_MCAP)
// Writes and reads a file with each compression, and opens a .db3: zstd, lz4, zlib and SQLite have to link and work.
#include <stereogrid/error.hpp>
#include <stereogrid/mcap/bag.hpp>
#include <stereogrid/mcap/writer.hpp>

#include <cstdio>
#include <fstream>
#include <span>
#include <string>

using namespace stereogrid;

int main() {
  bool fine{true};
  for (const auto compression : {mcap::Compression::none, mcap::Compression::lz4, mcap::Compression::zstd}) {
    const std::string text(1000, 'x');
    {
      mcap::Writer writer{"a.mcap", {.compression = compression}};
      writer.write(writer.add_channel("/x", "cdr", 0, {}), 1, 5, 5, std::as_bytes(std::span{text}));
      writer.close();
    }
    const auto bag{mcap::open_bag("a.mcap")};
    const auto cursor{bag->messages({})};
    const mcap::Message* const message{cursor->next()};
    fine = fine && message != nullptr && message->data.size() == text.size() && bag->topics()[0].name == "/x";
  }
  std::ofstream{"a.db3", std::ios::binary} << std::string{"SQLite format 3\0", 16};
  try {
    static_cast<void>(mcap::open_bag("a.db3"));
    fine = false;
  } catch (const InputError& error) {  // across the library's border
    std::printf("%s\n", error.what());
  }
  return fine ? 0 : 1;
}

#elif defined(USES_MESSAGES)
#include <stereogrid/messages/cdr.hpp>
#include <stereogrid/messages/definition.hpp>
#include <stereogrid/messages/frame_messages.hpp>
#include <stereogrid/messages/nav_msgs.hpp>

#include <cstdio>

namespace messages = stereogrid::messages;

class Counter : public messages::Sink {
 public:
  std::uint32_t add(const messages::Channel& /*channel*/) override { return 0; }
  [[nodiscard]] bool wants(std::uint32_t /*channel*/) const override { return true; }
  void send(std::uint32_t /*channel*/, std::int64_t /*stamp_ns*/, std::span<const std::byte> /*cdr*/) override {
    ++count;
  }
  int count{0};
};

int main() {
  Counter counter;
  const stereogrid::Rig rig{200, 100, 100, 99.5, 49.5, 0.5};
  stereogrid::FrameResult result;
  result.vehicle.geometry = result.world.geometry = {0, -1, 1, 2, 2};
  for (auto* const layer : {&result.observed, &result.vehicle.occupancy, &result.world.occupancy, &result.world.moving,
                            &result.world.velocity_x, &result.world.velocity_y, &result.world.age_s}) {
    *layer = {2, 2};
  }
  messages::FrameMessages{counter, rig}.send(result, {});

  messages::nav_msgs::OccupancyGrid grid;
  grid.data = {100, -1};
  messages::CdrWriter writer;
  messages::nav_msgs::OccupancyGrid again;
  messages::decode(writer.encode(grid), again);
  std::printf("%d messages, and one read again:\n%s", counter.count,
              messages::definition_of<messages::nav_msgs::OccupancyGrid>().data());
  return counter.count > 8 && again.data == grid.data ? 0 : 1;
}

#elif defined(USES_SCENES)
#include <stereogrid/pipeline.hpp>
#include <stereogrid/scenes/scene.hpp>

#include <cstdio>

int main() {
  const stereogrid::scenes::Scene scene{stereogrid::scenes::parse_scene("scene:empty?frames=1&width=256&height=160")};
  stereogrid::Pipeline pipeline{stereogrid::preset("default"), scene.rig()};
  const stereogrid::FrameResult& result{pipeline.process(scene.load(0))};
  std::printf("road matched in %.0f %% of the pixels\n", 100 * result.road_density);
  return result.road_density > 0.05 ? 0 : 1;
}

#elif defined(USES_SERVER)
// Listens on a free port, and again on the same one, which is refused.
#include <stereogrid/error.hpp>
#include <stereogrid/server/server.hpp>

#include <cstdio>

using namespace stereogrid;

int main() {
  server::ServerOptions options;
  options.port = 0;
  const server::Server server{options};
  options.port = server.port();
  try {
    const server::Server another{options};
  } catch (const DeviceError& error) {  // across the library's border
    std::printf("%s\n", error.what());
    return 0;
  }
  return 1;
}

#endif

// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>

#include "../temporary_folder.hpp"
#include "cli/config_options.hpp"
#include "connect/page.hpp"
#include "run/run.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"
#include "stereogrid/server/server.hpp"
#include "view/playback.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

Playback four_frames() {
  return Playback{{5'000'000'000, 5'100'000'000, 5'200'000'000, 5'300'000'000}};
}

TEST(UnreadParameters, HaveAReason) {
  const Config standard{preset("default")};
  const auto why = [&](const char* key, const InputUse& input = {}) { return why_unread(standard, key, input); };
  for (const char* key : {"paper.tau_obstacle", "paper.left_border", "u_disparity.tau_obstacle"}) {
    EXPECT_NE(why(key).find("projection.model=bins"), std::string::npos) << key;
    EXPECT_EQ(why_unread(preset("paper"), key, {}), "") << key;
  }
  EXPECT_EQ(why("u_disparity.obstacle_height_m"), "");
  EXPECT_EQ(why("matching.external_sigma_px"), "disparities or depth as input");
  EXPECT_EQ(why("matching.external_sigma_px", {true, false}), "");
  EXPECT_EQ(why("matching.external_sigma_per_m"), "disparities or depth as input");
  EXPECT_EQ(why("filter.scene_flow", {true, false}), "");
  EXPECT_EQ(why("matching.uniqueness"), "");
  EXPECT_EQ(why("matching.uniqueness", {true, false}), "right images as input");
  EXPECT_EQ(why("fusion.stereo_confidence", {false, true}), "");
  EXPECT_NE(why("fusion.stereo_confidence"), "");
  EXPECT_EQ(why("vehicle.step_max_m"), "");
  EXPECT_EQ(why_unread(preset("paper"), "vehicle.step_max_m", {}), "ground.model=terrain");
}

TEST(Playback, StandsAtTheFirstFrameUntilSomebodyWantsAnother) {
  Playback playback{four_frames()};
  EXPECT_EQ(playback.wait(10ms), PlaybackState{});
  EXPECT_EQ(playback.wait(10ms), PlaybackState{});
  EXPECT_EQ(playback.set({"player.frame", std::int64_t{2}}), std::nullopt);
  const auto before{steady_clock::now()};
  EXPECT_EQ(playback.wait(10s).frame, 2);
  EXPECT_LT(steady_clock::now() - before, 5s);
}

TEST(Playback, GoesToTheLastFrameThatIsNotLater) {
  Playback playback{four_frames()};
  for (const auto& [time_s, frame] : {std::pair{0.15, 1}, {0.2, 2}, {-1.0, 0}, {100.0, 3}, {0.0, 0}}) {
    EXPECT_EQ(playback.set({"player.time_s", time_s}), std::nullopt);
    EXPECT_EQ(playback.wait(10s).frame, frame) << time_s;
  }
}

TEST(Playback, StampsOfAnySizeAreSought) {
  constexpr std::uint64_t first_ns{std::uint64_t{1} << 63};
  Playback playback{{first_ns, std::numeric_limits<std::uint64_t>::max()}};
  for (const auto& [time_s, frame] : {std::pair{1e308, 1}, {9e9, 0}, {-1e308, 0}, {9223372036.854775807, 1}}) {
    EXPECT_EQ(playback.set({"player.time_s", time_s}), std::nullopt);
    EXPECT_EQ(playback.wait(10s).frame, frame) << time_s;
  }
  EXPECT_EQ(playback.set({"player.frame", std::int64_t{0}}), std::nullopt);
  EXPECT_EQ(playback.set({"player.speed", 0.05}), std::nullopt);
  EXPECT_EQ(playback.set({"player.playing", true}), std::nullopt);
  EXPECT_EQ(playback.wait(0ms).frame, 0);
  EXPECT_EQ(playback.wait(50ms).frame, 0) << "the next one is due in thousands of years";
}

TEST(Playback, PlaysAtItsSpeedAndStandsAtTheEnd) {
  Playback playback{four_frames()};
  EXPECT_EQ(playback.set({"player.speed", 0.5}), std::nullopt);
  EXPECT_EQ(playback.set({"player.playing", true}), std::nullopt);
  const auto before{steady_clock::now()};
  PlaybackState state{playback.wait(10s)};
  EXPECT_EQ(state.frame, 0);
  for (int frame{1}; frame < 4; ++frame) {
    state = playback.wait(10s);
    EXPECT_EQ(state.frame, frame);
    EXPECT_EQ(state.playing, frame < 3);
  }
  EXPECT_GE(steady_clock::now() - before, 590ms);  // 0.3 s at half the speed
  EXPECT_EQ(playback.set({"player.playing", true}), std::nullopt);
  EXPECT_EQ(playback.wait(10s), (PlaybackState{0, true, 0.5}));  // from the beginning
}

TEST(Playback, RefusesWhatCannotBe) {
  Playback playback{four_frames()};
  for (const std::int64_t frame : {-1, 4}) {
    EXPECT_EQ(playback.set({"player.frame", frame}), "frames go from 0 to 3.");
  }
  for (const double speed : {0.0, -1.0, 21.0})
    EXPECT_EQ(playback.set({"player.speed", speed}), "speeds go from 0.05 to 20.");
  EXPECT_EQ(playback.set({"player.frames", std::int64_t{5}}), "it can only be read.");
  EXPECT_EQ(playback.wait(10ms), PlaybackState{});
}

/// A run of two frames of a small scene in a folder.
io::RunReader small_run(const std::filesystem::path& folder, const std::function<void(RunOptions&)>& change = {}) {
  RunOptions options;
  options.input.paths = {"scene:crossing?frames=2&width=160&height=100"};
  options.folder = folder.string();
  if (change) change(options);
  EXPECT_EQ(run(options), 0);
  return io::RunReader{folder};
}

TEST(StoredFrames, AreTheResultsThatWroteThem) {
  const tests::TemporaryFolder folder;
  const io::RunReader stored{small_run(folder / "run")};
  const scenes::Scene scene{scenes::parse_scene("crossing?frames=2&width=160&height=100")};
  Pipeline pipeline{preset("default"), scene.rig()};
  for (std::size_t i{0}; i < 2; ++i) {
    const FrameResult read{stored_result(stored, stored.frames()[i])};
    const FrameResult& made{pipeline.process(scene.load(i))};
    EXPECT_EQ(read.observed, made.observed);
    EXPECT_EQ(read.vehicle.occupancy, made.vehicle.occupancy);
    EXPECT_EQ(read.world.geometry, made.world.geometry);
    EXPECT_EQ(read.world.occupancy, made.world.occupancy);
    EXPECT_EQ(read.world.velocity_y, made.world.velocity_y);
    EXPECT_EQ(read.world.age_s, made.world.age_s);
    EXPECT_EQ(read.elevation_m.size(), made.elevation_m.size());
    EXPECT_EQ(read.world_elevation_m.size(), made.world_elevation_m.size());
    EXPECT_EQ(read.world_terrain, made.world_terrain);
    EXPECT_EQ(read.obstacles.size(), made.obstacles.size());
  }
}

TEST(StoredFrames, OfCompactRunsHaveAWorldGridSampledFromTheVehicles) {
  const tests::TemporaryFolder folder;
  const io::RunReader stored{small_run(folder / "run", [](RunOptions& options) {
    options.compact = true;
    options.layers = {"occupancy"};
  })};
  const FrameResult read{stored_result(stored, stored.frames()[1])};
  std::size_t compared{0};
  const GridGeometry& vehicle{read.vehicle.geometry};
  for (const auto [ix, iy] : raster(vehicle.nx, vehicle.ny)) {
    const auto cell{read.world.geometry.cell_at(read.world_from_vehicle * vehicle.centre(ix, iy))};
    ASSERT_TRUE(cell);
    const Point2 there{inverse(read.world_from_vehicle) * read.world.geometry.centre(cell->ix, cell->iy)};
    const auto back{vehicle.cell_at(there)};
    if (!back) continue;
    EXPECT_EQ(read.world.occupancy(cell->ix, cell->iy), read.vehicle.occupancy(back->ix, back->iy));
    compared += read.vehicle.occupancy(back->ix, back->iy) > 0.6F ? 1 : 0;
  }
  EXPECT_GT(compared, 10U);
  for (const float observed : read.observed) EXPECT_EQ(observed, 0.5F);
}

/// Keeps the topics, and the stamps sent on each.
struct SentTopics final : messages::Sink {
  std::uint32_t add(const messages::Channel& channel) override {
    const auto found{std::ranges::find(topics, channel.topic)};
    if (found != topics.end()) return static_cast<std::uint32_t>(found - topics.begin());
    topics.push_back(channel.topic);
    stamps.emplace_back();
    return static_cast<std::uint32_t>(topics.size() - 1);
  }
  bool wants(std::uint32_t) const override { return true; }
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte>) override {
    stamps.at(channel).push_back(stamp_ns);
  }
  const std::vector<std::int64_t>& of(const std::string& topic) {
    return stamps.at(static_cast<std::size_t>(std::ranges::find(topics, topic) - topics.begin()));
  }

  std::vector<std::string> topics;
  std::vector<std::vector<std::int64_t>> stamps;
};

TEST(SideBySide, RunsFollowTheFirstByStamp) {
  const tests::TemporaryFolder folder;
  static_cast<void>(small_run(folder / "a" / "run"));
  static_cast<void>(small_run(folder / "b" / "run", [](RunOptions& options) { options.frames = "0:0"; }));
  const std::vector<std::string> runs{folder / "a" / "run", folder / "b" / "run"};
  EXPECT_EQ(recording_names(runs), "run, run_2");
  const auto frames{played_frames(runs)};
  ASSERT_EQ(frames->stamps_ns().size(), 2U);
  SentTopics sink;
  for (const std::size_t frame : {0U, 1U}) frames->send(frame, sink);
  for (const std::string& topic : sink.topics) EXPECT_THAT(topic, testing::MatchesRegex("/run(_2)?/.*"));
  EXPECT_THAT(sink.of("/run/stereo_grid/occupancy_grid"), testing::ElementsAre(0, 100'000'000));
  EXPECT_THAT(sink.of("/run_2/stereo_grid/occupancy_grid"), testing::ElementsAre(0, 0));
  EXPECT_THROW(static_cast<void>(played_frames(std::vector<std::string>{runs[0], folder / "none"})), InputError);
}

TEST(SideBySide, OneRunHasItsOwnTopics) {
  const tests::TemporaryFolder folder;
  static_cast<void>(small_run(folder / "run"));
  SentTopics sink;
  played_frames(std::vector<std::string>{folder / "run"})->send(0, sink);
  EXPECT_THAT(sink.topics, testing::Contains("/stereo_grid/occupancy_grid"));
}

/// Keeps all messages.
struct SentBytes final : messages::Sink {
  std::uint32_t add(const messages::Channel&) override { return 0; }
  bool wants(std::uint32_t) const override { return true; }
  void send(std::uint32_t, std::int64_t, std::span<const std::byte> cdr) override {
    bytes.append(reinterpret_cast<const char*>(cdr.data()), cdr.size());
  }
  std::string bytes;
};

TEST(StoredFrames, AreSentInAnyOrder) {
  const tests::TemporaryFolder folder;
  static_cast<void>(small_run(folder / "run", [](RunOptions& options) { options.pictures = "png"; }));
  const auto frames{stored_frames(folder / "run")};
  EXPECT_EQ(frames->stamps_ns().size(), 2U);
  EXPECT_LT(frames->stamps_ns()[0], frames->stamps_ns()[1]);
  std::vector<std::string> sent;
  SentBytes publisher;
  for (const std::size_t frame : {0U, 1U, 0U}) {
    publisher.bytes.clear();
    frames->send(frame, publisher);
    sent.push_back(publisher.bytes);
  }
  EXPECT_GT(sent[0].size(), 1000U);
  EXPECT_NE(sent[0], sent[1]);
  EXPECT_EQ(sent[0], sent[2]);
  EXPECT_THROW((void)stored_frames(folder / "nothing"), InputError);
}

TEST(ListenAddress, IsAnAddressAndAPort) {
  const auto expect = [](const char* text, const char* address, int port) {
    const ListenAddress read{listen_address_of(text)};
    EXPECT_EQ(read.address, address) << text;
    EXPECT_EQ(read.port, port) << text;
  };
  expect("127.0.0.1:8765", "127.0.0.1", 8765);
  expect("0.0.0.0:0", "0.0.0.0", 0);
  expect(":0", "127.0.0.1", 0);
  expect("[::1]:80", "::1", 80);
  expect("localhost:65535", "localhost", 65535);
  for (const char* wrong : {"", "8765", "127.0.0.1", "127.0.0.1:", "::1:80", "a:65536", "a:-1", "a:1x", "a: 1"}) {
    EXPECT_THROW((void)listen_address_of(wrong), ConfigError) << wrong;
  }
}

}  // namespace
}  // namespace stereogrid::app

// SPDX-License-Identifier: Apache-2.0
//
// stereogrid live, and run --view, as programs.
#include <arpa/inet.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <regex>

#include "stereogrid/mcap/bag.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using Live = FolderTest;

using namespace std::chrono_literals;

/// A socket of 127.0.0.1 at `port`, or any; -1: not to be had.
int socket_at(std::uint16_t& port, int (*use)(int, const sockaddr*, socklen_t)) {
  const int made{socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* const any{reinterpret_cast<sockaddr*>(&address)};
  socklen_t size{sizeof address};
  if (use(made, any, size) != 0) {
    close(made);
    return -1;
  }
  getsockname(made, any, &size);
  if (port == 0) port = ntohs(address.sin_port);
  return made;
}

std::uint16_t free_port() {
  std::uint16_t port{0};
  close(socket_at(port, &::bind));
  return port;
}

/// The whole response; "": no server.
std::string get(std::uint16_t port, const std::string& path) {
  const int made{socket_at(port, &::connect)};
  if (made < 0) return "";
  const std::string request{"GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
                            "\r\nConnection: close\r\n\r\n"};
  std::string answer;
  if (write(made, request.data(), request.size()) == static_cast<ssize_t>(request.size())) {
    std::array<char, 4096> part{};
    for (ssize_t got{1}; got > 0;) {
      got = read(made, part.data(), part.size());
      if (got > 0) answer.append(part.data(), static_cast<std::size_t>(got));
    }
  }
  close(made);
  return answer;
}

bool becomes(const std::function<bool()>& is_true) {
  const auto until{std::chrono::steady_clock::now() + 60s};
  while (std::chrono::steady_clock::now() < until) {
    if (is_true()) return true;
    std::this_thread::sleep_for(20ms);
  }
  return false;
}

std::string at(std::uint16_t port) {
  return "127.0.0.1:" + std::to_string(port);
}

fs::path small_calibration(const TemporaryFolder& folder) {
  fs::path file{folder / "camera.yaml"};
  std::ofstream{file} << "image: {width_px: 192, height_px: 128}\nmount: {camera_height_m: 1.2}\n"
                         "focal_px: 160\ncx_px: 95.5\ncy_px: 63.5\nbaseline_m: 0.12\n";
  return file;
}

TEST_F(Live, PlaysARecordingAndEndsWithIt) {
  const Outcome done{run_well({"live", small_scene("street", "&frames=8"), "--listen", ":0", "--mcap",
                               folder / "live.mcap", "--mcap-topics", "occupancy_grid,status"})};
  EXPECT_THAT(done.output, HasSubstr("open http://127.0.0.1:"));
  EXPECT_THAT(done.errors, HasSubstr("latency"));
  const auto bag{mcap::open_bag(folder / "live.mcap")};
  ASSERT_EQ(bag->topics().size(), 2U);
  EXPECT_GE(bag->topics()[0].message_count, 1U);
  EXPECT_LE(bag->topics()[0].message_count, 8U);
}

TEST_F(Live, PlaysADriveWithTwoCameras) {
  const std::string scene{"scene:around?cameras=2&turn_deg=180&width=192&height=120&focal=96&frames=6"};
  const Outcome done{run_well({"live", scene, "--listen", ":0"})};
  EXPECT_THAT(done.errors, HasSubstr("camera1: directions of the camera's view lie outside of the grid"));
}

// As systemd does for a service of Type=notify with a watchdog.
TEST_F(Live, NotifiesAServiceManagerThatItIsAlive) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path{folder / "notify"};
  ASSERT_LT(path.size(), sizeof address.sun_path);
  std::copy(path.begin(), path.end(), address.sun_path);
  const int manager{socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  ASSERT_EQ(bind(manager, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  const timeval patience{20, 0};
  setsockopt(manager, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  const auto notified{[&] {
    std::array<char, 100> words{};
    return recv(manager, words.data(), words.size(), 0) > 0 ? std::string{words.data()} : "";
  }};
  setenv("NOTIFY_SOCKET", path.c_str(), 1);
  Process live{{"live", small_scene("street", "&frames=8"), "--loop", "--listen", ":0"}};
  unsetenv("NOTIFY_SOCKET");
  EXPECT_EQ(notified(), "READY=1");
  for (int i{0}; i < 3; ++i) EXPECT_EQ(notified(), "WATCHDOG=1");
  live.send(SIGINT);
  EXPECT_EQ(live.wait(), 0);
  close(manager);
}

TEST_F(Live, ShowsAnotherPresetBeside) {
  const std::uint16_t port{free_port()};
  Process live{{"live", small_scene("street", "&frames=8"), "--loop", "--beside", "paper", "--listen", at(port)}};
  ASSERT_TRUE(becomes([&] { return get(port, "/healthz").find("200 OK") != std::string::npos; }));
  live.send(SIGINT);
  EXPECT_EQ(live.wait(), 0);
}

/// A program that writes a drive's images at 10 Hz, each camera's to a socket of `folder`, over and over.
Process camera_writer(const fs::path& drive, const TemporaryFolder& folder) {
  Words words{"-q"};
  for (const char* side : {"left", "right"}) {
    fs::remove(folder / side);
    std::istringstream pipeline{
        "loop=true caps=image/png,framerate=10/1 ! pngdec ! videoconvert ! "
        "video/x-raw,format=GRAY8 ! shmsink wait-for-connection=false"};
    words.insert(words.end(), {"multifilesrc", "location=" + (drive / side / "%06d.png").string()});
    words.insert(words.end(), std::istream_iterator<std::string>{pipeline}, {});
    words.push_back("socket-path=" + (folder / side).string());
  }
  return {"gst-launch-1.0", words};
}

std::string shared_camera(const TemporaryFolder& folder, const std::string& side) {
  return "shmsrc is-live=true do-timestamp=true socket-path=" + (folder / side).string() +
         " ! video/x-raw,format=GRAY8,width=160,height=100,framerate=10/1 ! appsink name=" + side + " ";
}

/// The pipelines that docs/live.md names.
TEST_F(Live, ShowsAnotherProgramsCamerasAndSaysWhenTheyGo) {
  if (shell("gst-inspect-1.0 --exists shmsink 2>/dev/null") != 0) {
    GTEST_SKIP() << "needs Debian's gstreamer1.0-tools and gstreamer1.0-plugins-bad";
  }
  const fs::path drive{folder / "drive"};
  run_well({"simulate", small_scene("street", "&frames=6"), "--out", drive});
  const std::uint16_t port{free_port()};
  Process live{{"live", "gst:" + shared_camera(folder, "left") + shared_camera(folder, "right"), "--poses", "none",
                "--calibration", drive / "calibration.yaml", "--listen", at(port)}};
  const auto health_has = [&](const char* part) { return get(port, "/healthz").find(part) != std::string::npos; };
  ASSERT_TRUE(becomes([&] { return health_has("Could not open socket"); }));
  for (int round{0}; round < 2; ++round) {
    {
      const Process writer{camera_writer(drive, folder)};
      EXPECT_TRUE(becomes([&] { return health_has("200 OK"); })) << round;
      // zero obstacles if left and right are exchanged
      const std::regex some{"\nstereogrid_obstacles [1-9]"};
      EXPECT_TRUE(becomes([&] { return std::regex_search(get(port, "/metrics"), some); })) << round;
    }
    EXPECT_TRUE(becomes([&] { return health_has("503"); })) << round;
  }
  live.send(SIGTERM);
  EXPECT_EQ(live.wait(), 0);
}

TEST_F(Live, ServesThePageAndMetrics) {
  const std::uint16_t port{free_port()};
  Process live{{"live", small_scene("street", "&frames=8"), "--loop", "--listen", at(port)}};
  ASSERT_TRUE(becomes([&] { return get(port, "/healthz").find("200 OK") != std::string::npos; }));
  EXPECT_THAT(get(port, "/metrics"), AllOf(HasSubstr("stereogrid_frames_total"),
                                           HasSubstr("stereogrid_latency_seconds"), HasSubstr("stage=\"match\"")));
  EXPECT_THAT(get(port, "/"), HasSubstr("<title>stereogrid</title>"));
  live.send(SIGINT);
  EXPECT_EQ(live.wait(), 0);
}

TEST_F(Live, ShowsARun) {
  const std::uint16_t port{free_port()};
  Process run{{"run", small_scene("street", "&frames=1000"), "--out", folder / "run", "--view", "--listen", at(port)}};
  EXPECT_TRUE(becomes([&] { return get(port, "/healthz").find("200 OK") != std::string::npos; }));
  EXPECT_THAT(get(port, "/metrics"), HasSubstr("stereogrid_frames_total"));
  run.send(SIGINT);
  EXPECT_EQ(run.wait(), 130);
}

TEST_F(Live, RefusesWhatCannotBe) {
  const std::string calibration{small_calibration(folder).string()};
  const auto expect_error = [](Words words, int code, const std::string& part) {
    words.insert(words.begin(), "live");
    words.insert(words.end(), {"--listen", ":0"});
    EXPECT_THAT(errors_of(code, words), HasSubstr(part));
  };
  expect_error({"gst:videotestsrc"}, 64, "--calibration FILE");
  expect_error({"gst:nosuch ! appsink", "--calibration", calibration}, 64, "no element");
  expect_error({"/dev/video97", "--calibration", calibration, "--poses", "poses.txt"}, 64, "--poses of a camera");
  expect_error({"/dev/video97", "--calibration", calibration, "--speed", "2"}, 64, "--speed is of recordings");
  expect_error({"/dev/video97", "--calibration", calibration, "--loop"}, 64, "--loop is of recordings");
  expect_error({folder / "none"}, 65, "no such file");
  expect_error({small_scene("street", ""), "--speed", "0"}, 64, "--speed");
}

TEST_F(Live, ListensOnlyWhereSomethingIsShown) {
  EXPECT_THAT(errors_of(64, {"run", small_scene("street", "&frames=1"), "--out", "nowhere", "--listen", ":0"}),
              HasSubstr("--view"));
}

TEST_F(Live, CountsAFrameThatCannotBeReadOnce) {
  run_well({"simulate", small_scene("street", "&frames=6"), "--out", folder / "drive"});
  std::ofstream{folder / "drive/left/000002.png"} << "damaged";
  const Outcome done{run_well({"live", folder / "drive", "--listen", ":0"})};
  EXPECT_THAT(done.errors, HasSubstr("cannot be used: 1"));
}

}  // namespace
}  // namespace stereogrid::app::testing

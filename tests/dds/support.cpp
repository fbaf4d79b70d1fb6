// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

#include <dlfcn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/definition.hpp"

namespace stereogrid::dds::testing {
namespace {

/// A domain from 1 to 100 that no other process of tests holds, until this process ends: an abstract socket bears its
/// number.
int own_domain() {
  for (int tried{0}; tried < 100; ++tried) {
    const int domain{1 + (getpid() + tried) % 100};
    const std::string name{"stereogrid-domain-" + std::to_string(domain)};
    sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
    std::memcpy(address.sun_path + 1, name.data(), name.size());
    const int held{socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
    const auto size{static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size())};
    if (bind(held, reinterpret_cast<const sockaddr*>(&address), size) == 0) return domain;
    close(held);
  }
  throw std::runtime_error{"100 processes of tests hold all domains"};
}

/// For each test this machine alone, without multicast, and a domain of this process and its peers.
class Alone final : public ::testing::EmptyTestEventListener {
 public:
  void OnTestStart(const ::testing::TestInfo& /*test*/) override {
    static const int domain{own_domain()};
    setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), 1);
    setenv("CYCLONEDDS_URI",
           "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>"
           "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
           "<MaxAutoParticipantIndex>9</MaxAutoParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers>"
           "</Discovery></Domain></CycloneDDS>",
           1);
    for (const char* name : {"ROS_LOCALHOST_ONLY", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_DISTRO"})
      unsetenv(name);
  }
};

[[maybe_unused]] const bool is_alone{[] {
  ::testing::UnitTest::GetInstance()->listeners().Append(new Alone);
  return true;
}()};

const Library& library() {
  void* const opened{dlopen(STEREOGRID_DDS_LIBRARY, RTLD_NOW | RTLD_LOCAL)};
  void* const symbol{opened == nullptr ? nullptr : dlsym(opened, library_function)};
  if (symbol == nullptr) throw std::runtime_error{dlerror()};
  return *reinterpret_cast<const Library* (*)()>(symbol)();
}

}  // namespace

Peer::Peer(const std::string& words) : pipe_{popen(words.c_str(), "re")} {}

Peer::~Peer() {
  if (pipe_ != nullptr) rest();
}

std::string Peer::line() {
  char* text{nullptr};
  std::size_t size{0};
  const ssize_t length{getline(&text, &size, pipe_)};
  std::string line{length > 0 ? std::string{text, static_cast<std::size_t>(length)} : ""};
  free(text);
  if (line.ends_with('\n')) line.pop_back();
  return line;
}

std::vector<std::string> Peer::rest() {
  std::vector<std::string> lines;
  for (std::string one{line()}; !one.empty(); one = line()) lines.push_back(one);
  const int status{pclose(std::exchange(pipe_, nullptr))};
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return lines;
}

std::string all_of(Peer& peer) {
  std::string text;
  for (const std::string& line : peer.rest()) text += line + "\n";
  return text;
}

std::string tool(const std::string& words, double seconds) {
  return "exec timeout --foreground -s INT " + std::to_string(seconds) + " " STEREOGRID_TOOL " " + words + " 2>&1";
}

std::string bare_peer(const std::string& words) {
  return "exec timeout 60 " STEREOGRID_BARE_PEER " " + words;
}

std::function<void(const std::string&)> Warned::taker() {
  return [state = state_](const std::string& sentence) {
    const std::scoped_lock lock{state->mutex};
    state->sentences.push_back(sentence);
  };
}

std::vector<std::string> Warned::sentences() const {
  const std::scoped_lock lock{state_->mutex};
  return state_->sentences;
}

std::unique_ptr<Node> open_node(const NodeOptions& options) {
  return library().open(options);
}

void check_options(const NodeOptions& options) {
  library().check(options);
}

bool becomes(const std::function<bool()>& is_true) {
  const auto until{std::chrono::steady_clock::now() + std::chrono::seconds{20}};
  while (std::chrono::steady_clock::now() < until) {
    if (is_true()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
  }
  return false;
}

messages::nav_msgs::OccupancyGrid some_grid(std::uint32_t width, std::uint32_t height, int offset) {
  messages::nav_msgs::OccupancyGrid grid;
  grid.header.stamp = {1'700'000'000 + offset, 123'456'789};
  grid.header.frame_id = "odom";
  grid.info.resolution = 0.25F;
  grid.info.width = width;
  grid.info.height = height;
  grid.info.origin.position = {-12.5, 3.75, 0};
  for (std::size_t i{0}; i < std::size_t{width} * height; ++i) {
    grid.data.push_back(static_cast<std::int8_t>((7 * i + offset) % 101));
  }
  return grid;
}

std::string line_of(const messages::nav_msgs::OccupancyGrid& grid) {
  std::uint32_t sum{0};
  for (std::size_t i{0}; i < grid.data.size(); ++i) sum += static_cast<std::uint32_t>((i + 1) * grid.data[i]);
  std::ostringstream line;
  line << "grid " << grid.header.stamp.sec * 1'000'000'000LL + grid.header.stamp.nanosec << ' ' << grid.header.frame_id
       << ' ' << grid.info.width << 'x' << grid.info.height << ' ' << grid.info.resolution << ' '
       << grid.info.origin.position.x << ' ' << grid.info.origin.position.y << ' ' << grid.info.origin.orientation.w
       << " sum " << sum;
  return line.str();
}

void send(messages::Sink& sink, std::uint32_t channel, const messages::nav_msgs::OccupancyGrid& grid) {
  messages::CdrWriter writer;
  sink.send(channel, 0, writer.encode(grid));
}

messages::Channel grid_channel(const std::string& topic, bool is_latched) {
  using messages::nav_msgs::OccupancyGrid;
  return {topic, OccupancyGrid::type_name, messages::definition_of<OccupancyGrid>(), is_latched};
}

}  // namespace stereogrid::dds::testing

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Endurance test: takes frames (first argument, default 100000) through one pipeline for each source, in turns: a
// built-in scene, and the recordings that the other arguments name. Faults are injected: a gap, a clock that steps
// back, a frame of another size, a black one, a pose that jumps or is missing, external disparities. Prints a table of
// memory and time along the way. Exit status 1: an invalid value (NaN, a denormal number, a probability outside 0 … 1,
// an id used again), allocated memory that grows by more than 0.1 % after the first tenth, resident memory by more than
// 5 % (what was reserved at construction is touched bit by bit), or frames that take more than 10 % longer than those
// of pipelines just made, in turns with them after the last tenth: machines are noisy.
#include <malloc.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "machine.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

using namespace stereogrid;

constexpr std::size_t frames_kept{40};
constexpr std::size_t frames_in_turn{100};
constexpr std::int64_t second_ns{1'000'000'000};

double resident_mb() {
  std::ifstream statm{"/proc/self/statm"};
  double pages{0};
  statm >> pages >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// Allocated heap memory.
double allocated_mb() {
  const struct mallinfo2 heap { mallinfo2() };
  return static_cast<double>(heap.uordblks + heap.hblkhd) / 1e6;
}

/// Processor time of all threads of this process.
double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Number of invalid values.
struct Findings {
  long wrong_values{0};
  long denormal_values{0};
  long ids_used_again{0};
  long refused{0};  ///< frames; expected

  [[nodiscard]] bool fine() const { return wrong_values == 0 && denormal_values == 0 && ids_used_again == 0; }

  void check_probabilities(const Image<float>& image) {
    for (const float p : image) {
      if (!(p >= 0 && p <= 1)) ++wrong_values;
      if (std::fpclassify(p) == FP_SUBNORMAL) ++denormal_values;
    }
  }
  void check_finite(const Image<float>& image) {
    for (const float value : image) {
      if (!std::isfinite(value)) ++wrong_values;
      if (std::fpclassify(value) == FP_SUBNORMAL) ++denormal_values;
    }
  }
};

/// Frames of a source, over and over, and the pipeline that they go through.
class Life {
 public:
  explicit Life(const FrameSource& source) : pipeline_{preset("default"), source.rig()} {
    for (std::size_t i{0}; i < std::min(source.size(), frames_kept); ++i) frames_.push_back(source.load(i));
    const std::int64_t last{frames_.back().stamp_ns - frames_.front().stamp_ns};
    step_ns_ = frames_.size() > 1 ? last / static_cast<std::int64_t>(frames_.size() - 1) : second_ns / 10;
  }

  void take(std::size_t number, Findings& findings) {
    StereoFrame frame{next_frame()};
    disturb(number, frame);
    try {
      const FrameResult& result{pipeline_.process(frame)};
      check(result, findings);
    } catch (const InputError&) {
      ++findings.refused;
    }
  }

 private:
  // To the recording's end, then from its beginning: there the poses jump.
  StereoFrame next_frame() {
    StereoFrame frame{frames_[next_]};
    next_ = (next_ + 1) % frames_.size();
    now_ns_ += step_ns_;
    frame.stamp_ns = now_ns_;
    return frame;
  }

  void disturb(std::size_t number, StereoFrame& frame) {
    const auto every = [number](std::size_t count) { return number % count == count - 1; };
    if (every(1009)) frame.stamp_ns = now_ns_ += 3 * second_ns;
    if (every(5003)) frame.stamp_ns = now_ns_ += 1000 * second_ns;
    if (every(7001)) frame.stamp_ns = now_ns_ -= 500 * second_ns;
    if (every(701)) frame.right = Image<std::uint8_t>{frame.left.width() + 1, frame.left.height()};
    if (every(1301) && frame.world_from_vehicle) frame.world_from_vehicle->x_m += 50;
    if (every(907)) frame.world_from_vehicle.reset();
    if (every(1709)) frame.left.fill(0);
    if (every(2003)) {
      frame.right = {};
      frame.disparity = Image<float>{frame.left.width(), frame.left.height(), 7.5f};
    }
  }

  void check(const FrameResult& result, Findings& findings) {
    findings.check_probabilities(result.observed);
    findings.check_probabilities(result.vehicle.occupancy);
    findings.check_probabilities(result.vehicle.moving);
    findings.check_probabilities(result.world.occupancy);
    findings.check_finite(result.vehicle.velocity_x);
    findings.check_finite(result.vehicle.velocity_y);
    std::set<std::int64_t> ids;
    for (const Obstacle& obstacle : result.obstacles) {
      if (!std::isfinite(obstacle.x_m + obstacle.y_m + obstacle.vx_mps + obstacle.vy_mps)) ++findings.wrong_values;
      // an id that is not of the frame before must be larger than all that ever were
      const bool is_new{!ids_before_.contains(obstacle.id)};
      if (!ids.insert(obstacle.id).second || (is_new && obstacle.id <= largest_id_)) ++findings.ids_used_again;
    }
    for (const std::int64_t id : ids) largest_id_ = std::max(largest_id_, id);
    ids_before_ = std::move(ids);
  }

  Pipeline pipeline_;
  std::vector<StereoFrame> frames_;
  std::int64_t step_ns_;
  std::size_t next_{0};
  std::int64_t now_ns_{1'700'000'000 * second_ns};
  std::set<std::int64_t> ids_before_;
  std::int64_t largest_id_{0};
};

using Lives = std::vector<std::unique_ptr<Life>>;

Lives begin_lives(const std::vector<std::string>& recordings) {
  Lives lives;
  const scenes::Scene scene{scenes::parse_scene("crossing?width=256&height=160&frames=40")};
  lives.push_back(std::make_unique<Life>(scene));
  for (const std::string& path : recordings) {
    lives.push_back(std::make_unique<Life>(*io::open_recording({{path}, {}, {}})));
  }
  return lives;
}

/// Ratio of the frame time of old pipelines to that of new ones.
double time_ratio(Lives& old, const std::vector<std::string>& recordings, Findings& findings) {
  Lives young{begin_lives(recordings)};
  const auto seconds = [&](Lives& lives) {
    const double since_s{processor_s()};
    for (const std::unique_ptr<Life>& life : lives) {
      for (std::size_t number{0}; number < frames_kept; ++number) life->take(number, findings);
    }
    return processor_s() - since_s;
  };
  seconds(young);  // they have their memory then
  double old_s{0};
  double young_s{0};
  for (int turn{0}; turn < 2; ++turn) {
    old_s += seconds(old);
    young_s += seconds(young);
  }
  return old_s / young_s;
}

struct Sample {
  double allocated_mb;
  double resident_mb;
  double time_ratio;
};

bool is_steady(const std::vector<Sample>& tenths) {
  return tenths.back().allocated_mb <= 1.001 * tenths.front().allocated_mb &&
         tenths.back().resident_mb <= 1.05 * tenths.front().resident_mb && tenths.back().time_ratio <= 1.1;
}

bool run(std::size_t frames, const std::vector<std::string>& recordings) {
  Lives lives{begin_lives(recordings)};
  Findings findings;
  std::vector<Sample> tenths;
  std::printf(
      "| frames | allocated MB | resident MB | processor ms a frame | ratio to new pipelines |\n"
      "|---|---|---|---|---|\n");
  const std::size_t tenth{std::max<std::size_t>(frames / 10, 1)};
  for (std::size_t number{0}; number < tenth * 10;) {
    const double since_s{processor_s()};
    for (std::size_t i{0}; i < tenth; ++i, ++number) {
      lives[number / frames_in_turn % lives.size()]->take(number, findings);
    }
    const double frame_ms{(processor_s() - since_s) * 1e3 / static_cast<double>(tenth)};
    Sample& sample{tenths.emplace_back(Sample{allocated_mb(), resident_mb(), 0})};
    sample.time_ratio = time_ratio(lives, recordings, findings);
    std::printf("| %zu | %.3f | %.1f | %.2f | %.3f |\n", number, sample.allocated_mb, sample.resident_mb, frame_ms,
                sample.time_ratio);
    std::fflush(stdout);
  }
  std::printf("\n%ld values that cannot be, %ld denormal, %ld ids used again; %ld frames refused, as they had to be\n",
              findings.wrong_values, findings.denormal_values, findings.ids_used_again, findings.refused);
  return findings.fine() && is_steady(tenths);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    print_machine();
    const std::size_t frames{argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 100'000};
    const bool fine{run(frames, {argv + std::min(argc, 2), argv + argc})};
    std::printf("%s\n", fine ? "steady" : "NOT steady");
    return fine ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_soak: %s\n", error.what());
    return 65;
  }
}

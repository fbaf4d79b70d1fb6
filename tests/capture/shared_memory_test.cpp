// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/capture/shared_memory.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <random>
#include <thread>

#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::capture::testing {
namespace {

using ::testing::HasSubstr;

std::string own_name() {
  return "/stereogrid_test_" + std::to_string(getpid());
}

std::int64_t monotonic_ns() {
  return std::chrono::nanoseconds{Clock::now().time_since_epoch()}.count();
}

TEST(SharedMemory, CarriesPairs) {
  SharedPairs pairs{own_name(), width_px, height_px};
  const auto source{open_shared_memory(own_name(), small_calibration())};
  for (std::uint8_t i{1}; i <= 20; ++i) {
    const std::int64_t captured_ns{monotonic_ns()};
    pairs.write(view(plain(i)), view(plain(100 + i)), captured_ns);
    const auto frame{wait_for_frame(*source)};
    ASSERT_TRUE(frame) << source->fault();
    EXPECT_EQ(frame->frame.left, plain(i));
    EXPECT_EQ(frame->frame.right, plain(100 + i));
    EXPECT_EQ(frame->captured.time_since_epoch(), std::chrono::nanoseconds{captured_ns});
  }
  EXPECT_EQ(source->fault(), "");
}

TEST(SharedMemory, NeverGivesHalvesOfTwoPairs) {
  SharedPairs pairs{own_name(), 640, 480};
  io::Calibration calibration{small_calibration()};
  calibration.rig.width_px = 640;
  calibration.rig.height_px = 480;
  const auto source{open_shared_memory(own_name(), calibration)};
  std::jthread writer{[&](const std::stop_token& stop) {
    for (int i{0}; !stop.stop_requested(); ++i) {
      const auto image{plain(static_cast<std::uint8_t>(i % 251), 640, 480)};
      pairs.write(view(image), view(image), monotonic_ns());
    }
  }};
  for (int i{0}; i < 50; ++i) {
    const auto frame{wait_for_frame(*source)};
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->frame.left, plain(frame->frame.left(0, 0), 640, 480));
    ASSERT_EQ(frame->frame.right, frame->frame.left);
  }
  EXPECT_GT(dropped(*source, "overwritten in shared memory before it was read"), 0);
}

TEST(SharedMemory, FollowsAWriterThatBeginsAnew) {
  const auto source{open_shared_memory(own_name(), small_calibration())};
  ASSERT_TRUE(becomes([&] { return source->fault().find("There is no shared memory") != std::string::npos; }));
  for (std::uint8_t round{1}; round <= 3; ++round) {
    SharedPairs pairs{own_name(), width_px, height_px};
    ASSERT_TRUE(becomes([&] {
      pairs.write(view(plain(round)), view(plain(round)), monotonic_ns());
      const auto frame{source->next(50ms)};
      return frame && frame->frame.left == plain(round);
    }));
    EXPECT_EQ(source->fault(), "");
  }
  EXPECT_TRUE(becomes([&] { return !source->fault().empty(); }));
}

TEST(SharedMemory, SaysWhenSizesDiffer) {
  const SharedPairs pairs{own_name(), 30, 16};
  const auto source{open_shared_memory(own_name(), small_calibration())};
  ASSERT_TRUE(becomes([&] { return !source->fault().empty(); }));
  EXPECT_THAT(source->fault(), HasSubstr("30×16"));
}

/// Bytes that somebody has put there, which change while they are read.
TEST(SharedMemory, SurvivesAnyBytes) {
  const std::string name{own_name() + "_any"};
  const int descriptor{shm_open(name.c_str(), O_CREAT | O_RDWR, 0600)};
  ASSERT_GE(descriptor, 0);
  std::mt19937 random{1};
  {
    SharedPairs good{own_name(), width_px, height_px};
    good.write(view(plain(1)), view(plain(1)), 1);
    const int from{shm_open(own_name().c_str(), O_RDONLY, 0)};
    std::vector<char> bytes(4 * 2048);
    const ssize_t size{pread(from, bytes.data(), bytes.size(), 0)};
    close(from);
    ASSERT_GT(size, 1000);
    const auto source{open_shared_memory(name, small_calibration())};
    for (int i{0}; i < 300; ++i) {
      std::vector<char> spoilt{bytes.begin(), bytes.begin() + size};
      for (int k{0}; k < 3; ++k) spoilt[random() % (i % 2 == 0 ? 128 : spoilt.size())] = static_cast<char>(random());
      ASSERT_EQ(pwrite(descriptor, spoilt.data(), spoilt.size(), 0), size);
      ASSERT_EQ(ftruncate(descriptor, static_cast<off_t>(i % 10 == 0 ? random() % 2000 : size)), 0);
      static_cast<void>(source->next(2ms));
    }
  }
  close(descriptor);
  shm_unlink(name.c_str());
}

TEST(SharedMemory, RefusesNamesThatCannotBe) {
  EXPECT_THROW(static_cast<void>(open_shared_memory("", small_calibration())), ConfigError);
  EXPECT_THROW(static_cast<void>(open_shared_memory("a/b", small_calibration())), ConfigError);
  EXPECT_THROW((SharedPairs{own_name(), 0, 4}), ConfigError);
  SharedPairs pairs{own_name(), width_px, height_px};
  EXPECT_THROW(pairs.write(view(plain(1)), view(plain(1, 3, 3)), 1), InputError);
}

}  // namespace
}  // namespace stereogrid::capture::testing

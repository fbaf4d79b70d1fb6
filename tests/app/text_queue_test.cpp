// SPDX-License-Identifier: Apache-2.0
#include "cli/console.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>

namespace stereogrid::app {
namespace {

using Kind = TextQueue::Kind;
using namespace std::chrono_literals;

/// A pipe, and a queue that writes into it; in the tool: run/streams_test.cpp.
class TextQueues : public ::testing::Test {
 protected:
  TextQueues() {
    EXPECT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
    fcntl(ends[0], F_SETFL, O_NONBLOCK);
  }
  ~TextQueues() override {
    for (const int end : ends) close(end);
  }

  void add(const std::string& text, Kind kind = Kind::lines) { queue.add(ends[1], text, kind); }

  std::string read_some() {
    std::string piece(4096, '\0');
    const ssize_t count{read(ends[0], piece.data(), piece.size())};
    return piece.substr(0, static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  }

  /// Reads until the queue and the pipe are empty.
  std::string read_all() {
    std::string text;
    for (bool is_done{false}; !is_done;) {
      is_done = queue.drain(1ms);
      for (std::string piece; !(piece = read_some()).empty();) text += piece;
    }
    return text;
  }

  std::array<int, 2> ends{};
  TextQueue& queue{*new TextQueue};
};

/// As many as the queue keeps, three times.
constexpr int too_many{static_cast<int>(3 * TextQueue::most_line_bytes / 100)};

std::string line(int number) {
  return fmt::format("{:099}\n", number);
}

TEST_F(TextQueues, DropTheOldestLinesOfAStalledReaderAndSayHowMany) {
  for (int i{0}; i < too_many; ++i) add(line(i));
  EXPECT_FALSE(queue.drain(10ms));
  EXPECT_FALSE(queue.is_empty());
  std::istringstream lines{read_all()};
  int expected{0};
  int dropped{0};
  for (std::string text; std::getline(lines, text);) {
    if (int count{0}; std::sscanf(text.c_str(), "warning: %d lines were dropped", &count) == 1) {
      dropped += count;
      expected += count;
    } else {
      EXPECT_EQ(text + '\n', line(expected++));
    }
  }
  EXPECT_GT(dropped, too_many / 3);
  EXPECT_EQ(expected, too_many) << "the last line is there";
  add(line(1));
  EXPECT_EQ(read_all(), line(1)) << "the number is said once";
}

TEST_F(TextQueues, DropNoOutput) {
  std::string expected;
  for (int i{0}; i < too_many; ++i) {
    add(line(i), Kind::output);
    expected += line(i);
  }
  EXPECT_EQ(read_all(), expected);
}

// As node and ssh leave a terminal that they share.
TEST_F(TextQueues, WriteAllIntoAStreamThatDoesNotBlock) {
  fcntl(ends[1], F_SETFL, O_NONBLOCK);
  add(std::string(std::size_t{1} << 18, 'x'), Kind::output);
  EXPECT_EQ(read_all().size(), std::size_t{1} << 18);
  EXPECT_EQ(queue.output_error(), 0);
}

}  // namespace
}  // namespace stereogrid::app

// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "view/playback.hpp"

namespace stereogrid::app {
namespace {

/// Passes messages on, with topics below a prefix.
class PrefixedSink final : public messages::Sink {
 public:
  PrefixedSink(messages::Sink& sink, std::string prefix) : sink_{sink}, prefix_{std::move(prefix)} {}

  std::uint32_t add(const messages::Channel& channel) override {
    messages::Channel prefixed{channel};
    prefixed.topic = prefix_ + channel.topic;
    return sink_.add(prefixed);
  }
  [[nodiscard]] bool wants(std::uint32_t channel) const override { return sink_.wants(channel); }
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override {
    sink_.send(channel, stamp_ns, cdr);
  }

 private:
  messages::Sink& sink_;
  std::string prefix_;
};

std::vector<std::string> names_of(const std::vector<std::string>& runs) {
  std::vector<std::string> names;
  for (const std::string& run : runs) {
    std::string name{recording_name(run)};
    if (std::ranges::find(names, name) != names.end()) name += fmt::format("_{}", names.size() + 1);
    names.push_back(std::move(name));
  }
  return names;
}

class SideBySide final : public PlayedFrames {
 public:
  explicit SideBySide(const std::vector<std::string>& runs) : names_{names_of(runs)} {
    for (const std::string& run : runs) runs_.push_back(played_frames(std::filesystem::path{run}));
  }

  [[nodiscard]] const std::vector<std::uint64_t>& stamps_ns() const override { return runs_.front()->stamps_ns(); }

  [[nodiscard]] std::vector<std::string> damage() const override {
    std::vector<std::string> all;
    for (std::size_t i{0}; i < runs_.size(); ++i) {
      for (const std::string& text : runs_[i]->damage()) all.push_back(fmt::format("{}: {}", names_[i], text));
    }
    return all;
  }

  void send(std::size_t frame, messages::Sink& sink) override {
    if (sinks_.empty()) {
      for (const std::string& name : names_) sinks_.push_back(std::make_unique<PrefixedSink>(sink, '/' + name));
    }
    const std::uint64_t stamp_ns{stamps_ns().at(frame)};
    for (std::size_t i{0}; i < runs_.size(); ++i) {
      const auto& stamps{runs_[i]->stamps_ns()};
      const auto later{std::ranges::upper_bound(stamps, stamp_ns) - stamps.begin()};
      runs_[i]->send(i == 0 ? frame : static_cast<std::size_t>(std::max<std::ptrdiff_t>(later - 1, 0)), *sinks_[i]);
    }
  }

 private:
  std::vector<std::string> names_;
  std::vector<std::unique_ptr<PlayedFrames>> runs_;
  std::vector<std::unique_ptr<PrefixedSink>> sinks_;  // runs keep references to theirs
};

}  // namespace

std::unique_ptr<PlayedFrames> played_frames(const std::vector<std::string>& runs) {
  if (runs.size() == 1) return played_frames(std::filesystem::path{runs.front()});
  return std::make_unique<SideBySide>(runs);
}

std::string recording_names(const std::vector<std::string>& runs) {
  return fmt::format("{}", fmt::join(names_of(runs), ", "));
}

}  // namespace stereogrid::app

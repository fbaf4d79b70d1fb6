// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "connect/message_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "connect/mcap_sink.hpp"
#include "pictures/picture.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/messages/tee.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view picture_topic{"left/image_annotated/compressed"};
constexpr std::array<std::string_view, 3> topics_of_stages{"disparity", "points", picture_topic};

bool is_wanted(const McapOptions& options, std::string_view topic) {
  return options.topics.empty() || std::ranges::find(options.topics, topic) != options.topics.end();
}

/// Makes its folder.
const fs::path& ready(const fs::path& file) {
  if (file.has_parent_path()) io::create_folder(file.parent_path());
  return file;
}

}  // namespace

void check_mcap(const McapOptions& options, const Rig& rig) {
  if (options.file.empty()) {
    if (options.topics.empty()) return;
    throw ConfigError{"--mcap-topics chooses what is recorded, but nothing is. Give --mcap FILE, too."};
  }
  if (fs::exists(options.file) && !fs::is_other(options.file)) {
    throw ConfigError{fmt::format("--mcap {}: it is there already. Give another name, or delete it.",
                                  io::printable_path(options.file))};
  }
  try {
    messages::Tee nowhere{{}};
    const messages::FrameMessages names{nowhere, rig, {.topics = options.topics}};
  } catch (const ConfigError& error) {
    throw ConfigError{fmt::format("--mcap-topics: {}", error.what())};
  }
}

bool needs_stages(const McapOptions& options) {
  return !options.file.empty() &&
         std::ranges::any_of(topics_of_stages, [&](std::string_view topic) { return is_wanted(options, topic); });
}

struct McapRecorder::State {
  State(const McapOptions& options, const Rig& first_rig, std::size_t first_frame)
      : sink{ready(options.file)},
        messages{sink, first_rig, {.topics = options.topics}},
        rig{first_rig},
        first{static_cast<std::int64_t>(first_frame)},
        wants_picture{is_wanted(options, picture_topic)} {}

  McapSink sink;
  messages::FrameMessages messages;
  Rig rig;
  std::int64_t first;
  std::int64_t frames{0};
  bool wants_picture;
};

McapRecorder::McapRecorder(const McapOptions& options, const Rig& rig, std::size_t first_frame)
    : state_{std::make_unique<State>(options, rig, first_frame)} {}

McapRecorder::~McapRecorder() = default;

void McapRecorder::add(const StereoFrame& frame, const FrameResult& result, const Rig& rig) {
  if (rig != state_->rig) state_->messages.set_rig(rig);
  state_->rig = rig;
  ++state_->frames;
  const std::array<messages::Dropped, 1> dropped{
      {{"cannot be used", frame.index - state_->first + 1 - state_->frames}}};
  const std::vector<std::uint8_t> jpeg{state_->wants_picture ? annotated_jpeg(frame, result, rig)
                                                             : std::vector<std::uint8_t>{}};
  state_->messages.send(result, {.stamp_ns = frame.stamp_ns,
                                 .left_jpeg = std::as_bytes(std::span{jpeg}),
                                 .frames = state_->frames,
                                 .dropped = dropped});
}

void McapRecorder::finish() {
  state_->sink.close();
}

}  // namespace stereogrid::app

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../prelude.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/messages/sink.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::messages::test {

/// Keeps what it is sent, and decodes it.
class Recorder : public Sink {
 public:
  struct Sent {
    std::string topic;
    std::int64_t stamp_ns;
    std::vector<std::byte> cdr;
  };

  std::uint32_t add(const Channel& channel) override;
  [[nodiscard]] bool wants(std::uint32_t channel) const override;
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override;

  [[nodiscard]] std::size_t count(const std::string& topic) const;
  /// The last message on a topic; a failure where there is none or it is of another type.
  template <Message M>
  [[nodiscard]] M last(const std::string& topic) const {
    M message;
    EXPECT_EQ(type_of(topic), M::type_name) << topic;
    for (const Sent& one : sent) {
      if (one.topic == topic) decode(one.cdr, message);
    }
    return message;
  }
  [[nodiscard]] std::string type_of(const std::string& topic) const;

  std::vector<Channel> channels;
  std::vector<Sent> sent;
  std::set<std::string> unwanted;
};

/// 200 × 100 px, 90° wide, 1.5 m above the ground.
[[nodiscard]] Rig small_rig();

/// Grids of 8 × 6 cells of half a metre ahead of the vehicle, and 5 × 4 cells in the world; nothing observed.
[[nodiscard]] FrameResult small_result();

/// Message of a new FrameMessages about a result.
template <Message M>
[[nodiscard]] M sent_on(const std::string& topic, const FrameResult& result, const FrameFacts& facts = {},
                        const FrameMessagesOptions& options = {}, const Rig& rig = small_rig()) {
  Recorder recorder;
  FrameMessages{recorder, rig, options}.send(result, facts);
  return recorder.last<M>(topic);
}

}  // namespace stereogrid::messages::test

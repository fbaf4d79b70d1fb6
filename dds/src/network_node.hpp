// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "participant.hpp"
#include "stereogrid/dds/node.hpp"
#include "stereogrid/messages/sink.hpp"

namespace stereogrid::dds {

/// Passes received messages to subscribers on one thread, so that threads of the network do not wait.
class Subscriptions {
 public:
  explicit Subscriptions(Participant& participant);
  Subscriptions(const Subscriptions&) = delete;
  Subscriptions& operator=(const Subscriptions&) = delete;
  ~Subscriptions();

  void add(const std::string& topic, const std::string& type, std::size_t depth, Take take, bool is_latched);
  void remove(const std::string& topic);

 private:
  struct Reader {
    std::string topic;
    Take take;
    std::atomic<dds_entity_t> entity{0};  // 0: removed; the thread may still have the address
  };

  void run();
  void take_all(const Reader& reader);
  void hand_over(const Reader& reader, std::span<const std::byte> cdr);

  Participant& participant_;
  dds_entity_t waitset_;
  dds_entity_t stop_;
  std::mutex mutex_;  // guards `readers_`
  std::vector<std::unique_ptr<Reader>> readers_;
  std::thread thread_;
};

/// A writer of DDS for each channel.
class TopicSink final : public messages::Sink {
 public:
  /// `participant` must be destroyed first: its threads report subscribers.
  TopicSink(Participant& participant, std::vector<std::string> left_out)
      : participant_{participant}, left_out_{std::move(left_out)} {}

  std::uint32_t add(const messages::Channel& channel) override;
  [[nodiscard]] bool wants(std::uint32_t channel) const override;
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override;

 private:
  struct Writer {
    std::string topic;  ///< in ROS
    bool is_latched;
    Warnings& warnings;
    dds_entity_t entity{0};  ///< 0: left out
    ddsi_sertype* type{nullptr};
  };
  static void log_refused(dds_entity_t entity, dds_offered_incompatible_qos_status_t status, void* writer) noexcept;

  Participant& participant_;
  std::vector<std::string> left_out_;
  std::vector<std::unique_ptr<Writer>> writers_;
};

class NetworkNode final : public Node {
 public:
  /// Throws ConfigError, DeviceError.
  explicit NetworkNode(const NodeOptions& options);
  ~NetworkNode() override;

  [[nodiscard]] messages::Sink& sink() override { return *sink_; }
  [[nodiscard]] std::vector<PublishedTopic> topics() const override;
  void subscribe(const std::string& topic, const std::string& type, std::size_t depth, Take take,
                 bool is_latched) override;
  void unsubscribe(const std::string& topic) override;

 private:
  std::optional<Participant> participant_;
  std::optional<TopicSink> sink_;
  std::optional<Subscriptions> subscriptions_;
};

/// Passes warnings of Cyclone DDS in this process to `warn`, each once: a pulled cable causes one per packet. Texts
/// that differ in numbers only are the same.
void take_network_log(std::function<void(const std::string&)> warn);

}  // namespace stereogrid::dds

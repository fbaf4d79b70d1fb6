// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "network_node.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <span>
#include <utility>

#include "names.hpp"
#include "participant.hpp"

namespace stereogrid::dds {
namespace {

constexpr std::size_t at_once{16};

}  // namespace

Subscriptions::Subscriptions(Participant& participant)
    : participant_{participant},
      waitset_{checked(dds_create_waitset(participant.entity()), "nothing can be waited for")},
      stop_{checked(dds_create_guardcondition(participant.entity()), "nothing can be waited for")} {
  checked(dds_waitset_attach(waitset_, stop_, 0), "nothing can be waited for");
  thread_ = std::thread{[this] { run(); }};
}

Subscriptions::~Subscriptions() {
  dds_set_guardcondition(stop_, true);
  thread_.join();
}

void Subscriptions::add(const std::string& topic, const std::string& type, std::size_t depth, Take take,
                        bool is_latched) {
  auto reader{std::make_unique<Reader>()};
  reader->topic = participant_.names().remapped(topic);
  reader->take = std::move(take);
  const int messages{static_cast<int>(depth)};
  Qos qos{is_latched ? reliable_qos(true, messages) : best_effort_qos(messages)};
  set_type_hash(qos.get(), type, definition_of_subscribed(type));
  reader->entity = participant_.make_reader(reader->topic, type, std::move(qos), nullptr);
  const dds_entity_t condition{
      checked(dds_create_readcondition(reader->entity, DDS_ANY_STATE), topic + " cannot be waited for")};
  const auto attached{reinterpret_cast<dds_attach_t>(reader.get())};
  {
    const std::scoped_lock lock{mutex_};
    readers_.push_back(std::move(reader));
  }
  checked(dds_waitset_attach(waitset_, condition, attached), topic + " cannot be waited for");
}

void Subscriptions::remove(const std::string& topic) {
  const std::string name{participant_.names().remapped(topic)};
  const std::scoped_lock lock{mutex_};
  for (const std::unique_ptr<Reader>& reader : readers_) {
    if (reader->topic == name) participant_.delete_reader(reader->entity.exchange(0));
  }
}

void Subscriptions::run() {
  std::array<dds_attach_t, at_once> triggered{};
  for (;;) {
    const dds_return_t count{dds_waitset_wait(waitset_, triggered.data(), triggered.size(), DDS_INFINITY)};
    if (count < 0) {
      return participant_.warnings().log_once(std::string{"ROS 2: reception has ended: "} + dds_strretcode(count) +
                                              ".");
    }
    bool is_stopped{false};
    dds_read_guardcondition(stop_, &is_stopped);
    if (is_stopped) return;
    // readers beyond the array's size follow in the next wait
    for (const dds_attach_t one : std::span{triggered}.first(std::min<std::size_t>(count, at_once))) {
      if (one != 0) take_all(*reinterpret_cast<const Reader*>(one));
    }
  }
}

void Subscriptions::take_all(const Reader& reader) {
  std::array<ddsi_serdata*, at_once> samples{};
  std::array<dds_sample_info_t, at_once> infos{};
  const dds_return_t count{dds_takecdr(reader.entity, samples.data(), samples.size(), infos.data(), DDS_ANY_STATE)};
  for (std::size_t i{0}; count > 0 && i < static_cast<std::size_t>(count); ++i) {
    if (infos[i].valid_data) hand_over(reader, bytes_of(samples[i]));
    ddsi_serdata_unref(samples[i]);
  }
}

void Subscriptions::hand_over(const Reader& reader, std::span<const std::byte> cdr) {
  try {
    reader.take(cdr);
  } catch (const std::exception& error) {
    participant_.warnings().log_once("ROS 2: " + reader.topic + ": " + error.what());
  }
}

}  // namespace stereogrid::dds

// SPDX-License-Identifier: Apache-2.0
#include "network_node.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <map>
#include <set>
#include <span>
#include <string_view>

#include <dds/ddsrt/log.h>

#include "names.hpp"

namespace stereogrid::dds {
namespace {

constexpr std::size_t publications_max{4096};

bool is_of(const dds_builtintopic_endpoint_t& endpoint, const dds_guid_t& participant) {
  return std::ranges::equal(endpoint.participant_key.v, participant.v);
}

}  // namespace

NetworkNode::NetworkNode(const NodeOptions& options)
    : participant_{std::in_place, options},
      sink_{std::in_place, *participant_, options.left_out},
      subscriptions_{std::in_place, *participant_} {}

NetworkNode::~NetworkNode() {
  subscriptions_.reset();
  participant_.reset();  // no listener of a writer is called afterwards
}

// A new reader has the current publishers only; a permanent one would keep former ones.
std::vector<PublishedTopic> NetworkNode::topics() const {
  const dds_entity_t publications{
      checked(dds_create_reader(participant_->entity(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
              "the topics of other publishers cannot be read")};
  std::vector<void*> samples(publications_max, nullptr);
  std::vector<dds_sample_info_t> infos(publications_max);
  const dds_return_t count{dds_read_mask(publications, samples.data(), infos.data(), publications_max, publications_max,
                                         DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE)};
  std::map<std::pair<std::string, std::string>, int> publishers;
  for (std::size_t i{0}; count > 0 && i < static_cast<std::size_t>(count); ++i) {
    const auto& endpoint{*static_cast<const dds_builtintopic_endpoint_t*>(samples[i])};
    if (!infos[i].valid_data || is_of(endpoint, participant_->guid())) continue;
    const auto topic{ros_topic(endpoint.topic_name, endpoint.type_name)};
    if (topic) ++publishers[{topic->name, topic->type}];
  }
  if (count > 0) dds_return_loan(publications, samples.data(), count);
  dds_delete(publications);
  checked(count, "the topics of other publishers cannot be read");
  std::vector<PublishedTopic> found;
  for (const auto& [topic, number] : publishers) found.push_back({topic.first, topic.second, number});
  return found;
}

void NetworkNode::subscribe(const std::string& topic, const std::string& type, std::size_t depth, Take take,
                            bool is_latched) {
  subscriptions_->add(topic, type, depth, std::move(take), is_latched);
}

void NetworkNode::unsubscribe(const std::string& topic) {
  subscriptions_->remove(topic);
}

namespace {

void check(const NodeOptions& options) {
  const Names names{options};
  static_cast<void>(network_of_environment());
}

std::unique_ptr<Node> open(const NodeOptions& options) {
  take_network_log(options.warn);
  return std::make_unique<NetworkNode>(options);
}

}  // namespace
namespace {

constexpr std::size_t reported_max{1000};
// harmless: discovery works without multicast; a machine without a network has loopback alone
constexpr std::array<std::string_view, 2> harmless{"selected interface \"lo\" is not multicast-capable",
                                                   "lo: the same interface may not be selected twice"};

struct Log {
  std::mutex mutex;
  std::function<void(const std::string&)> warn;
  std::set<std::string> reported;
};

Log& log_of_process() {
  static Log log;
  return log;
}

std::string without_digits(std::string text) {
  std::erase_if(text, [](char letter) { return letter >= '0' && letter <= '9'; });
  return text;
}

// No exceptions: called by C.
void take(void* /*of*/, const dds_log_data_t* data) noexcept {
  if ((data->priority & (DDS_LC_FATAL | DDS_LC_ERROR | DDS_LC_WARNING)) == 0) return;
  try {
    std::string text{data->message};
    std::erase_if(text, [](unsigned char letter) { return letter < ' '; });  // the text may include data of a peer
    if (std::ranges::any_of(harmless, [&](std::string_view start) { return text.starts_with(start); })) return;
    Log& log{log_of_process()};
    std::function<void(const std::string&)> warn;
    {
      const std::scoped_lock lock{log.mutex};
      if (log.reported.size() < reported_max && log.reported.insert(without_digits(text)).second) warn = log.warn;
    }
    if (warn) warn("ROS 2: " + text);
  } catch (...) {
  }
}

}  // namespace

void take_network_log(std::function<void(const std::string&)> warn) {
  Log& log{log_of_process()};
  const std::scoped_lock lock{log.mutex};
  log.warn = std::move(warn);
  log.reported.clear();
  dds_set_log_sink(take, nullptr);
}

namespace {

constexpr int depth{10};

}  // namespace

void TopicSink::log_refused(dds_entity_t /*entity*/, dds_offered_incompatible_qos_status_t status,
                            void* writer) noexcept {
  const Writer& one{*static_cast<const Writer*>(writer)};
  try {
    one.warnings.log_once("ROS 2: a subscriber of " + one.topic + " receives nothing: it requires " +
                          policy_in_words(status.last_policy_id) +
                          ", which this topic does not offer. Subscribe without it.");
  } catch (...) {  // no exceptions: called by C
  }
}

std::uint32_t TopicSink::add(const messages::Channel& channel) {
  auto writer{
      std::make_unique<Writer>(participant_.names().topic(channel.topic), channel.latched, participant_.warnings())};
  if (std::ranges::find(left_out_, channel.topic) != left_out_.end()) {
    writers_.push_back(std::move(writer));
    return static_cast<std::uint32_t>(writers_.size() - 1);
  }
  const Listener listener{dds_create_listener(nullptr)};
  dds_lset_offered_incompatible_qos_arg(listener.get(), log_refused, writer.get(), true);
  Qos qos{reliable_qos(channel.latched, channel.latched ? 1 : depth)};
  set_type_hash(qos.get(), channel.type, channel.definition);
  const auto [entity,
              type]{participant_.make_writer(writer->topic, std::string{channel.type}, std::move(qos), listener.get())};
  writer->entity = entity;
  writer->type = type;
  writers_.push_back(std::move(writer));
  return static_cast<std::uint32_t>(writers_.size() - 1);
}

bool TopicSink::wants(std::uint32_t channel) const {
  const Writer& writer{*writers_.at(channel)};
  if (writer.entity == 0) return false;
  if (writer.is_latched) return true;
  dds_publication_matched_status_t status{};
  checked(dds_get_publication_matched_status(writer.entity, &status), writer.topic + " has no subscribers' number");
  return status.current_count > 0;
}

void TopicSink::send(std::uint32_t channel, std::int64_t /*stamp_ns*/, std::span<const std::byte> cdr) {
  const Writer& writer{*writers_.at(channel)};
  if (writer.entity == 0) return;  // other publishers of a Tee may need the channel
  // does not wait: the oldest unread messages are dropped
  checked(dds_writecdr(writer.entity, new_sample(writer.type, cdr)),
          "a message on " + writer.topic + " cannot be sent");
}

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

extern "C" STEREOGRID_EXPORT const stereogrid::dds::Library* stereogrid_dds_library_4();

const stereogrid::dds::Library* stereogrid_dds_library_4() {
  using namespace stereogrid::dds;
  static const Library library{STEREOGRID_VERSION, interface_sizes(), check, open};
  return &library;
}

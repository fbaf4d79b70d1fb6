// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "network_node.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

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
}  // namespace stereogrid::dds

extern "C" STEREOGRID_EXPORT const stereogrid::dds::Library* stereogrid_dds_library_4();

const stereogrid::dds::Library* stereogrid_dds_library_4() {
  using namespace stereogrid::dds;
  static const Library library{STEREOGRID_VERSION, interface_sizes(), check, open};
  return &library;
}

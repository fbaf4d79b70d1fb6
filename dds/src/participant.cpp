// SPDX-License-Identifier: Apache-2.0
#include "participant.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <new>

namespace stereogrid::dds {
namespace {

constexpr std::string_view enclave{"enclave=/;"};  // expected by peers of ROS
// User data of our own writers of ros_discovery_info, whose layout does not indicate the distribution of peers.
constexpr std::string_view own_mark{"stereogrid=1;"};
constexpr int infos_at_once{64};

dds_entity_t new_participant(dds_domainid_t domain) {
  const Qos qos{dds_create_qos()};
  dds_qset_userdata(qos.get(), enclave.data(), enclave.size());
  return checked(dds_create_participant(domain, qos.get(), nullptr), "the participant cannot be created");
}

dds_guid_t guid_of(dds_entity_t entity) {
  dds_guid_t guid{};
  checked(dds_get_guid(entity, &guid), "a part of the node has no number");
  return guid;
}

bool is_own_kind(const dds_builtintopic_endpoint_t& writer) {
  void* data{nullptr};
  std::size_t size{0};
  const bool is_same{dds_qget_userdata(writer.qos, &data, &size) && data != nullptr &&
                     std::string_view{static_cast<const char*>(data), size} == own_mark};
  dds_free(data);
  return is_same;
}

struct FreeEndpoint {
  void operator()(dds_builtintopic_endpoint_t* endpoint) const { dds_builtintopic_free_endpoint(endpoint); }
};
/// The peer's writer; none: it is gone.
std::unique_ptr<dds_builtintopic_endpoint_t, FreeEndpoint> writer_of(dds_entity_t reader, dds_instance_handle_t peer) {
  return std::unique_ptr<dds_builtintopic_endpoint_t, FreeEndpoint>{dds_get_matched_publication_data(reader, peer)};
}

}  // namespace

Participant::Participant(const NodeOptions& options)
    : names_{options},
      warnings_{options.warn},
      domain_{network_of_environment()},
      entity_{new_participant(domain_.id())},
      layout_{options.distro} {
  try {
    entities_ = {names_.node_namespace(), names_.node(), guid_of(entity_)};
    const DdsTopic topic{make_topic(discovery_topic, dds_type(discovery_type))};
    const Qos qos{reliable_qos(true, 1)};
    dds_qset_userdata(qos.get(), own_mark.data(), own_mark.size());
    announcer_ =
        checked(dds_create_writer(entity_, topic.entity, qos.get(), nullptr), "ros_discovery_info cannot be written");
    announced_type_ = topic.type;
    announce();
    if (layout_ != Distro::automatic) return;
    const Listener listener{dds_create_listener(this)};
    dds_lset_data_available(listener.get(), on_discovery_info);
    checked(dds_create_reader(entity_, topic.entity, reliable_qos(true, infos_at_once).get(), listener.get()),
            "ros_discovery_info cannot be read");
  } catch (...) {
    dds_delete(entity_);
    throw;
  }
}

Participant::~Participant() {
  dds_delete(entity_);
}

DdsTopic Participant::make_topic(const std::string& name, const std::string& type) {
  ddsi_sertype* bytes_type{new_bytes_type(type)};
  const dds_entity_t topic{dds_create_topic_sertype(entity_, name.c_str(), &bytes_type, nullptr, nullptr, nullptr)};
  if (topic < 0) ddsi_sertype_unref(bytes_type);
  return {checked(topic, "topic " + name + " cannot be made"), bytes_type};
}

std::pair<dds_entity_t, ddsi_sertype*> Participant::make_writer(const std::string& topic, const std::string& type,
                                                                Qos qos, const dds_listener_t* listener) {
  const DdsTopic made{make_topic(dds_topic(topic), dds_type(type))};
  const dds_entity_t writer{
      checked(dds_create_writer(entity_, made.entity, qos.get(), listener), topic + " cannot be published")};
  add(writer, entities_.writers);
  return {writer, made.type};
}

dds_entity_t Participant::make_reader(const std::string& topic, const std::string& type, Qos qos,
                                      const dds_listener_t* listener) {
  const DdsTopic made{make_topic(dds_topic(topic), dds_type(type))};
  const dds_entity_t reader{
      checked(dds_create_reader(entity_, made.entity, qos.get(), listener), topic + " cannot be subscribed to")};
  add(reader, entities_.readers);
  return reader;
}

void Participant::delete_reader(dds_entity_t reader) {
  if (reader == 0) return;
  const dds_guid_t guid{guid_of(reader)};
  dds_delete(reader);
  const std::scoped_lock lock{mutex_};
  std::erase_if(entities_.readers, [&](const dds_guid_t& one) { return std::ranges::equal(one.v, guid.v); });
  announce();
}

void Participant::add(dds_entity_t entity, std::vector<dds_guid_t>& list) {
  const std::scoped_lock lock{mutex_};
  list.push_back(guid_of(entity));
  announce();
}

void Participant::announce() {
  checked(dds_writecdr(announcer_, new_sample(announced_type_, discovery_message(entities_, layout_))),
          "ros_discovery_info cannot be written");
}

void Participant::on_discovery_info(dds_entity_t reader, void* participant) noexcept {
  Participant& one{*static_cast<Participant*>(participant)};
  std::array<ddsi_serdata*, infos_at_once> samples{};
  std::array<dds_sample_info_t, infos_at_once> infos{};
  const dds_return_t count{dds_takecdr(reader, samples.data(), samples.size(), infos.data(), DDS_ANY_STATE)};
  for (std::size_t i{0}; count > 0 && i < static_cast<std::size_t>(count); ++i) {
    try {
      const auto layout{infos[i].valid_data ? layout_of(bytes_of(samples[i])) : std::nullopt};
      if (layout) one.set_layout_of(reader, infos[i].publication_handle, *layout);
    } catch (const std::exception& error) {  // no exceptions: called by C
      one.warnings_.log_once(std::string{"ROS 2: ros_discovery_info of a peer: "} + error.what());
    }
    ddsi_serdata_unref(samples[i]);
  }
}

// Our own nodes are skipped before the lock: two in one process may write at the same time.
void Participant::set_layout_of(dds_entity_t reader, dds_instance_handle_t peer, Distro layout) {
  const auto writer{writer_of(reader, peer)};
  if (!writer || is_own_kind(*writer)) return;
  const std::scoped_lock lock{mutex_};
  layouts_[peer] = layout;
  std::erase_if(layouts_, [&](const auto& one) { return one.first != peer && !writer_of(reader, one.first); });
  const bool has_humble{std::ranges::any_of(layouts_, [](const auto& one) { return one.second == Distro::humble; })};
  const Distro wanted{has_humble ? Distro::humble : Distro::jazzy};
  if (wanted == layout_) return;
  layout_ = wanted;
  announce();
}

namespace {

constexpr dds_duration_t longest_wait{DDS_MSECS(50)};  // unused: writers that keep the last messages do not wait

Qos qos_of(dds_reliability_kind reliability, dds_durability_kind durability, int depth) {
  Qos qos{dds_create_qos()};
  if (!qos) throw std::bad_alloc{};
  dds_qset_reliability(qos.get(), reliability, longest_wait);
  dds_qset_durability(qos.get(), durability);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, depth, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED);
  // subscribers keep what they have when this node ends
  dds_qset_writer_data_lifecycle(qos.get(), false);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  const dds_data_representation_id_t xcdr1{DDS_DATA_REPRESENTATION_XCDR1};
  dds_qset_data_representation(qos.get(), 1, &xcdr1);
  return qos;
}

}  // namespace

Qos reliable_qos(bool is_transient_local, int depth) {
  return qos_of(DDS_RELIABILITY_RELIABLE, is_transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE,
                depth);
}

Qos best_effort_qos(int depth) {
  return qos_of(DDS_RELIABILITY_BEST_EFFORT, DDS_DURABILITY_VOLATILE, depth);
}

void set_type_hash(dds_qos_t* qos, std::string_view ros_type, std::string_view definition) {
  if (definition.empty()) return;  // unknown: peers assume that the types agree
  const std::string text{"typehash=" + type_hash(ros_type, definition) + ";"};
  dds_qset_userdata(qos, text.data(), text.size());
}

std::string policy_in_words(std::uint32_t policy_id) {
  switch (policy_id) {
    case DDS_DURABILITY_QOS_POLICY_ID:
      return "durability (transient local: earlier messages)";
    case DDS_RELIABILITY_QOS_POLICY_ID:
      return "reliability (reliable: no lost messages)";
    case DDS_DEADLINE_QOS_POLICY_ID:
      return "a deadline between messages";
    case DDS_LIVELINESS_QOS_POLICY_ID:
      return "liveliness with a lease";
    case DDS_OWNERSHIP_QOS_POLICY_ID:
      return "exclusive ownership";
    case DDS_DATA_REPRESENTATION_QOS_POLICY_ID:
      return "another data representation than XCDR1";
    default:
      return "a policy of DDS with the number " + std::to_string(policy_id);
  }
}

}  // namespace stereogrid::dds

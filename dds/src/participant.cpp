// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "participant.hpp"

#include <algorithm>
#include <string_view>

#include "bytes_type.hpp"

namespace stereogrid::dds {
namespace {

constexpr std::string_view enclave{"enclave=/;"};  // what peers of ROS look for

dds_entity_t new_participant(dds_domainid_t domain) {
  const Qos qos{dds_create_qos()};
  dds_qset_userdata(qos.get(), enclave.data(), enclave.size());
  return checked(dds_create_participant(domain, qos.get(), nullptr), "no participant could be made");
}

dds_guid_t guid_of(dds_entity_t entity) {
  dds_guid_t guid{};
  checked(dds_get_guid(entity, &guid), "a part of the node has no number");
  return guid;
}

}  // namespace

Participant::Participant(const NodeOptions& options)
    : names_{options},
      distro_{options.distro},
      warnings_{options.warn},
      domain_{network_of_environment()},
      entity_{new_participant(domain_.id())} {
  try {
    entities_ = {names_.node_namespace(), names_.node(), guid_of(entity_)};
    const DdsTopic topic{make_topic(discovery_topic, dds_type(discovery_type))};
    announcer_ = checked(dds_create_writer(entity_, topic.entity, reliable_qos(true, 1).get(), nullptr),
                         "the list of nodes cannot be written");
    announced_type_ = topic.type;
    announce();
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

void Participant::set_hash(dds_qos_t* qos, const std::string& type) const {
  if (distro_ != Distro::humble) set_type_hash(qos, type);
}

std::pair<dds_entity_t, ddsi_sertype*> Participant::make_writer(const std::string& topic, const std::string& type,
                                                                Qos qos, const dds_listener_t* listener) {
  set_hash(qos.get(), type);
  const DdsTopic made{make_topic(dds_topic(topic), dds_type(type))};
  const dds_entity_t writer{
      checked(dds_create_writer(entity_, made.entity, qos.get(), listener), topic + " cannot be published")};
  add(writer, entities_.writers);
  return {writer, made.type};
}

dds_entity_t Participant::make_reader(const std::string& topic, const std::string& type, Qos qos,
                                      const dds_listener_t* listener) {
  set_hash(qos.get(), type);
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
  checked(dds_writecdr(announcer_, new_sample(announced_type_, discovery_message(entities_, distro_))),
          "the list of nodes cannot be written");
}

}  // namespace stereogrid::dds

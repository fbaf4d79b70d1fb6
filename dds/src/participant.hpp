// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "discovery_info.hpp"
#include "domain.hpp"
#include "names.hpp"
#include "qos.hpp"

struct ddsi_sertype;

namespace stereogrid::dds {

/// Warnings, each reported once.
class Warnings {
 public:
  explicit Warnings(std::function<void(const std::string&)> warn) : warn_{std::move(warn)} {}

  void tell_once(const std::string& text) {
    {
      const std::scoped_lock lock{mutex_};
      if (!told_.insert(text).second) return;
    }
    if (warn_) warn_(text);
  }

 private:
  std::function<void(const std::string&)> warn_;
  std::mutex mutex_;
  std::set<std::string> told_;
};

/// A topic of Cyclone DDS and its type.
struct DdsTopic {
  dds_entity_t entity;
  ddsi_sertype* type;
};

/// This node in its domain. Owns all its topics, writers and readers.
class Participant {
 public:
  /// Throws ConfigError, DeviceError.
  explicit Participant(const NodeOptions& options);
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  ~Participant();

  [[nodiscard]] dds_entity_t entity() const { return entity_; }
  [[nodiscard]] const Names& names() const { return names_; }
  [[nodiscard]] Warnings& warnings() { return warnings_; }
  [[nodiscard]] dds_guid_t guid() const { return entities_.participant; }

  /// `name`: in DDS.
  [[nodiscard]] DdsTopic make_topic(const std::string& name, const std::string& type);
  /// `topic`: in ROS. Tools of ROS list the writer with this node.
  [[nodiscard]] std::pair<dds_entity_t, ddsi_sertype*> make_writer(const std::string& topic, const std::string& type,
                                                                   Qos qos, const dds_listener_t* listener);
  [[nodiscard]] dds_entity_t make_reader(const std::string& topic, const std::string& type, Qos qos,
                                         const dds_listener_t* listener);
  /// 0: no effect.
  void delete_reader(dds_entity_t reader);

 private:
  /// Adds an endpoint to the list for tools of ROS.
  void add(dds_entity_t entity, std::vector<dds_guid_t>& list);
  void announce();
  static void on_discovery_info(dds_entity_t reader, void* participant) noexcept;
  void set_layout_of(dds_entity_t reader, dds_instance_handle_t peer, Distro layout);

  Names names_;
  Distro distro_;
  Warnings warnings_;
  Domain domain_;
  dds_entity_t entity_;
  dds_entity_t announcer_{0};
  ddsi_sertype* announced_type_{nullptr};
  std::mutex mutex_;  // guards the members below
  Entities entities_;
  std::map<dds_instance_handle_t, Distro> layouts_;  // layout of ros_discovery_info, by peer
  Distro layout_;
};

}  // namespace stereogrid::dds

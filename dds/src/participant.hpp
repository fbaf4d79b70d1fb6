// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "discovery_info.hpp"
#include "names.hpp"
#include "stereogrid/dds/node.hpp"

namespace stereogrid::dds {

// Type of Cyclone DDS whose samples are bytes, which messages/ encodes and decodes. It serves every type of ROS by its
// name, as rmw_cyclonedds does. No keys, CDR of version 1.

/// `name`: "nav_msgs::msg::dds_::OccupancyGrid_". The caller owns it until a topic is made with it.
[[nodiscard]] ddsi_sertype* new_bytes_type(const std::string& name);

/// Sample for dds_writecdr() with a copy of `cdr`, its header of 4 bytes included. Throws InputError: size outside
/// 4 … 2³² − 4 bytes.
[[nodiscard]] ddsi_serdata* new_sample(const ddsi_sertype* type, std::span<const std::byte> cdr);

/// Bytes of a sample from dds_takecdr(); valid while the sample exists.
[[nodiscard]] std::span<const std::byte> bytes_of(const ddsi_serdata* sample);

/// Range of the discovery of peers. localhost: this machine through any interface, as in Jazzy, also for
/// ROS_LOCALHOST_ONLY=1.
enum class DiscoveryRange { subnet, localhost, off };

/// Network of ROS's environment variables.
struct Network {
  dds_domainid_t domain{0};
  DiscoveryRange range{DiscoveryRange::subnet};
  std::vector<std::string> static_peers{};  ///< addresses or names of hosts
};

/// ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS. Throws
/// ConfigError: invalid number, range or host.
[[nodiscard]] Network network_of_environment();

/// Domain of Cyclone DDS, shared by the nodes of a process. CYCLONEDDS_URI overrides its configuration.
class Domain {
 public:
  /// Throws DeviceError.
  explicit Domain(const Network& network);
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;
  ~Domain();

  [[nodiscard]] dds_domainid_t id() const { return id_; }

 private:
  dds_domainid_t id_;
};

/// Returns `code`. Throws DeviceError with `what` if it is an error of Cyclone DDS.
dds_return_t checked(dds_return_t code, const std::string& what);

struct FreeQos {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, FreeQos>;

struct FreeListener {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using Listener = std::unique_ptr<dds_listener_t, FreeListener>;

/// Reliable, keeps the last `depth` messages. `is_transient_local`: late subscribers receive them, too.
[[nodiscard]] Qos reliable_qos(bool is_transient_local, int depth);
/// Matches every publisher.
[[nodiscard]] Qos best_effort_qos(int depth);
/// Sets the endpoint's user data, from which peers since Iron read the hash of its type. Humble ignores it.
void set_type_hash(dds_qos_t* qos, std::string_view ros_type, std::string_view definition);

/// Description of a policy for messages: "liveliness with a lease".
[[nodiscard]] std::string policy_in_words(std::uint32_t policy_id);

/// Warnings, each reported once.
class Warnings {
 public:
  explicit Warnings(std::function<void(const std::string&)> warn) : warn_{std::move(warn)} {}

  void log_once(const std::string& text) {
    {
      const std::scoped_lock lock{mutex_};
      if (!reported_.insert(text).second) return;
    }
    if (warn_) warn_(text);
  }

 private:
  std::function<void(const std::string&)> warn_;
  std::mutex mutex_;
  std::set<std::string> reported_;
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/dds.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>
#include <thread>

// A participant of DDS as ROS 2 makes it, by Cyclone DDS's own code for its types: nothing of stereogrid.

namespace peer {

using Clock = std::chrono::steady_clock;

inline dds_entity_t checked(dds_entity_t code, const char* what) {
  if (code >= 0) return code;
  std::cerr << what << ": " << dds_strretcode(code) << "\n";
  std::exit(1);
}

inline dds_qos_t* qos_of(const std::string& reliability, const std::string& durability, int depth) {
  dds_qos_t* const qos{dds_create_qos()};
  const bool is_reliable{reliability == "reliable"};
  dds_qset_reliability(qos, is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_SECS(1));
  dds_qset_durability(qos, durability == "transient_local" ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth);
  const dds_data_representation_id_t xcdr1{DDS_DATA_REPRESENTATION_XCDR1};
  dds_qset_data_representation(qos, 1, &xcdr1);
  return qos;
}

inline dds_entity_t participant() {
  const char* const domain{std::getenv("ROS_DOMAIN_ID")};
  return checked(
      dds_create_participant(domain == nullptr ? 0 : static_cast<dds_domainid_t>(std::atoi(domain)), nullptr, nullptr),
      "participant");
}

inline dds_entity_t reader(dds_entity_t of, const dds_topic_descriptor_t& type, const std::string& topic,
                           dds_qos_t* qos) {
  const dds_entity_t made{checked(dds_create_topic(of, &type, topic.c_str(), nullptr, nullptr), "topic")};
  return checked(dds_create_reader(of, made, qos, nullptr), "reader");
}

inline dds_entity_t writer(dds_entity_t of, const dds_topic_descriptor_t& type, const std::string& topic,
                           dds_qos_t* qos) {
  const dds_entity_t made{checked(dds_create_topic(of, &type, topic.c_str(), nullptr, nullptr), "topic")};
  return checked(dds_create_writer(of, made, qos, nullptr), "writer");
}

/// Calls `use` with each sample of type T that comes, until it returns false or the time is over. True: it was `use`.
template <class T, class Use>
bool read_for(dds_entity_t reader, double seconds, Use&& use) {
  const auto until{Clock::now() + std::chrono::duration<double>{seconds}};
  while (Clock::now() < until) {
    void* sample{nullptr};
    dds_sample_info_t info{};
    if (checked(dds_take(reader, &sample, &info, 1, 1), "take") == 0) {
      std::this_thread::sleep_for(std::chrono::microseconds{200});
      continue;
    }
    const bool goes_on{!info.valid_data || use(*static_cast<const T*>(sample))};
    dds_return_loan(reader, &sample, 1);
    if (!goes_on) return true;
  }
  return false;
}

inline std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

int publish_pairs(int argc, char** argv);

}  // namespace peer

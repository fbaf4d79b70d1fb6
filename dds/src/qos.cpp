// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "participant.hpp"

#include <new>

#include "names.hpp"

namespace stereogrid::dds {
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

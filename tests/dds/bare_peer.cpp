// SPDX-License-Identifier: Apache-2.0
//
// bare_peer grids TOPIC RELIABILITY DURABILITY COUNT SECONDS: a line for each nav_msgs/OccupancyGrid that comes.
// bare_peer node humble|jazzy NAMESPACE NAME TOPIC SECONDS: what ROS's tools know of a node and of who writes TOPIC.
// bare_peer announce humble|jazzy SECONDS: publishes ros_discovery_info as a node of that distribution does.
// bare_peer pairs …: publish_pairs.cpp.
// Exit code 0: as many came; 2: the time was over.
#include "bare_peer.hpp"

#include <string_view>
#include <type_traits>

#include "ros.h"

namespace peer {
namespace {

constexpr int out_of_time{2};

int read_grids(char** argv) {
  const dds_entity_t of{participant()};
  const dds_entity_t grids{reader(of, nav_msgs_msg_dds__OccupancyGrid__desc, argv[2], qos_of(argv[3], argv[4], 10))};
  int left{std::atoi(argv[5])};
  const bool came{read_for<nav_msgs_msg_dds__OccupancyGrid_>(grids, std::atof(argv[6]), [&](const auto& grid) {
    const std::int64_t stamp_ns{grid.header.stamp.sec * 1'000'000'000LL + grid.header.stamp.nanosec};
    std::uint32_t sum{0};
    for (std::uint32_t i{0}; i < grid.data._length; ++i)
      sum += (i + 1) * static_cast<std::uint32_t>(grid.data._buffer[i]);
    std::cout << "grid " << stamp_ns << ' ' << grid.header.frame_id << ' ' << grid.info.width << 'x' << grid.info.height
              << ' ' << grid.info.resolution << ' ' << grid.info.origin.position.x << ' ' << grid.info.origin.position.y
              << ' ' << grid.info.origin.orientation.w << " sum " << sum << " at " << now_ns() << std::endl;
    return --left > 0;
  })};
  dds_delete(of);
  return came || left == 0 ? 0 : out_of_time;
}

template <class Info>
bool print_node(const Info& info, const std::string& node_namespace, const std::string& name) {
  bool is_there{false};
  for (std::uint32_t i{0}; i < info.node_entities_info_seq._length; ++i) {
    const auto& node{info.node_entities_info_seq._buffer[i]};
    if (node.node_namespace != node_namespace || node.node_name != name) continue;
    is_there = true;
    std::cout << "node " << node.node_namespace << ' ' << node.node_name << " writes";
    for (std::uint32_t j{0}; j < node.writer_gid_seq._length; ++j) {
      std::cout << ' ';
      for (const std::uint8_t byte : std::basic_string_view<std::uint8_t>{node.writer_gid_seq._buffer[j].data, 16}) {
        std::cout << "0123456789abcdef"[byte >> 4] << "0123456789abcdef"[byte & 15];
      }
    }
    std::cout << std::endl;
  }
  return is_there;
}

void print_user_data(const char* what, const dds_qos_t* qos) {
  void* data{nullptr};
  std::size_t size{0};
  if (dds_qget_userdata(qos, &data, &size) && size > 0) {
    std::cout << what << ' ' << std::string_view{static_cast<const char*>(data), size} << std::endl;
  }
  dds_free(data);
}

/// The writers of a topic: number, type, user data.
bool print_writers(dds_entity_t of, const std::string& topic, double seconds) {
  const dds_entity_t found{
      checked(dds_create_reader(of, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr), "publications")};
  return read_for<dds_builtintopic_endpoint_t>(found, seconds, [&](const dds_builtintopic_endpoint_t& one) {
    if (one.topic_name != topic) return true;
    std::cout << "writer ";
    for (const std::uint8_t byte : one.key.v)
      std::cout << "0123456789abcdef"[byte >> 4] << "0123456789abcdef"[byte & 15];
    std::cout << ' ' << one.type_name << std::endl;
    print_user_data("endpoint", one.qos);
    return false;
  });
}

void print_participants(dds_entity_t of) {
  const dds_entity_t found{
      checked(dds_create_reader(of, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr), "participants")};
  read_for<dds_builtintopic_participant_t>(found, 0.2, [&](const dds_builtintopic_participant_t& one) {
    print_user_data("participant", one.qos);
    return true;
  });
}

/// ros_discovery_info's type, whose name both distributions share.
dds_topic_descriptor_t info_type(bool is_humble) {
  const dds_topic_descriptor_t& own{is_humble ? rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc
                                              : since_iron_msg_dds__ParticipantEntitiesInfo__desc};
  return {.m_size = own.m_size,
          .m_align = own.m_align,
          .m_flagset = own.m_flagset & ~DDS_TOPIC_XTYPES_METADATA,  // it has the other name
          .m_nkeys = own.m_nkeys,
          .m_typename = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
          .m_keys = own.m_keys,
          .m_nops = own.m_nops,
          .m_ops = own.m_ops,
          .m_meta = own.m_meta,
          .type_information = {},
          .type_mapping = {},
          .restrict_data_representation = own.restrict_data_representation};
}

template <class Info>
void write_node(dds_entity_t infos) {
  char name[]{"peer"};
  char root[]{"/"};
  Info info{};
  info.node_entities_info_seq._length = info.node_entities_info_seq._maximum = 1;
  std::remove_pointer_t<decltype(info.node_entities_info_seq._buffer)> node{};
  node.node_name = name;
  node.node_namespace = root;
  info.node_entities_info_seq._buffer = &node;
  checked(dds_write(infos, &info), "write");
}

int announce(char** argv) {
  const dds_entity_t of{participant()};
  const bool is_humble{std::string_view{argv[2]} == "humble"};
  const dds_topic_descriptor_t type{info_type(is_humble)};
  const dds_entity_t infos{writer(of, type, "ros_discovery_info", qos_of("reliable", "transient_local", 1))};
  if (is_humble) {
    write_node<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_>(infos);
  } else {
    write_node<since_iron_msg_dds__ParticipantEntitiesInfo_>(infos);
  }
  std::cout << "announced" << std::endl;
  std::this_thread::sleep_for(std::chrono::duration<double>{std::atof(argv[3])});
  dds_delete(of);
  return 0;
}

int look_at_node(char** argv) {
  const dds_entity_t of{participant()};
  const bool is_humble{std::string_view{argv[2]} == "humble"};
  const std::string node_namespace{argv[3]}, name{argv[4]};
  const double seconds{std::atof(argv[6])};
  const dds_topic_descriptor_t type{info_type(is_humble)};
  const dds_entity_t infos{reader(of, type, "ros_discovery_info", qos_of("reliable", "transient_local", 100))};
  if (!print_writers(of, argv[5], seconds)) return out_of_time;
  const auto print = [&](const auto& info) { return !print_node(info, node_namespace, name); };
  const bool came{is_humble ? read_for<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_>(infos, seconds, print)
                            : read_for<since_iron_msg_dds__ParticipantEntitiesInfo_>(infos, seconds, print)};
  print_participants(of);
  dds_delete(of);
  return came ? 0 : out_of_time;
}

}  // namespace
}  // namespace peer

int main(int argc, char** argv) {
  const std::string_view what{argc > 1 ? argv[1] : ""};
  if (what == "grids" && argc == 7) return peer::read_grids(argv);
  if (what == "node" && argc == 7) return peer::look_at_node(argv);
  if (what == "announce" && argc == 4) return peer::announce(argv);
  if (what == "pairs") return peer::publish_pairs(argc, argv);
  std::cerr << "grids, node, announce or pairs\n";
  return 1;
}

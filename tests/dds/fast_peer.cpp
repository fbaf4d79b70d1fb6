// SPDX-License-Identifier: Apache-2.0
//
// A participant of Fast DDS, the other middleware of ROS 2, whose nav_msgs/OccupancyGrid is written out by hand for its
// own CDR.
// fast_peer grids TOPIC RELIABILITY DURABILITY COUNT SECONDS: a line for each that comes.
// fast_peer publish TOPIC RELIABILITY DURABILITY WIDTH SECONDS: sends WIDTH × WIDTH cells, (7·index + 1) mod 101, at 10
// Hz.
#include <fastcdr/Cdr.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include <array>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t largest_bytes{4 << 20};

struct Grid {
  std::int32_t sec{0};
  std::uint32_t nanosec{0};
  std::string frame;
  std::int32_t load_sec{0};
  std::uint32_t load_nanosec{0};
  float resolution{0};
  std::uint32_t width{0};
  std::uint32_t height{0};
  std::array<double, 7> origin{};
  std::vector<std::int8_t> data;

  template <class Cdr>
  void visit(Cdr&& each) {
    each(sec), each(nanosec), each(frame), each(load_sec), each(load_nanosec), each(resolution), each(width),
        each(height), each(origin), each(data);
  }
};

class GridType final : public fast::TopicDataType {
 public:
  GridType() {
    setName("nav_msgs::msg::dds_::OccupancyGrid_");
    m_typeSize = largest_bytes;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    eprosima::fastcdr::FastBuffer buffer{reinterpret_cast<char*>(payload->data), payload->max_size};
    eprosima::fastcdr::Cdr cdr{buffer, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR};
    cdr.serialize_encapsulation();
    static_cast<Grid*>(data)->visit([&](const auto& field) { cdr << field; });
    payload->encapsulation = CDR_LE;
    payload->length = static_cast<std::uint32_t>(cdr.getSerializedDataLength());
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    eprosima::fastcdr::FastBuffer buffer{reinterpret_cast<char*>(payload->data), payload->length};
    eprosima::fastcdr::Cdr cdr{buffer, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR};
    cdr.read_encapsulation();
    static_cast<Grid*>(data)->visit([&](auto& field) { cdr >> field; });
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Grid*>(data)->data.size() + 512); };
  }
  void* createData() override { return new Grid; }
  void deleteData(void* data) override { delete static_cast<Grid*>(data); }
  bool getKey(void* /*data*/, rtps::InstanceHandle_t* /*handle*/, bool /*by_md5*/) override { return false; }
};

/// On 127.0.0.1 only, without multicast.
fast::DomainParticipant* participant() {
  fast::DomainParticipantQos qos;
  const auto udp{std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>()};
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  rtps::Locator_t peer;
  rtps::IPLocator::setIPv4(peer, 127, 0, 0, 1);
  qos.wire_protocol().builtin.initialPeersList.push_back(peer);
  const char* const domain{std::getenv("ROS_DOMAIN_ID")};
  return fast::DomainParticipantFactory::get_instance()->create_participant(
      domain == nullptr ? 0 : static_cast<std::uint32_t>(std::atoi(domain)), qos);
}

template <class Qos>
Qos with(Qos qos, const std::string& reliability, const std::string& durability) {
  qos.reliability().kind =
      reliability == "reliable" ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind =
      durability == "transient_local" ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 1;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return qos;
}

void print(const Grid& grid) {
  std::uint32_t sum{0};
  for (std::size_t i{0}; i < grid.data.size(); ++i) sum += static_cast<std::uint32_t>((i + 1) * grid.data[i]);
  std::cout << "grid " << grid.sec * 1'000'000'000LL + grid.nanosec << ' ' << grid.frame << ' ' << grid.width << 'x'
            << grid.height << ' ' << grid.resolution << ' ' << grid.origin[0] << ' ' << grid.origin[1] << ' '
            << grid.origin[6] << " sum " << sum << " at "
            << std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
                   .count()
            << std::endl;
}

int read_grids(fast::DomainParticipant& of, fast::Topic* topic, char** argv) {
  fast::Subscriber* const subscriber{of.create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)};
  fast::DataReader* const reader{
      subscriber->create_datareader(topic, with(fast::DATAREADER_QOS_DEFAULT, argv[3], argv[4]))};
  int left{std::atoi(argv[5])};
  const auto until{Clock::now() + std::chrono::duration<double>{std::atof(argv[6])}};
  while (left > 0 && Clock::now() < until) {
    Grid grid;
    fast::SampleInfo info;
    if (reader->take_next_sample(&grid, &info) != ReturnCode_t::RETCODE_OK) {
      std::this_thread::sleep_for(std::chrono::milliseconds{1});
    } else if (info.valid_data) {
      print(grid);
      --left;
    }
  }
  return left == 0 ? 0 : 2;
}

int publish_grids(fast::DomainParticipant& of, fast::Topic* topic, char** argv) {
  fast::Publisher* const publisher{of.create_publisher(fast::PUBLISHER_QOS_DEFAULT)};
  fast::DataWriter* const writer{
      publisher->create_datawriter(topic, with(fast::DATAWRITER_QOS_DEFAULT, argv[3], argv[4]))};
  Grid grid;
  grid.sec = 1'700'000'001;
  grid.nanosec = 123'456'789;
  grid.frame = "odom";
  grid.resolution = 0.25F;
  grid.origin = {-12.5, 3.75, 0, 0, 0, 0, 1};
  grid.width = grid.height = static_cast<std::uint32_t>(std::atoi(argv[5]));
  for (std::size_t i{0}; i < std::size_t{grid.width} * grid.height; ++i) {
    grid.data.push_back(static_cast<std::int8_t>((7 * i + 1) % 101));
  }
  const auto until{Clock::now() + std::chrono::duration<double>{std::atof(argv[6])}};
  for (; Clock::now() < until; std::this_thread::sleep_for(std::chrono::milliseconds{100})) writer->write(&grid);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) return 1;
  fast::DomainParticipant* const of{participant()};
  if (of == nullptr) return 1;
  fast::TypeSupport type{new GridType};
  type.register_type(of);
  fast::Topic* const topic{of->create_topic(argv[2], type.get_type_name(), fast::TOPIC_QOS_DEFAULT)};
  return std::string{argv[1]} == "grids" ? read_grids(*of, topic, argv) : publish_grids(*of, topic, argv);
}

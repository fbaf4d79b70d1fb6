// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stereogrid/io/recording.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/rosbag/rosbag.hpp"

namespace stereogrid::rosbag {

/// Position of an image in a bag.
struct Shot {
  std::int64_t stamp_ns{0};   ///< time of exposure
  std::int64_t header_ns{0};  ///< as the message says; the same but where cameras do not stamp their images
  std::uint64_t log_ns{0};
};
using ShotPair = std::pair<Shot, Shot>;

/// Images of a topic in the order of their stamps. Where no header has a stamp it is when they were recorded.
struct Shots {
  std::vector<Shot> shots;
  bool are_stamped{true};
  std::size_t damaged{0};  ///< messages that are none
};
[[nodiscard]] Shots find_shots(const mcap::Bag& bag, const std::string& topic);

/// Pairs of equal stamps; then, of the others, those that are each other's nearest and no farther apart than that.
[[nodiscard]] std::vector<ShotPair> pair_up(const std::vector<Shot>& left, const std::vector<Shot>& right,
                                            std::int64_t tolerance_ns);

/// Messages of grids of another source, and the place of their frame.
struct BagGrids {
  GridTopics topics;
  std::vector<Shot> cells;        ///< in the order of their stamps
  std::vector<Shot> certainty{};  ///< none: the cells have that of binary grids
  Pose2 base_from_grid{};         ///< base: the vehicle, or the world
  bool is_in_world{false};        ///< the frame of the grids is that of the poses
};

/// Finds the images of a bag again.
class BagImages final : public io::ImageStore {
 public:
  /// `name`: of the bag, for error messages.
  BagImages(std::unique_ptr<mcap::Bag> bag, std::string name, ImageTopics topics, std::vector<ShotPair> pairs);

  [[nodiscard]] io::ImagePair load(std::size_t index) const override;
  [[nodiscard]] std::optional<io::PlacedGrid> load_grid(std::size_t index) const override;
  void set_grids(BagGrids grids) { grids_ = std::move(grids); }
  /// The first pair that can be read; finds sample_bits(). Throws InputError: there is none.
  io::ImagePair begin();
  /// RecordingContents::sample_bits
  [[nodiscard]] int sample_bits() const { return sample_bits_; }

 private:
  void find_sample_bits();
  [[nodiscard]] std::vector<std::byte> bytes_of(const std::string& topic, const Shot& shot) const;

  std::unique_ptr<mcap::Bag> bag_;
  std::string name_;
  ImageTopics topics_;
  mcap::Topic left_;
  mcap::Topic right_;
  std::vector<ShotPair> pairs_;
  BagGrids grids_;
  int sample_bits_{8};
  mutable std::mutex mutex_;  // a bag is used by one thread at a time
};

/// frame_id of the first message that can be decoded; "": none.
[[nodiscard]] std::string frame_of_first(const mcap::Bag& bag, const std::string& topic);

/// Finds grids of another program, and where they lie: by /tf_static, or in the frame of the poses. `asked`: as for
/// choose_grid_topics().
void find_grids(io::ForeignRecording& found, BagImages& images, const mcap::Bag& bag, const std::string& asked,
                const std::string& camera_frame, const std::string& world_frame);

}  // namespace stereogrid::rosbag

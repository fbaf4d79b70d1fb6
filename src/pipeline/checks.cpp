// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_input.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "filter/model.hpp"
#include "matching/matching.hpp"
#include "pipeline/settings.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

constexpr int image_side_max{16384};
constexpr int threads_max{1024};
constexpr double farthest_m{1e9};
constexpr double horizon_max_s{1e4};

// As parts of topics of ROS 2 are.
bool is_camera_name(const std::string& name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !name.empty() && is_letter(name.front()) &&
         std::ranges::all_of(name, [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

void check_grid(const ObservedGrid& grid, const StereoFrame& frame) {
  const GridGeometry& geometry{grid.geometry};
  const auto fits = [&](const auto& image) { return image.width() == geometry.nx && image.height() == geometry.ny; };
  const auto are_shares = [](const auto& image) {
    return std::all_of(image.begin(), image.end(), [](float p) { return p >= 0 && p <= 1; });
  };
  const auto require = [&](bool fine, const char* problem, const char* remedy) {
    if (!fine) throw InputError{title_of(frame), problem, remedy};
  };
  require(std::isfinite(geometry.x_min_m) && std::isfinite(geometry.y_min_m) && std::isfinite(geometry.cell_size_m) &&
              geometry.cell_size_m > 0,
          "another source's grid has no place.", "Its origin and cell size must be finite, cells larger than 0.");
  require(fits(grid.occupancy) && (grid.confidence.empty() || fits(grid.confidence)),
          "another source's grid does not have its geometry's size.",
          "Occupancy and confidence must be nx × ny cells; confidence may be left empty.");
  require(are_shares(grid.occupancy) && are_shares(grid.confidence),
          "another source's grid has values that are not probabilities.",
          "Occupancy and confidence must lie in 0 … 1; unknown is 0.5.");
}

template <class Pixel>
void check_image(const char* which, const View<const Pixel>& image, const Rig& rig, const StereoFrame& frame) {
  const auto size = [](int width, int height) { return std::to_string(width) + " × " + std::to_string(height); };
  const auto refuse = [&](const std::string& problem, const std::string& remedy) {
    throw InputError{title_of(frame), which + (" has " + problem), remedy};
  };
  if (image.width != rig.width_px || image.height != rig.height_px) {
    refuse(size(image.width, image.height) + " pixels.",
           "The calibration is of " + size(rig.width_px, rig.height_px) + ".");
  }
  if (image.data == nullptr) refuse("a size, but no pixels.", "Give the address of its first one.");
  if (image.pitch > -image.width && image.pitch < image.width) {
    refuse("rows that overlap: pitch " + std::to_string(image.pitch) + " (allowed " + std::to_string(image.width) +
               " and more).",
           "The pitch counts elements from row to row; images stored upside down have a negative one.");
  }
}

void check_images(const FrameImages& images, const Rig& rig, const StereoFrame& frame) {
  if (images.right.empty() && images.disparity.empty()) {
    throw InputError{title_of(frame), "has neither a right image nor disparities.", "Give one of them, or both."};
  }
  check_image("left", images.left, rig, frame);
  if (!images.right.empty()) check_image("right", images.right, rig, frame);
  if (!images.disparity.empty()) check_image("disparity", images.disparity, rig, frame);
}

}  // namespace

void check(const Config& config, std::span<const Rig> rigs, const PipelineOptions& options) {
  std::vector<std::string> found{problems(config)};
  const auto require = [&](bool fine, const std::string& problem) {
    if (!fine) found.push_back(problem);
  };
  require(!rigs.empty() && rigs.size() <= cameras_max, "The number of rigs must lie in 1 … 8.");
  for (std::size_t i{0}; i < rigs.size(); ++i) {
    const Rig& rig{rigs[i]};
    const std::string name{rigs.size() == 1 ? "rig: " : "rig " + std::to_string(i) + ": "};
    for (const std::string& problem : problems(rig)) found.push_back(name + problem);
    require(rig.width_px != 0 && rig.height_px != 0, name + "the image size must be positive.");
    require(std::max(rig.width_px, rig.height_px) <= image_side_max,
            name + "images of up to 16384 × 16384 can be matched.");
  }
  require(config.matching.disparities != 1, "matching.disparities must be 0 (automatic) or at least 2.");
  require(options.back_end >= BackEnd::cpu && options.back_end <= BackEnd::automatic,
          "There is no such back end: it is cpu, reference, cuda or automatic.");
  require(options.device >= 0, "The device must be 0 or more: GPUs are counted from 0.");
  require(options.threads >= 0 && options.threads <= threads_max,
          "The number of threads must lie in 0 (all cores) … 1024.");
  for (std::size_t i{0}; i < rigs.size(); ++i) {
    const Image<std::uint8_t>& mask{mask_of(options, i)};
    const std::string which{rigs.size() == 1 ? "The mask" : "The mask of camera " + std::to_string(i)};
    require(mask.empty() || (mask.width() == rigs[i].width_px && mask.height() == rigs[i].height_px),
            which + " must have the size of the rig's images, or be empty.");
    require(mask.empty() || std::ranges::any_of(mask, [](std::uint8_t pixel) { return pixel != 0; }),
            which + " leaves no pixel: 0 is a pixel that shows the vehicle, any other number one that is used.");
  }
  require(options.other_masks.empty() || options.other_masks.size() < rigs.size(),
          "There are more masks than rigs: give one for each camera at most.");
  const std::vector<std::string>& names{options.camera_names};
  require(names.empty() || (names.size() == rigs.size() && std::ranges::all_of(names, is_camera_name) &&
                            std::set<std::string>(names.begin(), names.end()).size() == names.size()),
          "The names of the cameras must be one for each rig, all different: a letter, then letters, digits and _.");
  require(std::ranges::all_of(options.horizons_s, [](double s) { return s > 0 && s <= horizon_max_s; }),
          "Predictions need horizons in seconds, more than 0 and at most 10000, as in 0.5,1,2.");
  require(is_place(options.start),
          "The vehicle's place at the start must be finite, and within 1e9 m of the world's origin.");
  if (found.empty()) return;
  std::string message;
  for (const std::string& problem : found) message += (message.empty() ? "" : "\n") + problem;
  throw ConfigError{message};
}

void check(const StereoFrame& frame, const FrameImages& images, const Rig& rig) {
  check_images(images, rig, frame);
  const Pose2 pose{frame.world_from_vehicle.value_or(Pose2{})};
  if (!std::isfinite(pose.x_m) || !std::isfinite(pose.y_m) || !std::isfinite(pose.yaw_rad)) {
    throw InputError{title_of(frame), "its pose is not finite.", "Give numbers, or leave the pose out."};
  }
  if (!is_place(pose)) {
    throw InputError{title_of(frame), "its pose is farther than 1e9 m from the origin.",
                     "Give metres, in a frame whose origin is on the same planet, or leave the pose out."};
  }
  for (const ObservedGrid& grid : frame.other_grids) check_grid(grid, frame);
  const Image<std::uint8_t>& labels{frame.labels};
  if (labels.empty()) return;
  if (labels.width() != rig.width_px || labels.height() != rig.height_px) {
    throw InputError{title_of(frame), "has labels of another size than the rig's images.", "Give one per pixel."};
  }
  if (std::ranges::any_of(labels, [](std::uint8_t label) { return label >= names_of(PixelLabel{}).size(); })) {
    throw InputError{title_of(frame), "has labels that are none.", "They are values of PixelLabel, 0 to 4."};
  }
}

bool is_place(const Pose2& pose) {
  return std::abs(pose.x_m) <= farthest_m && std::abs(pose.y_m) <= farthest_m && std::isfinite(pose.yaw_rad);
}

}  // namespace stereogrid

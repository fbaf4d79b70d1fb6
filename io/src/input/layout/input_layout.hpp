// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cctype>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {

enum class InputKind { kitti_odometry, kitti_raw, euroc, plain_folder, image_pair };

/// Paths of the parts of an input; empty if missing.
struct InputLayout {
  InputKind kind{InputKind::plain_folder};
  std::filesystem::path root;
  std::filesystem::path left;  ///< folder of images, or the image itself
  std::filesystem::path right;
  std::filesystem::path calibration;
  std::filesystem::path scans;
  KittiPair pair{KittiPair::grey};
  std::filesystem::path disparities{};  ///< folder that stands in for the right images
  bool is_shared{false};                ///< each image shows both cameras; `left` is the folder of all
  bool with_right{false};               ///< `disparities` come beside the right images
};

/// "KITTI odometry sequence" and so on.
[[nodiscard]] std::string name_of(InputKind kind);

/// calibration.yaml of a folder, or calibration.yml, calib.yaml, calib.yml; empty: none of them is there.
[[nodiscard]] std::filesystem::path own_calibration_in(const std::filesystem::path& folder);

/// Recognises an input. `disparities`: a folder to take instead of right images; none: that of a plain folder without
/// right images. Throws InputError: nothing there, or nothing that is known.
[[nodiscard]] InputLayout recognise(const std::vector<std::filesystem::path>& paths,
                                    const std::optional<std::filesystem::path>& disparities);

/// Numbers of the pair's cameras in a Kalibr file, by the names of their folders (cam0, cam2), ascending; else 0 and 1.
[[nodiscard]] std::array<int, 2> camera_numbers(const InputLayout& layout);

/// Depth, not disparities, by the folder's name.
[[nodiscard]] bool is_depth_folder(const std::filesystem::path& folder);

/// The frames, left images paired by name with right or disparity images; a frame one of whose images is missing is
/// marked. Throws InputError: no images, no pair.
[[nodiscard]] std::vector<RecordedFrame> find_frames(const InputLayout& layout);

/// Sorts names as people do: frame_9 before frame_10.
struct NaturalOrder {
  [[nodiscard]] bool operator()(std::string_view a, std::string_view b) const {
    const std::string_view whole_a{a};
    const std::string_view whole_b{b};
    while (!a.empty() && !b.empty()) {
      const std::string_view number_a{digits_of(a)};
      const std::string_view number_b{digits_of(b)};
      if (number_a.empty() || number_b.empty()) {
        if (a[0] != b[0]) return a[0] < b[0];
        a.remove_prefix(1);
        b.remove_prefix(1);
        continue;
      }
      const std::string_view value_a{without_zeros(number_a)};
      const std::string_view value_b{without_zeros(number_b)};
      if (value_a.size() != value_b.size()) return value_a.size() < value_b.size();
      if (value_a != value_b) return value_a < value_b;
      a.remove_prefix(number_a.size());
      b.remove_prefix(number_b.size());
    }
    if (a.empty() != b.empty()) return a.empty();
    return whole_a < whole_b;  // 01 and 1 are two names
  }

 private:
  static std::string_view digits_of(std::string_view text) {
    std::size_t count{0};
    while (count < text.size() && std::isdigit(static_cast<unsigned char>(text[count])) != 0) ++count;
    return text.substr(0, count);
  }

  static std::string_view without_zeros(std::string_view digits) {
    const std::size_t first{digits.find_first_not_of('0')};
    return first == std::string_view::npos ? std::string_view{} : digits.substr(first);
  }
};

/// Images by their name without extension.
using Images = std::map<std::string, std::filesystem::path, NaturalOrder>;

inline const std::set<std::string> image_extensions{".png",  ".pgm", ".ppm",  ".pnm",  ".jpg",
                                                    ".jpeg", ".tif", ".tiff", ".webp", ".bmp"};

/// Throws InputError: two of one name, names too long.
[[nodiscard]] Images images_in(const std::filesystem::path& folder, const std::set<std::string>& extensions);

/// The name of a frame is also that of files. Throws InputError where it is too long.
void check_length(const std::filesystem::path& file, const std::string& name);

/// Images of both cameras by the rest of their names; none: no two differ in a word for the side only.
struct NamedSides {
  Images left;
  Images right;
};

[[nodiscard]] std::optional<NamedSides> split_by_name(const Images& left, const Images& right);

/// Paths of a frame's files in a truth/ folder.
struct TruthFiles {
  std::filesystem::path disparity, label, instance, seen_by_both, cells;

  TruthFiles(const std::filesystem::path& folder, const std::string& name)
      : disparity{folder / "disparity" / (name + ".png")},
        label{folder / "label" / (name + ".png")},
        instance{folder / "instance" / (name + ".png")},
        seen_by_both{folder / "seen_by_both" / (name + ".png")},
        cells{folder / "cells" / (name + ".npz")} {}
};

/// disparity/NAME.png holds disparities times this.
constexpr float disparity_scale{256};

}  // namespace stereogrid::io

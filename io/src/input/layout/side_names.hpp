// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace stereogrid::io {

/// Words for the two cameras in names of files and folders.
struct SideWords {
  std::string_view left;
  std::string_view right;
};

// The first that fits: cam1 is the right camera beside cam0, and the left one beside cam2.
inline constexpr std::array<SideWords, 27> all_side_words{{{"left", "right"},
                                                           {"cam0", "cam1"},
                                                           {"cam_0", "cam_1"},
                                                           {"camera0", "camera1"},
                                                           {"camera_0", "camera_1"},
                                                           {"im0", "im1"},
                                                           {"img0", "img1"},
                                                           {"image0", "image1"},
                                                           {"image_0", "image_1"},
                                                           {"colored_0", "colored_1"},
                                                           {"infra1", "infra2"},
                                                           {"cam1", "cam2"},
                                                           {"cam_1", "cam_2"},
                                                           {"camera1", "camera2"},
                                                           {"camera_1", "camera_2"},
                                                           {"cam2", "cam3"},
                                                           {"view0", "view1"},
                                                           {"view1", "view5"},
                                                           {"i1", "i2"},
                                                           {"l", "r"},
                                                           {"caml", "camr"},
                                                           {"lcam", "rcam"},
                                                           {"cameral", "camerar"},
                                                           {"imgl", "imgr"},
                                                           {"imagel", "imager"},
                                                           {"cam_b", "cam_c"},
                                                           {"cam0", "cam2"}}};
// For folders only: numbers in names of images count frames.
inline constexpr SideWords numbered_folders{"0", "1"};

/// The name in lower case without the word and one separator beside it. None: the word is not there. "left" and
/// "right" may be a part of a longer word, others stand alone.
[[nodiscard]] std::optional<std::string> without_word(std::string_view name, std::string_view word);

/// True where a name has another number than the two of the words: images are counted, as img0, img1 and img2 are.
[[nodiscard]] bool are_counted(const std::vector<std::string>& names, const SideWords& words);

struct SideFolders {
  std::filesystem::path left;
  std::filesystem::path right;
};

/// Two folders among `folders` whose names differ in the words for the cameras only.
[[nodiscard]] std::optional<SideFolders> side_folders(const std::vector<std::filesystem::path>& folders);

}  // namespace stereogrid::io

// SPDX-FileCopyrightText: 2026 The stereogrid authors
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
inline constexpr std::array<SideWords, 12> all_side_words{{{"left", "right"},
                                                           {"cam0", "cam1"},
                                                           {"cam_0", "cam_1"},
                                                           {"camera0", "camera1"},
                                                           {"camera_0", "camera_1"},
                                                           {"im0", "im1"},
                                                           {"img0", "img1"},
                                                           {"image0", "image1"},
                                                           {"infra1", "infra2"},
                                                           {"cam1", "cam2"},
                                                           {"camera1", "camera2"},
                                                           {"l", "r"}}};

/// The name in lower case without the word and one separator beside it. None: the word is not there. "left" and
/// "right" may be a part of a longer word, others stand alone.
[[nodiscard]] std::optional<std::string> without_word(std::string_view name, std::string_view word);

struct SideFolders {
  std::filesystem::path left;
  std::filesystem::path right;
};

/// Two folders among `folders` whose names differ in the words for the cameras only.
[[nodiscard]] std::optional<SideFolders> side_folders(const std::vector<std::filesystem::path>& folders);

}  // namespace stereogrid::io

// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <map>
#include <set>

#include "input/layout/input_layout.hpp"
#include "input/layout/side_names.hpp"
#include "input/poses/kitti_text.hpp"
#include "input/poses/recording_poses.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

const std::set<std::string> disparity_extensions{".png", ".pfm", ".tif", ".tiff", ".npy", ".npz"};

std::string lowercase(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// A line of frames.txt: a frame's name, or the name of its image.
std::string name_in(std::string_view line, const Images& left, const Images& right) {
  std::string name{frame_name(line)};
  if (left.contains(name) || right.contains(name)) return name;
  std::string stem{fs::path{name}.stem().string()};
  return left.contains(stem) || right.contains(stem) ? stem : name;
}

/// frames.txt: a name per line; lines of poses*.txt and times.txt belong to them.
std::vector<std::string> names_in(const fs::path& frames_file, const Images& left, const Images& right) {
  const std::string text{read_text(frames_file, largest_bytes::lines)};
  std::vector<std::string> names;
  std::set<std::string> known;
  for (const std::string_view line : lines_of(text)) {
    const auto start{line.find_first_not_of(" \t")};
    if (start == std::string_view::npos) continue;
    names.push_back(name_in(line.substr(start, line.find_last_not_of(" \t") - start + 1), left, right));
    if (!known.insert(names.back()).second) {
      throw InputError{printable_path(frames_file), "names frame " + names.back() + " twice.",
                       "Name each frame once, in their order."};
    }
  }
  const auto is_there{[&](const std::string& name) { return left.contains(name) || right.contains(name); }};
  if (std::ranges::any_of(names, is_there)) return names;
  throw InputError{
      printable_path(frames_file),
      names.empty() ? "names no frames." : "names no frame that is there; the first is " + names.front() + ".",
      "A line is the name of a frame's images, such as " + left.begin()->first +
          "; without the file every image is taken."};
}

struct Side {
  fs::path folder;
  Images images;

  /// Path of the image, also if missing.
  [[nodiscard]] fs::path path_of(const std::string& name) const {
    const auto found{images.find(name)};
    return found != images.end() ? found->second : folder / (name + images.begin()->second.extension().string());
  }
};

struct Sides {
  Side left;
  Side right;        ///< may be empty where there are disparities
  Side disparities;  ///< no folder: none

  /// Second side of a left image.
  [[nodiscard]] const Side& second() const { return disparities.folder.empty() ? right : disparities; }
};

struct OtherFormat {
  const char* extension;
  const char* name;
};
constexpr OtherFormat other_formats[]{{".jp2", "JPEG 2000"},   {".j2k", "JPEG 2000"},  {".jpx", "JPEG 2000"},
                                      {".avif", "AVIF"},       {".heic", "HEIC"},      {".heif", "HEIC"},
                                      {".jxl", "JPEG XL"},     {".exr", "OpenEXR"},    {".hdr", "Radiance HDR"},
                                      {".gif", "GIF"},         {".dng", "raw images"}, {".raw", "raw samples"},
                                      {".bin", "raw samples"}, {".mat", "MATLAB"},     {".pkl", "Python's pickle"}};

/// "12 files .jp2 (JPEG 2000)"; empty: none of the formats that people bring.
std::string other_images_in(const fs::path& folder) {
  const std::vector<fs::path> entries{entries_of(folder)};
  for (const OtherFormat& format : other_formats) {
    const auto count{std::ranges::count_if(
        entries, [&](const fs::path& entry) { return lowercase(entry.extension().string()) == format.extension; })};
    if (count > 0) return fmt::format("{} files {} ({})", count, format.extension, format.name);
  }
  return {};
}

Side side_of(const fs::path& folder, const std::set<std::string>& extensions, const char* mend) {
  Side side{folder, images_in(folder, extensions)};
  if (side.images.empty()) {
    const std::string others{other_images_in(folder)};
    throw InputError{printable_path(folder),
                     others.empty() ? "holds no images." : "holds no images that are read, but " + others + ".",
                     others.empty() ? mend : "Convert them to PNG, or depth and disparities to NPY or TIFF of floats."};
  }
  return side;
}

/// Frames go by what their names have in common, where no left image has a right one of the same name.
void pair_by_side_words(Sides& sides) {
  const bool is_one_folder{sides.left.folder == sides.right.folder};
  const auto has_partner{[&](const auto& image) { return sides.right.images.contains(image.first); }};
  if (!is_one_folder && std::ranges::any_of(sides.left.images, has_partner)) return;
  auto named{split_by_name(sides.left.images, sides.right.images)};
  if (!named) return;
  sides.left.images = std::move(named->left);
  sides.right.images = std::move(named->right);
}

/// Images whose names are stamps take those of the left images that are nearest, where none has the same name.
void pair_by_stamps(const Images& left, Images& second, std::int64_t farthest_ns) {
  const auto is_named_alike{[&](const auto& image) { return second.contains(image.first); }};
  const auto is_stamp{[](const auto& image) { return stamp_in(image.first).has_value(); }};
  if (std::ranges::any_of(left, is_named_alike) || !std::ranges::all_of(left, is_stamp) ||
      !std::ranges::all_of(second, is_stamp)) {
    return;
  }
  std::vector<double> stamps;
  for (const auto& image : left) stamps.push_back(static_cast<double>(*stamp_in(image.first)));
  const StampUnit unit{stamp_unit(stamps, stamp_units.front(), printable_path(left.begin()->second.parent_path()))};
  Images paired;
  for (const auto& image : left) {
    const std::int64_t stamp{*stamp_in(image.first)};
    const auto away{[&](const auto& other) { return std::abs(*stamp_in(other.first) - stamp); }};
    const auto nearest{std::ranges::min_element(second, {}, away)};
    if (nearest == second.end() || away(*nearest) > farthest_ns / unit.ns) continue;
    paired.emplace(image.first, nearest->second);
    second.erase(nearest);
  }
  second = std::move(paired);
}

/// Disparities or depth whose names have a word more than those of their images (000000_left_depth), or another one
/// (rgb_0000, distance_to_image_plane_0000).
void pair_by_words(const Images& left, Images& second) {
  if (std::ranges::any_of(left, [&](const auto& image) { return second.contains(image.first); })) return;
  constexpr std::string_view of_second[]{"depth_image",        "depthimage", "depth_meter", "distance_to_image_plane",
                                         "distance_to_camera", "depth",      "disparity",   "disp"};
  constexpr std::string_view of_left[]{"", "rgb", "color", "colour", "image", "img", "left"};
  for (const std::string_view second_word : of_second) {
    std::map<std::string, fs::path> rests;
    for (const auto& image : second) {
      if (auto rest{without_word(image.first, second_word)}) rests.emplace(*rest, image.second);
    }
    for (const std::string_view left_word : of_left) {
      Images paired;
      for (const auto& image : left) {
        const auto rest{left_word.empty() ? std::optional{lowercase(image.first)}
                                          : without_word(image.first, left_word)};
        const auto found{rest ? rests.find(*rest) : rests.end()};
        if (found != rests.end()) paired.emplace(image.first, found->second);
      }
      if (paired.empty()) continue;
      second = std::move(paired);
      return;
    }
  }
}

/// The only image and its disparities (im0.png, disp0.pfm; disp1.pfm is the right one's).
void pair_single(const Images& left, Images& disparities) {
  if (left.size() != 1 || disparities.contains(left.begin()->first)) return;
  const fs::path first{disparities.begin()->second};
  disparities = {{left.begin()->first, first}};
}

constexpr std::int64_t farthest_right_ns{10'000'000};
constexpr std::int64_t farthest_depth_ns{20'000'000};

Sides sides_of(const InputLayout& layout) {
  const char* const mend{"PNG, PGM or JPEG files belong there, one per frame."};
  Sides sides;
  if (layout.kind == InputKind::image_pair) {
    sides.left = {layout.left.parent_path(), {{frame_name(layout.left.stem().string()), layout.left}}};
  } else {
    sides.left = side_of(layout.left, image_extensions, mend);
  }
  if (layout.disparities.empty()) {
    sides.right = side_of(layout.right, image_extensions, mend);
    pair_by_side_words(sides);
    pair_by_stamps(sides.left.images, sides.right.images, farthest_right_ns);
    return sides;
  }
  const bool is_one_folder{layout.disparities == layout.left && layout.left == layout.root};
  sides.disparities = side_of(layout.disparities, is_one_folder ? std::set<std::string>{".pfm"} : disparity_extensions,
                              "Disparities as PNG, PFM, TIFF or NPY belong there, one per left image.");
  if (is_one_folder) pair_single(sides.left.images, sides.disparities.images);
  pair_by_words(sides.left.images, sides.disparities.images);
  pair_by_stamps(sides.left.images, sides.disparities.images, farthest_depth_ns);
  // the drive's lines of poses and stamps belong to the frames of either camera
  if (layout.with_right) {
    sides.right = side_of(layout.right, image_extensions, mend);
    pair_by_stamps(sides.left.images, sides.right.images, farthest_right_ns);
  } else if (is_folder(layout.right)) {
    sides.right = {layout.right, images_in(layout.right, image_extensions)};
  }
  return sides;
}

/// Names of the frames in their order: those of frames.txt, else every image of either camera.
std::vector<std::string> order_of(const InputLayout& layout, const Images& left, const Images& right) {
  const auto frames_file{layout.root / "frames.txt"};
  if (layout.kind != InputKind::kitti_raw && is_there(frames_file)) return names_in(frames_file, left, right);
  std::set<std::string, NaturalOrder> names;
  for (const auto& [name, path] : left) names.insert(name);
  for (const auto& [name, path] : right) names.insert(name);
  return {names.begin(), names.end()};
}

}  // namespace

std::vector<RecordedFrame> find_frames(const InputLayout& layout) {
  if (layout.kind == InputKind::image_pair && layout.disparities.empty()) {
    const std::string name{frame_name(layout.left.stem().string())};
    check_length(layout.left, name);
    return {{name, 0, layout.left, layout.right, true, true, {}, {}, {}}};
  }
  const Sides sides{sides_of(layout)};
  const std::vector<fs::path> scans{is_folder(layout.scans) ? entries_of(layout.scans) : std::vector<fs::path>{}};
  std::vector<RecordedFrame> frames;
  for (const std::string& name : order_of(layout, sides.left.images, sides.right.images)) {
    RecordedFrame& frame{frames.emplace_back()};
    frame.name = name;
    frame.left = sides.left.path_of(name);
    frame.left_exists = sides.left.images.contains(name);
    frame.right_exists = sides.second().images.contains(name);
    (layout.disparities.empty() ? frame.right : frame.disparity) = sides.second().path_of(name);
    if (layout.with_right) {
      frame.right = sides.right.path_of(name);
      frame.right_exists = frame.right_exists && sides.right.images.contains(name);
    }
    const auto scan{layout.scans / (frame.left.stem().string() + ".bin")};
    // a file that cannot be opened, such as a link without a target, is reported on reading
    if (std::ranges::binary_search(scans, scan)) frame.scan = scan;
  }
  if (std::ranges::none_of(frames, [](const RecordedFrame& f) { return f.left_exists && f.right_exists; })) {
    throw InputError{
        printable_path(layout.root),
        fmt::format("no left image has a {} one of the same name.", layout.disparities.empty() ? "right" : "disparity"),
        fmt::format("The images of a frame have the same name in {} and {}.", printable_path(layout.left.filename()),
                    printable_path(sides.second().folder.filename()))};
  }
  return frames;
}

namespace fs = std::filesystem;

// A frame's files are named after it: NAME.npz has to be a name that a file can have.
void check_length(const fs::path& file, const std::string& name) {
  constexpr std::size_t longest{251};
  if (name.size() <= longest) return;
  throw InputError{printable_path(file),
                   fmt::format("the name of the frame has {} bytes, more than {}.", name.size(), longest),
                   "Give the frame's files a shorter name."};
}

Images images_in(const fs::path& folder, const std::set<std::string>& extensions) {
  Images images;
  for (const fs::path& entry : entries_of(folder)) {
    const std::string extension{lowercase(entry.extension().string())};
    const std::string stem{entry.stem().string()};
    if (!extensions.contains(extension) || stem.starts_with('.')) continue;
    const std::string name{frame_name(stem)};
    check_length(entry, name);
    if (!images.emplace(name, entry).second) {
      throw InputError{printable_path(entry), "there is another image of the same name in this folder.",
                       "Keep one image for each name."};
    }
  }
  return images;
}

std::optional<NamedSides> split_by_name(const Images& left, const Images& right) {
  std::vector<std::string> names;
  for (const auto& image : left) names.push_back(image.first);
  for (const SideWords& words : all_side_words) {
    if (are_counted(names, words)) continue;
    NamedSides found;
    bool is_pair{false};
    const auto add{[](Images& to, const auto& image, std::string_view word) {
      if (auto rest{without_word(image.first, word)}) to.emplace(rest->empty() ? "000000" : *rest, image.second);
    }};
    for (const auto& image : left) add(found.left, image, words.left);
    for (const auto& image : right) {
      add(found.right, image, words.right);
      const auto rest{without_word(image.first, words.right)};
      is_pair = is_pair || (rest && found.left.contains(rest->empty() ? "000000" : *rest));
    }
    if (is_pair) return found;
  }
  return std::nullopt;
}

}  // namespace stereogrid::io

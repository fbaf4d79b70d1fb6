// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "files/file_access.hpp"
#include "input/calibration/raw_pair.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

template <class T>
std::string size_of(const Image<T>& image) {
  return fmt::format("{}×{}", image.width(), image.height());
}

void need(const std::filesystem::path& path, bool exists, const char* side) {
  if (exists) return;
  throw InputError{printable_path(path), fmt::format("the {} image of this frame is missing.", side),
                   "Add it; the frame is left out meanwhile."};
}

template <class T>
void need_equal_size(const Image<std::uint8_t>& left, const std::filesystem::path& left_file, const Image<T>& other,
                     const std::filesystem::path& other_file) {
  if (left.width() == other.width() && left.height() == other.height()) return;
  throw InputError{printable_path(left_file),
                   fmt::format("has {} px, but {} has {}.", size_of(left), printable_path(other_file), size_of(other)),
                   "The two images of a frame have the same size."};
}

void read_into(const std::filesystem::path& path, Image<std::uint8_t>& image, int& bits) {
  ScaledImage scaled{read_scaled(path)};
  image = std::move(scaled.grey);
  bits = scaled.bits;
}

/// From the image's own scale to one of at least as many bits.
void reduce(Image<std::uint8_t>& image, int& bits, int to_bits) {
  if (bits == 8 || bits == to_bits) return;
  const int shift{to_bits - bits};
  for (std::uint8_t& pixel : image) pixel = static_cast<std::uint8_t>(pixel >> shift);
  bits = to_bits;
}

}  // namespace

void share_scale(ImagePair& pair, int usual_bits) {
  constexpr int dark_bits{2};
  const int own_bits{std::max(pair.left_bits, pair.right_bits)};
  const int bits{std::max(own_bits, std::min(usual_bits, own_bits + dark_bits))};
  reduce(pair.left, pair.left_bits, bits);
  reduce(pair.right, pair.right_bits, bits);
}

Image<float> disparity_from_depth(const Image<float>& depth_m, const Rig& rig) {
  Image<float> disparity{depth_m.width(), depth_m.height()};
  const double focal_baseline{rig.focal_px * rig.baseline_m};
  std::ranges::transform(depth_m, disparity.begin(),
                         [&](float z) { return z > 0 ? static_cast<float>(focal_baseline / z) : 0.0F; });
  return disparity;
}

namespace {

/// Labels of the rectified image; none where it shows nothing of the camera's.
Image<std::uint8_t> rectified(const Rectifier& rectifier, const Image<std::uint8_t>& labels) {
  Image<float> values{labels.width(), labels.height()};
  std::ranges::copy(labels, values.begin());
  const Image<float> turned{rectifier.left(values)};
  Image<std::uint8_t> made{turned.width(), turned.height()};
  std::ranges::transform(turned, made.begin(), [](float value) { return static_cast<std::uint8_t>(value); });
  return made;
}

/// External disparities include other centres of the right camera.
void add_offset(Image<float>& disparity, const RawPair& raw) {
  const auto offset_px{static_cast<float>(raw.right.cx_px - raw.left.cx_px)};
  for (float& d : disparity) {
    if (d != 0 && std::isfinite(d)) d = std::max(0.0F, d + offset_px);
  }
}

}  // namespace

ImageStore::~ImageStore() = default;

std::optional<PlacedGrid> ImageStore::load_grid(std::size_t /*index*/) const {
  return std::nullopt;
}

Recording::Recording(RecordingContents contents, std::unique_ptr<ImageStore> images)
    : contents_{std::move(contents)}, images_{std::move(images)} {
  if (contents_.calibration.raw) rectifier_.emplace(*contents_.calibration.raw, rig().width_px, rig().height_px);
}

void Recording::turn_images(bool are_exchanged) {
  contents_.are_turned = true;
  contents_.are_exchanged = are_exchanged;
  const char* const note{are_exchanged ? "images: turned by 180° and exchanged, since the pair matches as recorded"
                                       : "images: turned by 180°, left and right as named"};
  contents_.notes.emplace_back(note);
  Calibration& calibration{contents_.calibration};
  calibration.notes.emplace_back(note);
  if (!are_exchanged) return;
  if (!contents_.labels.empty()) contents_.warnings.emplace_back("labels: those of exchanged images are not used");
  for (RecordedFrame& frame : contents_.frames) frame.labels.clear();
  turn_upside_down(calibration, Origin{printable_path(contents_.calibration_file)});
  if (calibration.raw) rectifier_.emplace(*calibration.raw, rig().width_px, rig().height_px);
}

void Recording::set_lens(LensModel lens, const std::string& reason) {
  Calibration& calibration{contents_.calibration};
  calibration.raw->left.lens = calibration.raw->right.lens = lens;
  calibration.is_lens_unnamed = false;
  const Rig before{calibration.rig};
  take_rig_of_raw(calibration, Origin{printable_path(contents_.calibration_file)}, {before.width_px, before.height_px});
  rectifier_.emplace(*calibration.raw, before.width_px, before.height_px);
  if (!contents_.mask_file.empty()) contents_.mask = read_mask(contents_.mask_file, calibration);
  calibration.notes.push_back(reason);
  contents_.notes.push_back(reason);
}

StereoFrame Recording::load_unrectified(std::size_t index) const {
  const RecordedFrame& source{contents_.frames.at(index)};
  StereoFrame frame;
  frame.name = source.name;
  frame.index = static_cast<std::int64_t>(index);
  frame.stamp_ns = source.stamp_ns;
  frame.world_from_vehicle = source.world_from_vehicle;
  ImagePair pair;
  if (images_) {
    pair = images_->load(index);
    if (pair.depth_m.empty() &&
        (pair.left.width() != pair.right.width() || pair.left.height() != pair.right.height())) {
      throw InputError{printable_path(source.left),
                       fmt::format("the left image of frame {} has {} px, but the right one has {}.", source.name,
                                   size_of(pair.left), size_of(pair.right)),
                       "The two images of a frame have the same size."};
    }
  } else {
    read_listed([&] { load_files(source, pair, frame); });
  }
  share_scale(pair, contents_.sample_bits);
  frame.left = std::move(pair.left);
  frame.right = std::move(pair.right);
  if (!pair.depth_m.empty()) frame.disparity = disparity_from_depth(pair.depth_m, rig());
  if (!source.labels.empty()) {
    frame.labels = read_listed([&] { return load_labels(source.labels); });
    need_equal_size(frame.left, source.left, frame.labels, source.labels);
  }
  if (contents_.are_exchanged) std::swap(frame.left, frame.right);
  if (contents_.are_turned) {
    std::reverse(frame.labels.begin(), frame.labels.end());
    std::reverse(frame.left.begin(), frame.left.end());
    std::reverse(frame.right.begin(), frame.right.end());
  }
  return frame;
}

std::vector<ScanPoint> Recording::load_scan(std::size_t index) const {
  return read_listed([&] { return read_scan(contents_.frames.at(index).scan); });
}

std::optional<PlacedGrid> Recording::load_grid(std::size_t index) const {
  std::optional<PlacedGrid> grid{images_ ? images_->load_grid(index) : std::nullopt};
  if (!grid || !grid->is_in_world) return grid;
  const auto& pose{contents_.frames.at(index).world_from_vehicle};
  if (!pose)
    throw InputError{printable_path(contents_.root), "has a grid in the frame of the poses, but no pose.",
                     "Use its own poses."};
  grid->vehicle_from_grid = inverse(*pose) * grid->vehicle_from_grid;
  grid->is_in_world = false;
  return grid;
}

std::span<const Rig> Recording::rigs() const {
  return rigs_.empty() ? std::span{&rig(), 1} : std::span{rigs_};
}

std::vector<std::string> Recording::camera_names() const {
  if (others_.empty()) return {};
  std::vector<std::string> names{contents_.camera_name};
  for (const auto& other : others_) names.push_back(other->contents_.camera_name);
  return names;
}

StereoFrame Recording::load_own(std::size_t index) const {
  StereoFrame frame{load_unrectified(index)};
  if (frame.left.width() != rig().width_px || frame.left.height() != rig().height_px) {
    throw InputError{printable_path(contents_.frames[index].left),
                     fmt::format("has {} px, but the calibration is for {}×{}.", size_of(frame.left), rig().width_px,
                                 rig().height_px),
                     "All frames of a recording have the same size."};
  }
  if (rectifier_) {
    if (!frame.labels.empty()) frame.labels = rectified(*rectifier_, frame.labels);
    frame.left = rectifier_->left(frame.left);
    if (!frame.right.empty()) frame.right = rectifier_->right(frame.right);
    if (contents_.has_depth) {
      frame.disparity = rectifier_->left(frame.disparity);
    } else if (is_row_aligned(*contents_.calibration.raw)) {
      add_offset(frame.disparity, *contents_.calibration.raw);
    }
  }
  return frame;
}

Image<std::uint8_t> Recording::load_labels(const std::filesystem::path& path) const {
  const Image<std::uint16_t> values{read_u16(path)};
  Image<std::uint8_t> labels{values.width(), values.height()};
  std::ranges::transform(values, labels.begin(), [&](std::uint16_t value) {
    const auto found{contents_.calibration.labels.find(value)};
    return static_cast<std::uint8_t>(found == contents_.calibration.labels.end() ? PixelLabel::none : found->second);
  });
  return labels;
}

void Recording::load_files(const RecordedFrame& source, ImagePair& pair, StereoFrame& frame) const {
  need(source.left, source.left_exists, "left");
  read_into(source.left, pair.left, pair.left_bits);
  if (contents_.layout != ImageLayout::separate) {
    pair = split_pair(pair.left, pair.left_bits, contents_.layout, printable_path(source.left));
    return;
  }
  if (gives_disparities()) {
    need(source.disparity, source.right_exists, "disparity");
    Image<float>& image{contents_.has_depth ? pair.depth_m : frame.disparity};
    image = contents_.has_depth ? read_depth(source.disparity, contents_.depth_units_per_m)
                                : read_disparity(source.disparity);
    need_equal_size(pair.left, source.left, image, source.disparity);
  }
  if (!source.right.empty()) {
    need(source.right, source.right_exists, "right");
    read_into(source.right, pair.right, pair.right_bits);
    need_equal_size(pair.left, source.left, pair.right, source.right);
  }
}

bool Recording::has_scans() const {
  return std::ranges::any_of(contents_.frames, [](const RecordedFrame& frame) { return !frame.scan.empty(); });
}

static_assert(sizeof(ScanPoint) == 4 * sizeof(float), "points are copied as they lie in the file");

std::vector<ScanPoint> read_scan(const std::filesystem::path& path) {
  const char* const mend{"Copy it again; a sweep is float32 x, y, z, reflectance for each point."};
  const std::string bytes{read_file(path, largest_bytes::sweep)};
  if (bytes.empty()) throw InputError{printable_path(path), "is empty.", mend};
  if (bytes.size() % sizeof(ScanPoint) != 0) {
    throw InputError{printable_path(path),
                     fmt::format("has {} bytes, which is not a multiple of 16: it is cut off.", bytes.size()), mend};
  }
  std::vector<ScanPoint> points(bytes.size() / sizeof(ScanPoint));
  std::memcpy(points.data(), bytes.data(), bytes.size());
  // no lidar sees so far; what it says of such a point is no measurement
  constexpr float farthest_m{10'000};
  std::erase_if(points, [](const ScanPoint& point) {
    const auto is_near{[](float coordinate) { return std::abs(coordinate) <= farthest_m; }};  // false for NaN
    return !is_near(point.x_m) || !is_near(point.y_m) || !is_near(point.z_m);
  });
  if (points.empty())
    throw InputError{printable_path(path), "holds no point with finite coordinates within 10 km.", mend};
  return points;
}

}  // namespace stereogrid::io

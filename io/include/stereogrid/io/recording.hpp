// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/rectifier.hpp"

namespace stereogrid::io {

/// A lidar return in the sensor's own frame (Velodyne: x forward, y left, z up).
struct ScanPoint {
  float x_m{0};
  float y_m{0};
  float z_m{0};
  float reflectance{0};  ///< 0–1
};

/// Reads a lidar sweep in KITTI's form: little-endian float32 x, y, z, reflectance, one point after the other. Points
/// with a coordinate that is not finite (no return) are left out. Throws InputError: missing, empty, cut off within a
/// point, or nothing but such points.
[[nodiscard]] STEREOGRID_EXPORT std::vector<ScanPoint> read_scan(const std::filesystem::path& path);

/// Layout of both cameras' images: separate images, or halves of one.
enum class ImageLayout { separate, side_by_side, top_bottom };

/// Options of an input, as set by the user.
struct InputArguments {
  std::vector<std::filesystem::path> paths;          ///< a folder, or LEFT and RIGHT image files
  std::optional<std::filesystem::path> calibration;  ///< instead of the input's own
  std::string poses;  ///< a file; "file": the input's own; "none"; "odometry"; "": the input's own if there are any,
                      ///< else odometry
  std::optional<std::filesystem::path> disparities{};  ///< folder of disparity images to take instead of right images
  std::optional<std::filesystem::path> depth{};        ///< folder of depth images to take instead of right images
  std::optional<double> depth_units_per_m{};           ///< depth in integers; none: 1000, for TUM's folders 5000
  std::optional<std::filesystem::path> mask{};         ///< image for read_mask, instead of the calibration's
  std::optional<ImageLayout> layout{};                 ///< images that show both cameras; none: automatic
  std::optional<std::filesystem::path> labels{};       ///< folder of label images; none: labels/ beside the images
  bool with_right{false};              ///< `disparities` beside the right images, in which features are tracked
  std::vector<std::string> cameras{};  ///< several stereo pairs: folders in `paths`, or namespaces of a bag; empty: the
                                       ///< list in calibration.yaml, else one pair
};

/// A frame of a recording as it lies on the disk.
struct RecordedFrame {
  std::string name;
  std::int64_t stamp_ns{0};
  std::filesystem::path left;  ///< path, also if missing; see the flags
  std::filesystem::path right;
  bool left_exists{true};
  bool right_exists{true};     ///< or the disparity image
  std::filesystem::path scan;  ///< lidar sweep (float32 x, y, z, reflectance); empty: none
  std::optional<Pose2> world_from_vehicle;
  std::filesystem::path disparity;  ///< instead of `right`, or beside it (InputArguments::with_right)
  std::filesystem::path labels{};   ///< label image; empty: none
};

/// Both images of a frame as the cameras gave them, 8-bit grey. `…_bits`: ScaledImage::bits.
struct ImagePair {
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  int left_bits{8};
  int right_bits{8};
  Image<float> depth_m{};  ///< instead of `right`: along the axis of the camera, per pixel of `left`; 0 = none
  bool has_other_byte_order{false};  ///< ScaledImage::has_other_byte_order of one of them
};

/// Brings both images of 16-bit samples to one scale: `usual_bits`, that of the recording, or less for a dark pair (the
/// brightest pixel keeps at least 32 levels), or more for a brighter pair (nothing saturates). 8-bit samples stay.
STEREOGRID_EXPORT void share_scale(ImagePair& pair, int usual_bits);

/// Disparities f·b/z of depths z along the camera's axis, m; values that are not positive become 0 = none.
[[nodiscard]] STEREOGRID_EXPORT Image<float> disparity_from_depth(const Image<float>& depth_m, const Rig& rig);

/// Cuts an image of `bits` that shows both cameras; the left one is at the left or at the top. Throws InputError: a
/// size that cannot be halved. `name`: for error messages.
[[nodiscard]] STEREOGRID_EXPORT ImagePair split_pair(const Image<std::uint8_t>& image, int bits, ImageLayout layout,
                                                     const std::string& name);

/// Grid of another source in the axes of its own frame, and its place.
struct PlacedGrid {
  ObservedGrid cells;       ///< geometry in the grid's own axes; no cells: nothing observed
  Pose2 vehicle_from_grid;  ///< or world_from_grid
  bool is_in_world{false};  ///< `vehicle_from_grid` is world_from_grid, in the frame of the poses
};

/// The grid on cells of `geometry` in the vehicle frame. A cell has the value at its centre, or that of the most
/// occupied cell whose centre lies in it. Cells that the grid does not reach have confidence 0.
[[nodiscard]] STEREOGRID_EXPORT ObservedGrid resampled(const PlacedGrid& grid, const GridGeometry& geometry);

/// Images that do not lie in files of their own, and grids recorded with them.
class STEREOGRID_EXPORT ImageStore {
 public:
  ImageStore() = default;
  ImageStore(const ImageStore&) = delete;
  ImageStore& operator=(const ImageStore&) = delete;
  virtual ~ImageStore();

  /// Safe to call from several threads. Throws InputError: the images of this frame cannot be used; DeviceError: they
  /// cannot be read at the moment.
  [[nodiscard]] virtual ImagePair load(std::size_t index) const = 0;
  /// Grid of another source at the time of the frame; none: there is none. Throws as load().
  [[nodiscard]] virtual std::optional<PlacedGrid> load_grid(std::size_t index) const;
};

/// Recording that is not a folder of images, as opened by a reader of its format.
struct ForeignRecording {
  std::string kind;                     ///< as RecordingContents::kind
  std::filesystem::path root;           ///< for error messages
  std::vector<std::int64_t> stamps_ns;  ///< ascending stamps of the frames
  std::unique_ptr<ImageStore> images;
  int width_px{0};
  int height_px{0};
  int sample_bits{8};                      ///< as RecordingContents::sample_bits
  std::optional<Calibration> calibration;  ///< none: InputArguments has one
  std::vector<StampedPose> poses;          ///< stamps grow; fewer than two: none
  std::string external{};                  ///< as RecordingContents::external; there: the images come with depth
  std::string poses_source;                ///< their topic, or why none are used; empty: nothing to say
  std::string grids_source{};              ///< as RecordingContents::grids_source
  std::string why_no_grids{};              ///< as RecordingContents::why_no_grids
  std::vector<std::string> notes;
  std::vector<std::string> warnings;
};

/// Everything known about a recording before its images are read.
struct RecordingContents {
  std::string kind;  ///< "KITTI odometry sequence", "KITTI raw drive", "plain folder", "image pair", or another's
  std::filesystem::path root;
  std::filesystem::path calibration_file;
  Calibration calibration;
  std::filesystem::path mask_file;     ///< empty: none
  Image<std::uint8_t> mask;            ///< PipelineOptions::mask, of rectified images; empty: none
  std::filesystem::path poses_file;    ///< or the oxts folder; empty: no poses
  bool wants_odometry{false};          ///< no poses here: the caller is to find them (VisualOdometry)
  std::filesystem::path truth_folder;  ///< empty: no ground truth
  std::filesystem::path disparities;   ///< folder of the disparity images; empty: right images
  std::filesystem::path labels{};      ///< folder of the label images; empty: none
  std::vector<RecordedFrame> frames;
  int sample_bits{8};                 ///< most of the images looked at: their usual scale (share_scale)
  std::vector<std::string> notes;     ///< choices made on opening: calibration, poses, stamps
  std::vector<std::string> warnings;  ///< faults that do not stop the recording
  std::string poses_source{};         ///< as ForeignRecording::poses_source
  std::string external{};             ///< source of disparities or depth instead of right images; empty: right images
  std::string grids_source{};         ///< topics of grids of another source; empty: none
  std::string why_no_grids{};         ///< reason, as the end of a message about the recording
  bool has_depth{false};              ///< `external` gives depth: of the left images before rectification
  double depth_units_per_m{1000};     ///< depth files in integers
  ImageLayout layout{ImageLayout::separate};
  bool are_turned{false};     ///< images by 180° on loading
  bool are_exchanged{false};  ///< and left with right
  std::string camera_name{};  ///< one of several cameras' (PipelineOptions::camera_names); empty: there is one
};

/// A recorded drive. Opened by open_recording.
class STEREOGRID_EXPORT Recording final : public FrameSource {
 public:
  /// `images`: instead of the files that the frames name.
  explicit Recording(RecordingContents contents, std::unique_ptr<ImageStore> images = {});

  [[nodiscard]] const Rig& rig() const override { return contents_.calibration.rig; }
  [[nodiscard]] std::span<const Rig> rigs() const override;
  [[nodiscard]] std::vector<std::string> camera_names() const override;
  void set_camera_name(std::string name) { contents_.camera_name = std::move(name); }
  /// Adds a stereo pair of the same vehicle. A frame has the frame of it that is nearest in time, within half of its
  /// interval; those that cannot be loaded are left out: StereoFrame::fault names
  /// them.
  void add_camera(std::unique_ptr<Recording> camera);
  [[nodiscard]] const std::vector<std::unique_ptr<Recording>>& other_cameras() const { return others_; }
  [[nodiscard]] std::size_t size() const override { return contents_.frames.size(); }
  [[nodiscard]] std::string name(std::size_t index) const override { return contents_.frames.at(index).name; }
  /// Reads, checks and (raw pairs) rectifies a frame. Disparities are taken as they are: they belong to the rectified
  /// left image. Depth belongs to the left image as it was recorded and becomes disparity. Throws InputError: an image
  /// was missing when the recording was opened, is damaged, of another size. Throws DeviceError: an image was there and
  /// cannot be opened or read now; trying again may help.
  [[nodiscard]] StereoFrame load(std::size_t index) const override;
  /// The same but as the images lie there: those of a raw pair are not rectified, and may have another size than it.
  [[nodiscard]] StereoFrame load_unrectified(std::size_t index) const;
  /// Reads the lidar sweep of a frame that has one. Throws as read_scan(), and DeviceError as load().
  [[nodiscard]] std::vector<ScanPoint> load_scan(std::size_t index) const;

  /// Grid of another source at the time of a frame, in the vehicle frame; none: there is none. Throws InputError: it
  /// cannot be used, or its place is unknown; DeviceError as load().
  [[nodiscard]] std::optional<PlacedGrid> load_grid(std::size_t index) const;

  [[nodiscard]] const RecordingContents& contents() const { return contents_; }
  /// Turns all images by 180°. `are_exchanged`: the rig was upside down, and not each camera alone; then the
  /// calibration is of the images as recorded, else of the turned ones.
  void turn_images(bool are_exchanged);
  /// Replaces the lens of both cameras of a raw pair (Calibration::is_lens_unnamed), and notes it.
  void set_lens(LensModel lens, const std::string& reason);
  [[nodiscard]] bool has_poses() const { return !contents_.poses_file.empty(); }
  [[nodiscard]] bool has_scans() const;
  [[nodiscard]] bool gives_disparities() const { return !contents_.external.empty(); }
  [[nodiscard]] bool has_truth() const { return !contents_.truth_folder.empty(); }

 private:
  [[nodiscard]] StereoFrame load_own(std::size_t index) const;
  void load_files(const RecordedFrame& source, ImagePair& pair, StereoFrame& frame) const;
  [[nodiscard]] Image<std::uint8_t> load_labels(const std::filesystem::path& path) const;

  RecordingContents contents_;
  std::unique_ptr<ImageStore> images_;
  std::optional<Rectifier> rectifier_;
  std::vector<std::unique_ptr<Recording>> others_;
  std::vector<Rig> rigs_;  // rigs of all cameras; empty: one camera
};

/// Recognises the input by looking at it and reads everything but the images. Throws InputError (which file, what is
/// wrong, what would mend it) where the recording as a whole cannot be used.
[[nodiscard]] STEREOGRID_EXPORT std::unique_ptr<Recording> open_recording(const InputArguments& arguments);

/// Opens a foreign recording; calibration, mask and poses are the arguments' if they name files. Throws InputError;
/// ConfigError with external disparities.
[[nodiscard]] STEREOGRID_EXPORT std::unique_ptr<Recording> open_recording(const InputArguments& arguments,
                                                                          ForeignRecording found);

/// Throws ConfigError: more than eight stereo pairs, or one twice.
STEREOGRID_EXPORT void check_cameras(std::span<const std::string> cameras);

/// Names of the cameras of folders or namespaces (PipelineOptions::camera_names): their last parts, numbered where they
/// would be equal.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> camera_names(std::span<const std::string> cameras);

/// Opens one of InputArguments::cameras, with its place in the vehicle.
using OpenCamera = std::function<std::unique_ptr<Recording>(const std::string& camera)>;

/// Opens the stereo pairs of one vehicle, 1 to 8, as one recording: the first one, with the others as further cameras.
/// Throws ConfigError as check_cameras(), and what `open` throws.
[[nodiscard]] STEREOGRID_EXPORT std::unique_ptr<Recording> open_cameras(std::span<const std::string> cameras,
                                                                        const OpenCamera& open);

/// Message if left and right seem to be swapped: more of the pair matches at negative disparities than at positive
/// ones.
[[nodiscard]] STEREOGRID_EXPORT std::optional<std::string> finding_if_swapped(const StereoFrame& frame);

/// Disparity (px) of the farthest points of a rectified pair where it is clearly negative; none: it is not, or the
/// sides are swapped. 0.3 s for an image of 1280 × 720.
[[nodiscard]] STEREOGRID_EXPORT std::optional<double> negative_disparity_px(const StereoFrame& frame);

/// Disparity (px) of the nearest points of a rectified pair where a fifth of it matches at `beyond_px` or more.
[[nodiscard]] STEREOGRID_EXPORT std::optional<double> near_disparity_px(const StereoFrame& frame, double beyond_px);

/// Message if the farthest points have negative disparities: the offset, and the corrected line of calibration.yaml.
[[nodiscard]] STEREOGRID_EXPORT std::optional<std::string> finding_if_shifted(const StereoFrame& frame, const Rig& rig);

/// Share of the pixels that have a sure match at a disparity of at least one pixel, in images reduced to a width of 400
/// px. 0 where the images are narrower than 96 px or differ in size.
[[nodiscard]] STEREOGRID_EXPORT double coarse_match_share(const Image<std::uint8_t>& left,
                                                          const Image<std::uint8_t>& right);

}  // namespace stereogrid::io

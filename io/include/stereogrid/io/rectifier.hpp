// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/io/calibration.hpp"

namespace stereogrid::io {

/// Turns the images of a raw pair into a rectified pair of the same size: rows aligned, distortion gone.
class STEREOGRID_EXPORT Rectifier {
 public:
  /// Throws InputError when the pair cannot be rectified (`raw` has no baseline along x).
  Rectifier(const RawPair& raw, int width_px, int height_px);
  Rectifier(Rectifier&&) noexcept;
  Rectifier& operator=(Rectifier&&) noexcept;
  ~Rectifier();

  /// Rig of the rectified pair; its extrinsics have default values.
  [[nodiscard]] const Rig& rig() const;

  /// Size as given at construction. Safe to call from several threads.
  [[nodiscard]] Image<std::uint8_t> left(const Image<std::uint8_t>& raw) const;
  /// Nearest value: there is none between depths.
  [[nodiscard]] Image<float> left(const Image<float>& raw) const;
  [[nodiscard]] Image<std::uint8_t> right(const Image<std::uint8_t>& raw) const;

 private:
  struct STEREOGRID_HIDDEN Maps;
  std::unique_ptr<const Maps> maps_;
};

/// Vertical distances of corners of rectified left images from their places in the right ones.
struct RowResidual {
  double rms_rad{0};
  std::size_t corners{0};  ///< number of them that were found
};

/// Residual of a raw pair as its calibration rectifies it. `frames`: as recorded, one at least.
[[nodiscard]] STEREOGRID_EXPORT RowResidual row_residual(const RawPair& raw, std::span<const StereoFrame> frames);

/// Median vertical distance (px, below 6) of matched corners of a rectified pair; none: fewer than 30 corners match.
[[nodiscard]] STEREOGRID_EXPORT std::optional<double> row_residual_px(const StereoFrame& frame);

/// PipelineOptions::mask from a file: 255 where the pixel is used, 0 where it shows the vehicle itself. In the file
/// black (0) shows the vehicle; of colours, all three 0. Throws InputError: missing, damaged, of another size, a JPEG
/// (whose black is not quite 0), or nothing in it is used.
[[nodiscard]] STEREOGRID_EXPORT Image<std::uint8_t> read_mask(const std::filesystem::path& path, int width_px,
                                                              int height_px);

/// The same of the rectified left image, from a mask of the images as the cameras give them: those of a raw pair are
/// rectified, and what then is not the camera's is masked, too.
[[nodiscard]] STEREOGRID_EXPORT Image<std::uint8_t> read_mask(const std::filesystem::path& path,
                                                              const Calibration& calibration);

/// Effect of a mask.
struct MaskUse {
  std::string text;    ///< file, and the share of the image that it leaves out
  bool is_odd{false};  ///< it leaves out nothing, or the larger part: the text has the probable cause
};
/// `path`: of the file, for the text.
[[nodiscard]] STEREOGRID_EXPORT MaskUse use_of_mask(const std::filesystem::path& path, const Image<std::uint8_t>& mask);

}  // namespace stereogrid::io

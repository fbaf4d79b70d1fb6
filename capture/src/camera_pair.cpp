// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/capture/camera_pair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "pairing.hpp"
#include "stereogrid/capture/latest.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/rectifier.hpp"

namespace stereogrid::capture {
namespace {

void check_size(const PixelView& image, int width_px, const Rig& rig) {
  if (image.width_px == width_px && image.height_px == rig.height_px) return;
  throw InputError{
      "camera",
      fmt::format("its images have {}×{} px, but the calibration is for {}×{}{}.", image.width_px, image.height_px,
                  rig.width_px, rig.height_px, width_px == rig.width_px ? "" : ", two of them side by side"),
      "Set the camera to the calibrated size, or write a calibration.yaml that names the calibration ('from: FILE') "
      "and the size of these images ('image: {width_px: …, height_px: …}'): it is scaled then."};
}

/// A scale that is given stays, as that of 8-bit samples does.
io::ScaledImage scaled(PixelView view) {
  io::ScaledImage image;
  if (view.format == PixelFormat::grey16 && view.bits == 0) view.bits = image.bits = io::sample_bits(view);
  assign(image.grey, view);
  return image;
}

}  // namespace

LiveSource::~LiveSource() = default;

struct CameraPair::State {
  State(const io::Calibration& calibration, const PairingOptions& options)
      : rig{calibration.rig}, has_depth{options.has_depth}, pairing{options, Clock::now()} {
    if (rig.width_px <= 0 || rig.height_px <= 0) {
      throw InputError{"calibration", "does not have the size of the images.",
                       "Write a calibration.yaml that names this file ('from: FILE') and the size ('image: {width_px: "
                       "…, height_px: …}')."};
    }
    if (calibration.raw) rectifier.emplace(*calibration.raw, rig.width_px, rig.height_px);
  }

  void put(CapturedPair pair) {
    pair.stream = stream;
    fault.clear();
    usual_bits = std::max({usual_bits, pair.images.left_bits, pair.images.right_bits});
    io::share_scale(pair.images, usual_bits);
    latest.put(std::move(pair));
  }

  Rig rig;
  bool has_depth;
  std::optional<io::Rectifier> rectifier;
  UnixTime unix_time;
  Latest<CapturedPair> latest;
  std::int64_t given{0};
  int last_stream{0};
  std::optional<Clock::time_point> last_captured;

  mutable std::mutex mutex;  // protects the members below
  Pairing pairing;
  std::string fault;
  int stream{0};
  int usual_bits{8};
  std::int64_t unusable{0};
  std::int64_t not_newer{0};
};

CameraPair::CameraPair(const io::Calibration& calibration, const PairingOptions& options)
    : state_{std::make_unique<State>(calibration, options)} {}

CameraPair::~CameraPair() = default;

void CameraPair::add(Side side, const PixelView& image, Clock::time_point captured) {
  check_size(image, state_->rig.width_px, state_->rig);
  add(side, scaled(image), captured);
}

void CameraPair::add(Side side, io::ScaledImage image, Clock::time_point captured) {
  check_size({nullptr, image.grey.width(), image.grey.height()}, state_->rig.width_px, state_->rig);
  const std::scoped_lock lock{state_->mutex};
  if (auto pair{state_->pairing.add(side, {std::move(image)}, captured, Clock::now())}) state_->put(std::move(*pair));
}

void CameraPair::add_depth(Image<float> depth_m, Clock::time_point captured) {
  check_size({nullptr, depth_m.width(), depth_m.height()}, state_->rig.width_px, state_->rig);
  const std::scoped_lock lock{state_->mutex};
  Shot shot{{}, std::move(depth_m)};
  if (auto pair{state_->pairing.add(Side::right, std::move(shot), captured, Clock::now())}) {
    state_->put(std::move(*pair));
  }
}

void CameraPair::add(const PixelView& left, const PixelView& right, Clock::time_point captured) {
  check_size(left, state_->rig.width_px, state_->rig);
  check_size(right, state_->rig.width_px, state_->rig);
  io::ScaledImage scaled_left{scaled(left)};
  io::ScaledImage scaled_right{scaled(right)};
  CapturedPair pair{{std::move(scaled_left.grey), std::move(scaled_right.grey), scaled_left.bits, scaled_right.bits},
                    captured};
  const std::scoped_lock lock{state_->mutex};
  state_->pairing.note_pair(Clock::now());
  state_->put(std::move(pair));
}

void CameraPair::add_side_by_side(const PixelView& both, Clock::time_point captured) {
  const int width_px{state_->rig.width_px};
  check_size(both, 2 * width_px, state_->rig);
  PixelView left{both};
  left.width_px = width_px;
  if (left.stride_bytes == 0) left.stride_bytes = both.width_px * bytes_per_pixel(both.format);
  PixelView right{left};
  right.data = static_cast<const std::byte*>(both.data) + width_px * bytes_per_pixel(both.format);
  add(left, right, captured);
}

void CameraPair::add_unusable() {
  const std::scoped_lock lock{state_->mutex};
  ++state_->unusable;
}

void CameraPair::set_tolerance(std::chrono::nanoseconds tolerance) {
  const std::scoped_lock lock{state_->mutex};
  state_->pairing.set_tolerance(tolerance);
}

void CameraPair::set_fault(std::string sentence) {
  const std::scoped_lock lock{state_->mutex};
  state_->fault = std::move(sentence);
}

void CameraPair::request_reset() {
  const std::scoped_lock lock{state_->mutex};
  ++state_->stream;
}

void CameraPair::end() {
  state_->latest.end();
}

const Rig& CameraPair::rig() const {
  return state_->rig;
}

std::optional<LiveFrame> CameraPair::next(std::chrono::milliseconds patience) {
  State& state{*state_};
  std::optional<CapturedPair> pair{state.latest.take(patience)};
  if (!pair) return std::nullopt;
  if (state.last_captured && pair->captured <= *state.last_captured) {
    const std::scoped_lock lock{state.mutex};
    ++state.not_newer;
    return std::nullopt;
  }
  state.last_captured = pair->captured;
  LiveFrame live;
  live.captured = pair->captured;
  live.resets_before = pair->stream != std::exchange(state.last_stream, pair->stream);
  live.frame.index = state.given++;
  live.frame.name = fmt::format("{:06}", live.frame.index);
  live.frame.stamp_ns = state.unix_time.ns(pair->captured);
  io::ImagePair& images{pair->images};
  live.frame.left = state.rectifier ? state.rectifier->left(images.left) : std::move(images.left);
  if (!images.depth_m.empty()) {
    live.frame.disparity = io::disparity_from_depth(images.depth_m, state.rig);
    if (state.rectifier) live.frame.disparity = state.rectifier->left(live.frame.disparity);
    return live;
  }
  live.frame.right = state.rectifier ? state.rectifier->right(images.right) : std::move(images.right);
  return live;
}

bool CameraPair::has_ended() const {
  return state_->latest.has_ended();
}

std::string CameraPair::fault() const {
  const std::scoped_lock lock{state_->mutex};
  return state_->fault.empty() ? state_->pairing.fault(Clock::now()) : state_->fault;
}

std::vector<Drop> CameraPair::dropped() const {
  std::vector<Drop> drops{{"a newer one came", state_->latest.replaced()}};
  const std::scoped_lock lock{state_->mutex};
  const char* const left{state_->has_depth ? "left image without depth" : "left image without a right one"};
  const char* const right{state_->has_depth ? "depth without a left image" : "right image without a left one"};
  drops.push_back({left, state_->pairing.alone(Side::left)});
  drops.push_back({right, state_->pairing.alone(Side::right)});
  drops.push_back({"cannot be used", state_->unusable});
  drops.push_back({"not newer than the one before", state_->not_newer});
  std::erase_if(drops, [](const Drop& drop) { return drop.frames == 0; });
  return drops;
}

Clock::duration CameraPair::silent_for() const {
  const std::scoped_lock lock{state_->mutex};
  return Clock::now() - state_->pairing.last_image();
}

std::string v4l2_pipeline(const std::string& left, const std::string& right, const Rig& size) {
  const bool is_single{right.empty()};
  const auto device = [&](const std::string& path, const char* name) {
    // without caps of memory: the camera may give any raw format, or JPEG
    const int width_px{is_single ? 2 * size.width_px : size.width_px};
    return fmt::format(
        "v4l2src device=\"{0}\" ! video/x-raw,width={1},height={2};image/jpeg,width={1},height={2} ! decodebin ! "
        "videoconvert ! appsink name={3} sync=false",
        path, width_px, size.height_px, name);
  };
  if (is_single) return device(left, "both");
  return device(left, "left") + " " + device(right, "right");
}

#if !STEREOGRID_GSTREAMER
std::unique_ptr<LiveSource> open_gstreamer(const std::string&, const io::Calibration&, const CameraOptions&) {
  throw DeviceError{
      "Cameras require GStreamer, and this stereogrid was built without it, as wheels are. "
      "Install the Debian package stereogrid, or build from source (docs/install.md)."};
}
#endif

}  // namespace stereogrid::capture

// SPDX-License-Identifier: Apache-2.0
#include "pairing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stereogrid::capture {
namespace {

constexpr std::size_t waiting_max{8};  // maximum queue per camera: a quarter of a second at 30 Hz

double seconds(Clock::duration time) {
  return std::chrono::duration<double>{time}.count();
}

double milliseconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double, std::milli>{time}.count();
}

}  // namespace

Pairing::Pairing(const PairingOptions& options, Clock::time_point now) : options_{options}, last_pair_{now} {
  for (Camera& camera : cameras_) camera.last_image = now;
}

std::optional<std::size_t> Pairing::nearest(const Camera& camera, Clock::time_point captured) {
  if (camera.waiting.empty()) return std::nullopt;
  const auto found{std::ranges::min_element(
      camera.waiting, {}, [&](const Waiting& one) { return std::chrono::abs(one.captured - captured); })};
  return static_cast<std::size_t>(found - camera.waiting.begin());
}

void Pairing::drop(Camera& camera, std::size_t images) {
  camera.alone += static_cast<std::int64_t>(images);
  camera.waiting.erase(camera.waiting.begin(), camera.waiting.begin() + static_cast<std::ptrdiff_t>(images));
}

std::optional<CapturedPair> Pairing::add(Side side, Shot shot, Clock::time_point captured, Clock::time_point now) {
  Camera& own{of(side)};
  Camera& other{of(side == Side::left ? Side::right : Side::left)};
  own.last_image = now;
  const std::optional<std::size_t> partner{nearest(other, captured)};
  if (partner) apart_ = std::chrono::abs(other.waiting[*partner].captured - captured);
  if (!partner || *apart_ > options_.tolerance) {
    own.waiting.push_back({std::move(shot), captured});
    if (own.waiting.size() > waiting_max) drop(own, 1);
    return std::nullopt;
  }
  Waiting found{std::move(other.waiting[*partner])};
  drop(other, *partner);  // drops older ones
  other.waiting.pop_front();
  drop(own, own.waiting.size());
  last_pair_ = now;
  if (side == Side::right) {
    std::swap(shot, found.shot);
    captured = found.captured;
  }
  io::ScaledImage& left{shot.image};
  io::ScaledImage& right{found.shot.image};
  return CapturedPair{
      {std::move(left.grey), std::move(right.grey), left.bits, right.bits, std::move(found.shot.depth_m)}, captured};
}

void Pairing::note_pair(Clock::time_point now) {
  for (Camera& camera : cameras_) camera.last_image = now;
  last_pair_ = now;
}

std::string Pairing::fault(Clock::time_point now) const {
  if (now - last_pair_ <= options_.silence) return "";
  const bool has_left{now - of(Side::left).last_image <= options_.silence};
  const bool has_right{now - of(Side::right).last_image <= options_.silence};
  if (!has_left && !has_right) {
    return fmt::format("No image has come from either camera for {:.0f} s.", seconds(now - last_image()));
  }
  if (!has_left || !has_right) {
    const Side silent{has_left ? Side::right : Side::left};
    if (options_.has_depth) {
      return fmt::format("No {} has come for {:.0f} s; {} comes.", has_left ? "depth" : "left image",
                         seconds(now - of(silent).last_image), has_left ? "the left image" : "depth");
    }
    return fmt::format("No image of the {} camera has come for {:.0f} s; those of the other come.",
                       has_left ? "right" : "left", seconds(now - of(silent).last_image));
  }
  if (!apart_) return "";
  if (options_.has_depth) {
    return fmt::format(
        "Left images and depth come, but the nearest are {:.1f} ms apart, more than the tolerance of {:.1f} ms. Allow "
        "more than {:.0f} ms (--pair-tolerance-ms).",
        milliseconds(*apart_), milliseconds(options_.tolerance), std::ceil(milliseconds(*apart_)));
  }
  return fmt::format(
      "Images of both cameras come, but the nearest are {:.1f} ms apart, more than the tolerance of {:.1f} ms: there "
      "are not pairs. Trigger the cameras together, or allow more than {:.0f} ms (--pair-tolerance-ms).",
      milliseconds(*apart_), milliseconds(options_.tolerance), std::ceil(milliseconds(*apart_)));
}

Clock::time_point Pairing::last_image() const {
  return std::max(cameras_[0].last_image, cameras_[1].last_image);
}

}  // namespace stereogrid::capture

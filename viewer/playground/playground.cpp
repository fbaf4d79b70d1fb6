// SPDX-License-Identifier: Apache-2.0
//
// The pipeline in a browser: exports allocate() and process(), and calls functions of the page (viewer/playground.js).
// There are neither threads nor a GPU.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <span>
#include <string_view>
#include <typeinfo>

#include "backend/cpu.hpp"
#include "pipeline/cuda_library.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/pixel_view.hpp"

#define FROM_PAGE(name) __attribute__((import_module("page"), import_name(#name)))
#define TO_PAGE(name) __attribute__((export_name(#name)))

namespace {

extern "C" {
/// Adds the next channel: topic, type and definition as UTF-8.
FROM_PAGE(add)
void page_add(const char* topic, std::size_t topic_size, const char* type, std::size_t type_size,
              const char* definition, std::size_t definition_size);
/// Receives a message of a channel as CDR.
FROM_PAGE(send) void page_send(std::uint32_t channel, const std::byte* cdr, std::size_t size);
/// Throws a JavaScript error with the message. Nothing of this instance may be called afterwards.
[[noreturn]] FROM_PAGE(fail) void page_fail(const char* message, std::size_t size);
}

[[noreturn]] void fail(std::string_view message) {
  page_fail(message.data(), message.size());
}

class PageSink final : public stereogrid::messages::Sink {
 public:
  std::uint32_t add(const stereogrid::messages::Channel& channel) override {
    page_add(channel.topic.data(), channel.topic.size(), channel.type.data(), channel.type.size(),
             channel.definition.data(), channel.definition.size());
    return channels_++;
  }
  [[nodiscard]] bool wants(std::uint32_t) const override { return true; }
  void send(std::uint32_t channel, std::int64_t, std::span<const std::byte> cdr) override {
    page_send(channel, cdr.data(), cdr.size());
  }

 private:
  std::uint32_t channels_{0};
};

}  // namespace

extern "C" {

TO_PAGE(allocate) void* allocate(std::size_t bytes) {
  return std::malloc(bytes);
}

/// Sends the messages of a first frame to the page. `left`, `right`: rows of `width` × `height` pixels, RGBA; `jpeg`:
/// the left image. `height_m`: NaN for extrinsics that are estimated, which ignores both angles. Other values as in
/// Rig. Errors of the library reach page_fail().
TO_PAGE(process)
void process(const std::uint8_t* left, const std::uint8_t* right, int width, int height, const std::byte* jpeg,
             std::size_t jpeg_size, double focal_px, double cx_px, double cy_px, double baseline_m, double height_m,
             double pitch_rad, double roll_rad, bool is_robot) {
  using namespace stereogrid;
  const bool has_extrinsics{!std::isnan(height_m)};
  Rig rig{width, height, focal_px, cx_px, cy_px, baseline_m, height_m, pitch_rad, roll_rad};
  if (!has_extrinsics) rig = {width, height, focal_px, cx_px, cy_px, baseline_m};
  Config config{preset(is_robot ? "robot" : "default")};
  config.tracking.confirm_frames = 1;  // there is no other frame
  Pipeline pipeline{config, rig, {.stages = false, .extrinsics_given = has_extrinsics}};

  StereoFrame frame;
  assign(frame.left, {left, width, height, 0, PixelFormat::rgba8});
  assign(frame.right, {right, width, height, 0, PixelFormat::rgba8});
  const FrameResult& result{pipeline.process(frame)};

  PageSink sink;
  messages::FrameMessages messages{sink, result.rig};
  messages.send(result, {.left_jpeg = [&](int) { return std::span{jpeg, jpeg_size}; }, .frames = 1});
}

// In place of the C++ run-time's exceptions, which WebAssembly without their extension lacks: the message reaches the
// page, and nothing is caught. The library's exceptions are those of the standard library or derived from one.
void* __cxa_allocate_exception(std::size_t bytes) noexcept {
  return std::malloc(bytes);
}
void __cxa_free_exception(void* exception) noexcept {
  std::free(exception);
}
[[noreturn]] void __cxa_throw(void* exception, std::type_info*, void (*)(void*)) {
  fail(static_cast<std::exception*>(exception)->what());
}
}

// In place of backend/threads.cpp and pipeline/cuda_library.cpp.
namespace stereogrid {

void require_threads(int) {}

void rethrow_as_device_error(const std::runtime_error& error) {
  fail(error.what());
}

std::unique_ptr<Stages> cuda_stages(const Config&, const Rig&, int, const StagesOptions&) {
  throw DeviceError{"A browser has no CUDA."};
}

}  // namespace stereogrid

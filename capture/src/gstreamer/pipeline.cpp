// SPDX-License-Identifier: Apache-2.0
#include "gstreamer/pipeline.hpp"

#include <fmt/format.h>
#include <gst/video/video.h>

#include <algorithm>
#include <mutex>
#include <vector>

#include "stereogrid/error.hpp"

namespace stereogrid::capture {
namespace {

constexpr int bits_of_image{0};  // bits of GRAY16: CameraPair finds them, sensors have 10, 12 or 16
constexpr const char* formats{"video/x-raw, format={ GRAY8, GRAY16_LE, BGR, RGB, BGRA, RGBA }"};

struct ErrorFree {
  void operator()(GError* error) const { g_error_free(error); }
};
using Error = std::unique_ptr<GError, ErrorFree>;

void initialise() {
  static std::once_flag once;
  std::call_once(once, [] { gst_init(nullptr, nullptr); });
}

GstPointer<GstElement> parse(const std::string& description) {
  GError* raw{nullptr};
  GstPointer<GstElement> pipeline{
      gst_parse_launch_full(description.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &raw)};
  const Error error{raw};
  if (!pipeline || error) {
    throw ConfigError{fmt::format(
        "gst:{}: {}. 'gst-launch-1.0' tries a pipeline by itself; an element that is missing comes with a package of "
        "GStreamer's plugins (gst-inspect-1.0 lists those that are there).",
        description, error ? error->message : "not a pipeline")};
  }
  return pipeline;
}

std::vector<GstPointer<GstElement>> sinks_of(GstElement* pipeline) {
  std::vector<GstPointer<GstElement>> found;
  if (!GST_IS_BIN(pipeline)) return found;  // a single element
  GstIterator* const elements{gst_bin_iterate_all_by_element_factory_name(GST_BIN(pipeline), "appsink")};
  GValue item = G_VALUE_INIT;
  while (gst_iterator_next(elements, &item) == GST_ITERATOR_OK) {
    found.emplace_back(static_cast<GstElement*>(gst_object_ref(g_value_get_object(&item))));
    g_value_reset(&item);
  }
  g_value_unset(&item);
  gst_iterator_free(elements);
  return found;
}

std::string name_of(const GstPointer<GstElement>& element) {
  gchar* const name{gst_element_get_name(element.get())};
  std::string copy{name};
  g_free(name);
  return copy;
}

PixelFormat format_of(GstVideoFormat format) {
  switch (format) {
    case GST_VIDEO_FORMAT_GRAY8:
      return PixelFormat::grey8;
    case GST_VIDEO_FORMAT_GRAY16_LE:
      return PixelFormat::grey16;
    case GST_VIDEO_FORMAT_BGR:
      return PixelFormat::bgr8;
    case GST_VIDEO_FORMAT_RGB:
      return PixelFormat::rgb8;
    case GST_VIDEO_FORMAT_BGRA:
      return PixelFormat::bgra8;
    default:
      return PixelFormat::rgba8;  // the caps of connect() let no other through
  }
}

std::string sentence_of(GstMessage* message) {
  GError* raw{nullptr};
  gchar* debug{nullptr};
  gst_message_parse_error(message, &raw, &debug);
  const Error error{raw};
  const std::string detail{debug != nullptr ? debug : ""};
  g_free(debug);
  std::string sentence{fmt::format("{} ({})", error->message, GST_OBJECT_NAME(GST_MESSAGE_SRC(message)))};
  if (detail.find("not-negotiated") != std::string::npos) {
    sentence += ": an element does not take what the one before it gives; put 'videoconvert' before the appsink";
  }
  return sentence + ".";
}

}  // namespace

GstStream::GstStream(const std::string& description, CameraPair& pair) : pair_{pair} {
  initialise();
  const bool has_sink{description.find("appsink") != std::string::npos};
  pipeline_ = parse(has_sink ? description : description + " ! videoconvert ! appsink");
  auto sinks{sinks_of(pipeline_.get())};
  if (sinks.size() == 2 && name_of(sinks[0]) != "left") std::swap(sinks[0], sinks[1]);
  if (sinks.empty() || sinks.size() > 2 ||
      (sinks.size() == 2 && (name_of(sinks[0]) != "left" || name_of(sinks[1]) != "right"))) {
    throw ConfigError{fmt::format(
        "gst:{}: has {} appsinks. Give one, for both images side by side, or two: 'appsink name=left' and 'appsink "
        "name=right'.",
        description, sinks.size())};
  }
  const bool has_two{sinks.size() == 2};
  outputs_ = {{{this, has_two ? Role::left : Role::both}, {this, Role::right}}};
  for (std::size_t i{0}; i < sinks.size(); ++i) connect(GST_APP_SINK(sinks[i].get()), outputs_[i]);
}

void GstStream::connect(GstAppSink* sink, Output& output) {
  GstCaps* const caps{gst_caps_from_string(formats)};
  gst_app_sink_set_caps(sink, caps);
  gst_caps_unref(caps);
  GstAppSinkCallbacks callbacks{};
  callbacks.new_sample = &GstStream::take_sample;
  gst_app_sink_set_callbacks(sink, &callbacks, &output, nullptr);
}

// No thread of the pipeline is left when this returns.
GstStream::~GstStream() {
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
}

void GstStream::start() {
  is_live_ = gst_element_set_state(pipeline_.get(), GST_STATE_PAUSED) == GST_STATE_CHANGE_NO_PREROLL;
  gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);  // failures come as messages
}

PipelineEvent GstStream::wait(std::chrono::milliseconds patience) {
  const GstPointer<GstBus> bus{gst_element_get_bus(pipeline_.get())};
  const auto wanted{static_cast<GstMessageType>(GST_MESSAGE_ERROR | GST_MESSAGE_EOS)};
  GstMessage* const message{gst_bus_timed_pop_filtered(
      bus.get(), static_cast<GstClockTime>(std::chrono::nanoseconds{patience}.count()), wanted)};
  if (message == nullptr) return PipelineEvent::none;
  const bool has_ended{GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS};
  if (!has_ended) why_ = sentence_of(message);
  gst_message_unref(message);
  return has_ended ? PipelineEvent::ended : PipelineEvent::failed;
}

GstFlowReturn GstStream::take_sample(GstAppSink* sink, void* output) {
  GstSample* const sample{gst_app_sink_pull_sample(sink)};
  if (sample == nullptr) return GST_FLOW_EOS;
  const Output& to{*static_cast<Output*>(output)};
  ++to.stream->images_;
  try {
    to.stream->take(sample, to.role);
  } catch (const std::exception& error) {  // nothing may pass through GStreamer's frames
    to.stream->pair_.add_unusable();
    to.stream->pair_.set_fault(error.what());
  }
  gst_sample_unref(sample);
  return GST_FLOW_OK;
}

void GstStream::take(GstSample* sample, Role role) {
  GstVideoInfo info;
  GstVideoFrame frame;
  if (gst_video_info_from_caps(&info, gst_sample_get_caps(sample)) == FALSE ||
      gst_video_frame_map(&frame, &info, gst_sample_get_buffer(sample), GST_MAP_READ) == FALSE) {
    throw InputError{"camera: a buffer of the pipeline is not an image. Put 'videoconvert' before the appsink."};
  }
  const std::unique_ptr<GstVideoFrame, void (*)(GstVideoFrame*)> mapped{&frame, gst_video_frame_unmap};
  const PixelView view{GST_VIDEO_FRAME_PLANE_DATA(&frame, 0),
                       GST_VIDEO_FRAME_WIDTH(&frame),
                       GST_VIDEO_FRAME_HEIGHT(&frame),
                       GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0),
                       format_of(GST_VIDEO_FRAME_FORMAT(&frame)),
                       bits_of_image};
  const Clock::time_point captured{instant_of(sample)};
  if (role == Role::both) {
    pair_.add_side_by_side(view, captured);
  } else {
    pair_.add(role == Role::left ? Side::left : Side::right, view, captured);
  }
}

// Capture time, never in the future: an appsink may deliver a buffer before its time by the pipeline's latency.
Clock::time_point GstStream::instant_of(GstSample* sample) const {
  const Clock::time_point now{Clock::now()};
  const GstClockTime stamp{GST_BUFFER_PTS(gst_sample_get_buffer(sample))};
  const GstPointer<GstClock> clock{gst_element_get_clock(pipeline_.get())};
  if (!GST_CLOCK_TIME_IS_VALID(stamp) || !clock) return now;
  const GstClockTime running{gst_segment_to_running_time(gst_sample_get_segment(sample), GST_FORMAT_TIME, stamp)};
  if (!GST_CLOCK_TIME_IS_VALID(running)) return now;
  const GstClockTime instant{gst_element_get_base_time(pipeline_.get()) + running};
  const GstClockTime at_present{gst_clock_get_time(clock.get())};
  if (instant >= at_present) return now;
  return now - std::chrono::nanoseconds{at_present - instant};
}

}  // namespace stereogrid::capture

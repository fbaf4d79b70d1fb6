// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::capture::testing {
namespace {

using ::testing::HasSubstr, ::testing::ThrowsMessage;

constexpr const char* size{"video/x-raw,width=32,height=16,framerate=30/1"};

std::string test_picture(const std::string& pattern, const std::string& options = "") {
  return "videotestsrc pattern=" + pattern + " " + options + " ! " + size + " ! videoconvert ! ";
}

TEST(GStreamer, JoinsTwoCameras) {
  const auto source{open_gstreamer(test_picture("white", "is-live=true") + "appsink name=left " +
                                       test_picture("black", "is-live=true") + "appsink name=right",
                                   small_calibration())};
  for (int i{0}; i < 5; ++i) {
    const auto frame{wait_for_frame(*source)};
    ASSERT_TRUE(frame) << source->fault();
    EXPECT_GT(frame->frame.left(5, 5), 230);
    EXPECT_LT(frame->frame.right(5, 5), 20);
    EXPECT_LT(Clock::now() - frame->captured, 5s);
  }
  EXPECT_EQ(source->fault(), "");
}

TEST(GStreamer, SplitsOneCamera) {
  const auto source{
      open_gstreamer("videotestsrc pattern=white ! video/x-raw,width=32,height=16 ! videobox right=-32 fill=black",
                     small_calibration())};
  const auto frame{wait_for_frame(*source)};
  ASSERT_TRUE(frame) << source->fault();
  EXPECT_GT(frame->frame.left(5, 5), 230);
  EXPECT_LT(frame->frame.right(5, 5), 20);
}

TEST(GStreamer, EndsWithAFile) {
  const auto source{open_gstreamer("videotestsrc num-buffers=8 ! video/x-raw,width=64,height=16,framerate=100/1",
                                   small_calibration())};
  int frames{0};
  while (wait_for_frame(*source)) ++frames;
  EXPECT_TRUE(source->has_ended());
  EXPECT_GT(frames, 0);
  EXPECT_EQ(source->fault(), "");
}

TEST(GStreamer, BeginsAFileAgain) {
  const auto source{open_gstreamer("videotestsrc num-buffers=3 ! video/x-raw,width=64,height=16,framerate=100/1",
                                   small_calibration(), {.loops = true})};
  std::int64_t last_ns{0};
  int rounds{0};
  while (rounds < 2) {
    const auto frame{wait_for_frame(*source)};
    ASSERT_TRUE(frame);
    EXPECT_GT(frame->frame.stamp_ns, last_ns);
    last_ns = frame->frame.stamp_ns;
    if (frame->resets_before) ++rounds;
  }
}

TEST(GStreamer, FindsACameraAgainThatWasLost) {
  // each time it is opened the camera fails after its fifth image
  const auto source{open_gstreamer(
      "videotestsrc is-live=true ! video/x-raw,width=64,height=16,framerate=50/1 ! identity error-after=6",
      small_calibration())};
  ASSERT_TRUE(wait_for_frame(*source));
  ASSERT_TRUE(becomes([&] { return source->fault().find("lost") != std::string::npos; }));
  while (source->next(0ms)) {
  }
  EXPECT_TRUE(wait_for_frame(*source)) << "was not opened again";
  EXPECT_TRUE(becomes([&] { return source->fault().find("lost") != std::string::npos; }));
}

TEST(GStreamer, TakesAStreamThatEndsThoughItIsLiveForALostCamera) {
  const auto source{open_gstreamer(
      "videotestsrc is-live=true num-buffers=4 ! video/x-raw,width=64,height=16,framerate=50/1", small_calibration())};
  ASSERT_TRUE(becomes([&] { return source->fault().find("has ended") != std::string::npos; }));
  EXPECT_FALSE(source->has_ended());
}

TEST(GStreamer, SaysWhatIsWrongWithImages) {
  const auto source{open_gstreamer("videotestsrc is-live=true ! video/x-raw,width=60,height=16", small_calibration())};
  ASSERT_TRUE(becomes([&] { return !source->fault().empty(); }));
  EXPECT_THAT(source->fault(), HasSubstr("60×16"));
  EXPECT_GT(dropped(*source, "cannot be used"), 0);
}

TEST(GStreamer, TriesAnEmptyFileAgainWithPauses) {
  const auto source{open_gstreamer("videotestsrc num-buffers=0 ! video/x-raw,width=64,height=16", small_calibration(),
                                   {.loops = true})};
  EXPECT_TRUE(becomes([&] { return source->fault().find("has ended") != std::string::npos; }));
}

TEST(GStreamer, SaysWhatWouldMendAPipelineThatDoesNotFit) {
  const auto source{open_gstreamer("videotestsrc ! video/x-raw,format=I420 ! appsink", small_calibration())};
  ASSERT_TRUE(becomes([&] { return !source->fault().empty(); }));
  EXPECT_THAT(source->fault(), HasSubstr("videoconvert"));
}

TEST(GStreamer, RefusesWhatIsNoPipeline) {
  for (const auto& refused : {std::pair{"nosuchelement ! appsink", "no element \"nosuchelement\""},
                              std::pair{"", "gst:"}, std::pair{"videotestsrc ! ! appsink", "gst:"},
                              std::pair{"videotestsrc ! appsink name=a videotestsrc ! appsink name=b", "name=left"}}) {
    EXPECT_THAT([&] { static_cast<void>(open_gstreamer(refused.first, small_calibration())); },
                ThrowsMessage<ConfigError>(HasSubstr(refused.second)));
  }
}

TEST(GStreamer, HasAPipelineForDevices) {
  const Rig rig{small_calibration().rig};
  const std::string pair{v4l2_pipeline("/dev/video97", "/dev/video99", rig)};
  EXPECT_THAT(pair, HasSubstr("device=\"/dev/video99\" ! video/x-raw,width=32,height=16"));
  EXPECT_THAT(pair, HasSubstr("appsink name=right"));
  const std::string single{v4l2_pipeline("/dev/video97", "", rig)};
  EXPECT_THAT(single, HasSubstr("width=64"));
  // no camera here: they are pipelines, and say so
  for (const std::string& description : {pair, single}) {
    const auto source{open_gstreamer(description, small_calibration())};
    EXPECT_TRUE(becomes([&] { return source->fault().find("/dev/video") != std::string::npos; })) << source->fault();
  }
}

}  // namespace
}  // namespace stereogrid::capture::testing

// SPDX-License-Identifier: Apache-2.0
//
// Pipelines on BackEnd::cuda and automatic, with an emulated GPU behind the library that they load.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/cuda_library.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"
#include "street.hpp"

namespace stereogrid::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::MatchesRegex;

Rig small_rig() {
  return Street::rig(101, 70);
}

Config small_config() {
  Config config{preset("default")};
  config.grid = {10, 8, 0.5};
  config.matching.disparities = 16;
  config.filter.speeds_mps = {1.25};
  return config;
}

/// The machine on which a test takes place.
class CudaLoading : public testing::Test {
 protected:
  void TearDown() override {
    unsetenv("STEREOGRID_CUDA_LIBRARY");
    unsetenv("STEREOGRID_EMULATOR_LACKS");
  }
  static void use_library(const std::string& file) { setenv("STEREOGRID_CUDA_LIBRARY", file.c_str(), 1); }
  static void lack(const std::string& what) { setenv("STEREOGRID_EMULATOR_LACKS", what.c_str(), 1); }

  static std::string error_text() {
    try {
      const Pipeline pipeline{small_config(), small_rig(), {.back_end = BackEnd::cuda}};
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(CudaLoading, GpuGivesWhatTheCpuGives) {
  use_library(EMULATED_LIBRARY);
  Pipeline gpu{small_config(), small_rig(), {.back_end = BackEnd::cuda}};
  Pipeline cpu{small_config(), small_rig(), {.threads = 1}};
  EXPECT_EQ(gpu.back_end(), BackEnd::cuda);
  EXPECT_EQ(cpu.back_end(), BackEnd::cpu);
  const Street street{small_rig()};
  for (int index{0}; index < 2; ++index) {
    const StereoFrame frame{street.frame(index)};
    const FrameResult& on_gpu{gpu.process(frame)};
    const FrameResult& on_cpu{cpu.process(frame)};
    EXPECT_EQ(on_gpu.observed, on_cpu.observed);
    EXPECT_EQ(on_gpu.world.occupancy, on_cpu.world.occupancy);
    EXPECT_EQ(on_gpu.stages.obstacle_disparity, on_cpu.stages.obstacle_disparity);
    EXPECT_GT(on_gpu.road_density, 0.1);
  }
}

// Levelled images, a refused frame and a leap of the clock, with several threads of the host.
TEST_F(CudaLoading, HostThreadsDoNotChangeResults) {
  use_library(EMULATED_LIBRARY);
  for (const double pitch_rad : {0.0, 0.2}) {
    Rig rig{small_rig()};
    rig.camera_pitch_rad = pitch_rad;
    const Street street{small_rig(), pitch_rad};
    Pipeline one{small_config(), rig, {.back_end = BackEnd::cuda, .threads = 1}};
    Pipeline three{small_config(), rig, {.back_end = BackEnd::cuda, .threads = 3}};
    EXPECT_EQ(three.threads(), 3) << "of the host";
    for (int index{0}; index < 8; ++index) {
      StereoFrame frame{street.frame(index)};
      if (index == 3) {
        frame.stamp_ns = street.frame(2).stamp_ns;
        EXPECT_THROW(three.process(frame), InputError);
        continue;
      }
      if (index >= 6) frame.stamp_ns += 100'000'000'000;
      const FrameResult& expected{one.process(frame)};
      const FrameResult& found{three.process(frame)};
      EXPECT_EQ(found.stages.obstacle_disparity, expected.stages.obstacle_disparity) << index;
      EXPECT_EQ(found.world.occupancy, expected.world.occupancy) << index;
      EXPECT_EQ(found.status, expected.status) << index;
      EXPECT_EQ(found.obstacles.size(), expected.obstacles.size()) << index;
      EXPECT_GT(found.road_density, 0.1);
    }
    EXPECT_EQ(three.save_state(), one.save_state());
  }
}

TEST_F(CudaLoading, FillsResultsOfTheCallers) {
  use_library(EMULATED_LIBRARY);
  Pipeline own{small_config(), small_rig(), {.back_end = BackEnd::cuda}};
  Pipeline callers{small_config(), small_rig(), {.back_end = BackEnd::cuda, .stages = false}};
  const Street street{small_rig()};
  FrameResult now;
  FrameResult before;
  for (int index{0}; index < 3; ++index) {
    const StereoFrame frame{street.frame(index)};
    const FrameResult& expected{own.process(frame)};
    std::swap(now, before);
    callers.process(frame, now);
    EXPECT_EQ(now.observed, expected.observed);
    EXPECT_EQ(now.vehicle.occupancy, expected.vehicle.occupancy);
    EXPECT_EQ(now.world.velocity_x, expected.world.velocity_x);
    EXPECT_EQ(now.world.geometry, expected.world.geometry);
    EXPECT_TRUE(now.stages.road_disparity.empty());
  }
}

TEST_F(CudaLoading, AGpuThatThereIsNot) {
  use_library(EMULATED_LIBRARY);
  const PipelineOptions second{.back_end = BackEnd::cuda, .device = 1};
  EXPECT_THAT([&] { Pipeline(small_config(), small_rig(), second); },
              ::testing::ThrowsMessage<DeviceError>(
                  HasSubstr("There is no GPU 1 on this machine: there are 1, counted from 0.")));
  const Pipeline on_cpu{small_config(), small_rig(), {.back_end = BackEnd::automatic, .device = 1}};
  EXPECT_THAT(on_cpu.why_not_cuda(), HasSubstr("no GPU 1"));
}

TEST_F(CudaLoading, SeveralCamerasFillOneGrid) {
  use_library(EMULATED_LIBRARY);
  for (const char* layout : {"around?cameras=2&turn_deg=40", "around?cameras=4"}) {
    const scenes::Scene scene{scenes::parse_scene(std::string{layout} + "&width=96&height=64&focal=48&frames=4"), 1};
    Config config{small_config()};
    config.grid.length_m = config.grid.rear_m = 10;
    Pipeline gpu{config, scene.rigs(), {.back_end = BackEnd::automatic}};
    Pipeline cpu{config, scene.rigs(), {.threads = 1}};
    EXPECT_EQ(gpu.back_end(), BackEnd::cuda);
    for (std::size_t i{0}; i < 4; ++i) {
      StereoFrame frame{scene.load(i)};
      if (i == 2) frame = StereoFrame{frame.others.front()};  // the others have none
      const FrameResult& on_gpu{gpu.process(frame)};
      const FrameResult& on_cpu{cpu.process(frame)};
      EXPECT_EQ(on_gpu.observed, on_cpu.observed) << layout;
      EXPECT_EQ(on_gpu.vehicle.occupancy, on_cpu.vehicle.occupancy) << layout;
      EXPECT_EQ(on_gpu.vehicle.velocity_x, on_cpu.vehicle.velocity_x) << layout;
      EXPECT_EQ(on_gpu.world_terrain, on_cpu.world_terrain) << layout;
      EXPECT_EQ(on_gpu.obstacles.size(), on_cpu.obstacles.size()) << layout;
      EXPECT_GT(std::ranges::count_if(on_cpu.observed, [](float p) { return p > 0.8f; }), 0) << layout;
      for (std::size_t camera{0}; camera < scene.rigs().size(); ++camera) {
        EXPECT_EQ(on_gpu.cameras[camera].observed, on_cpu.cameras[camera].observed) << layout;
        EXPECT_EQ(on_gpu.cameras[camera].ground, on_cpu.cameras[camera].ground) << layout;
        EXPECT_EQ(on_gpu.cameras[camera].has_images, i != 2 || camera == 1) << layout;
      }
    }
  }
}

// The emulated device's memory is the host's.
TEST_F(CudaLoading, ImagesAndGridsInDeviceMemory) {
  use_library(EMULATED_LIBRARY);
  constexpr std::ptrdiff_t gap{7};  // behind each row
  for (const double pitch_rad : {0.0, 0.2}) {
    Rig rig{small_rig()};
    rig.camera_pitch_rad = pitch_rad;
    std::vector<FrameResult> early;
    const auto note = [&early](const FrameResult& result) { early.push_back(result); };
    Pipeline device{small_config(), rig, {.back_end = BackEnd::cuda, .on_grids = note}};
    Pipeline host{small_config(), rig, {.back_end = BackEnd::cuda}};
    const Street street{small_rig(), pitch_rad};
    FrameResult found;
    for (int index{0}; index < 4; ++index) {
      const StereoFrame frame{street.frame(index)};
      const auto padded = [&](const Image<std::uint8_t>& image) {
        Image<std::uint8_t> wide{image.width() + static_cast<int>(gap), image.height(), 77};
        for (int v{0}; v < image.height(); ++v) std::copy_n(image.row(v), image.width(), wide.row(v));
        return wide;
      };
      const Image<std::uint8_t> left{padded(frame.left)};
      const Image<std::uint8_t> right{padded(frame.right)};
      const Image<float> disparity{rig.width_px, rig.height_px, 5};
      const View<const std::uint8_t, Device> seen{left.data(), rig.width_px, rig.height_px, rig.width_px + gap};
      StereoFrame expected_frame{frame};
      StereoFrame without{frame};
      without.left = without.right = {};
      DeviceImages images{.left = seen, .right = seen};
      images.right.data = right.data();
      if (index == 2) {
        images.right = {};
        images.disparity = {disparity.data(), rig.width_px, rig.height_px, rig.width_px};
        expected_frame.right = {};
        expected_frame.disparity = disparity;
      }
      device.process_from_device(without, images, found);
      ASSERT_EQ(early.size(), static_cast<std::size_t>(index) + 1);
      EXPECT_EQ(early.back().world.occupancy, found.world.occupancy) << index;
      EXPECT_TRUE(early.back().obstacles.empty());
      const FrameResult& expected{host.process(expected_frame)};
      EXPECT_EQ(found.observed, expected.observed) << index;
      EXPECT_EQ(found.world.occupancy, expected.world.occupancy) << index;
      EXPECT_EQ(found.obstacles.size(), expected.obstacles.size()) << index;
      const DeviceGrids grids{device.device_grids()};
      const auto expect_equal = [](const float* there, const Image<float>& image) {
        EXPECT_TRUE(std::equal(image.begin(), image.end(), there));
      };
      expect_equal(grids.observed, expected.observed);
      expect_equal(grids.vehicle, expected.vehicle.occupancy);
      expect_equal(grids.vehicle + expected.vehicle.age_s.size() * 3, expected.vehicle.age_s);
      expect_equal(grids.world + expected.world.moving.size() * 7, expected.world.moving);
    }
    EXPECT_EQ(device.save_state(), host.save_state());
  }
}

TEST_F(CudaLoading, ImagesInDeviceMemoryThatCannotBeUsed) {
  use_library(EMULATED_LIBRARY);
  const StereoFrame frame{Street{small_rig()}.frame(0)};
  const View<const std::uint8_t, Device> image{frame.left.data(), 101, 70, 101};
  Pipeline gpu{small_config(), small_rig(), {.back_end = BackEnd::cuda}};
  FrameResult result;
  const auto expect_refused = [&](View<const std::uint8_t, Device> left, const char* problem) {
    EXPECT_THAT([&] { gpu.process_from_device(frame, {.left = left, .right = image}, result); },
                ::testing::ThrowsMessage<InputError>(HasSubstr(problem)));
  };
  expect_refused({image.data, 100, 70, 101}, "100 × 70 pixels");
  expect_refused({image.data, 101, 70, 90}, "rows that overlap");
  expect_refused({image.data, 101, 70, -101}, "negative pitch");
  expect_refused({nullptr, 101, 70, 101}, "no pixels");
  EXPECT_THROW(static_cast<void>(gpu.device_grids()), InputError);
  Pipeline cpu{small_config(), small_rig(), {.threads = 1}};
  const auto is_refused = ::testing::ThrowsMessage<ConfigError>(HasSubstr("images in the host's memory, or the back"));
  EXPECT_THAT([&] { cpu.process_from_device(frame, {.left = image, .right = image}, result); }, is_refused);
  EXPECT_THAT([&] { static_cast<void>(cpu.device_grids()); }, is_refused);
}

TEST_F(CudaLoading, AutomaticLeavesPredictionsToTheCpu) {
  use_library(EMULATED_LIBRARY);
  const Pipeline pipeline{small_config(), small_rig(), {.back_end = BackEnd::automatic, .horizons_s = {1}}};
  EXPECT_EQ(pipeline.back_end(), BackEnd::cpu);
  EXPECT_THAT(pipeline.why_not_cuda(), HasSubstr("Predictions"));
}

TEST_F(CudaLoading, AutomaticContinuesOnTheCpuWhereTheGpuIsLost) {
  use_library(EMULATED_LIBRARY);
  const Street street{small_rig()};
  std::vector<std::vector<FrameStatus>> of_grids;
  const auto note = [&of_grids](const FrameResult& result) { of_grids.push_back(result.status); };
  Pipeline pipeline{small_config(), small_rig(), {.back_end = BackEnd::automatic, .on_grids = note}};
  Pipeline cuda{small_config(), small_rig(), {.back_end = BackEnd::cuda}};
  Pipeline fresh{small_config(), small_rig(), {.back_end = BackEnd::cpu}};
  for (int index{0}; index < 2; ++index) {
    EXPECT_TRUE(pipeline.process(street.frame(index)).status.empty());
    cuda.process(street.frame(index));
  }
  lack("device");
  EXPECT_THROW(cuda.process(street.frame(2)), DeviceError) << "asked for by name";
  const FrameResult& lost{pipeline.process(street.frame(2))};
  EXPECT_EQ(lost.status, std::vector{FrameStatus::gpu_lost});
  EXPECT_EQ(of_grids, (std::vector<std::vector<FrameStatus>>{{}, {}, lost.status}));
  EXPECT_THAT(lost.warnings.back().text, HasSubstr("no CUDA-capable device is detected"));
  EXPECT_EQ(pipeline.back_end(), BackEnd::cpu);
  EXPECT_EQ(lost.observed, fresh.process(street.frame(2)).observed);
  EXPECT_TRUE(pipeline.process(street.frame(3)).status.empty());
}

TEST_F(CudaLoading, AutomaticTakesTheGpu) {
  use_library(EMULATED_LIBRARY);
  const Pipeline pipeline{small_config(), small_rig(), {.back_end = BackEnd::automatic}};
  EXPECT_EQ(pipeline.back_end(), BackEnd::cuda);
  EXPECT_EQ(pipeline.why_not_cuda(), "");
}

TEST_F(CudaLoading, AutomaticFallsBackToTheCpuAndSaysWhy) {
  use_library(EMULATED_LIBRARY);
  lack("device");
  Pipeline pipeline{small_config(), small_rig(), {.back_end = BackEnd::automatic, .threads = 1}};
  EXPECT_EQ(pipeline.back_end(), BackEnd::cpu);
  EXPECT_THAT(pipeline.why_not_cuda(), HasSubstr("No NVIDIA GPU was found"));
  EXPECT_GT(pipeline.process(Street{small_rig()}.frame(0)).road_density, 0.1);
}

TEST_F(CudaLoading, NoLibrary) {
  use_library("");
  EXPECT_THAT(error_text(), HasSubstr("libstereogrid_cuda.so was not found"));
}

TEST_F(CudaLoading, LibraryThatIsNotThere) {
  use_library("no/such/library.so");
  EXPECT_THAT(error_text(), HasSubstr("no/such/library.so could not be loaded"));
}

TEST_F(CudaLoading, LibraryOfAnotherVersion) {
  use_library(OTHER_SOURCES);
  const std::string mine{build_id()};
  EXPECT_THAT(error_text(),
              AllOf(HasSubstr(OTHER_SOURCES), HasSubstr("belongs to stereogrid 0.0.1+0123; this is " + mine)));
  EXPECT_THAT(mine, MatchesRegex("[0-9.]+\\+[0-9a-f]{16}"));
}

TEST_F(CudaLoading, LibraryOfTheSameSourcesBuiltOtherwise) {
  use_library(OTHER_SIZES);
  EXPECT_THAT(error_text(), AllOf(HasSubstr(OTHER_SIZES), HasSubstr("structures have other sizes")));
}

TEST_F(CudaLoading, LibraryWithoutItsFunction) {
  use_library(OTHER_FUNCTION);
  EXPECT_THAT(error_text(), HasSubstr("has no function stereogrid_cuda_library_4"));
}

TEST_F(CudaLoading, NoDevice) {
  use_library(EMULATED_LIBRARY);
  lack("device");
  EXPECT_THAT(error_text(), HasSubstr("No NVIDIA GPU was found"));
}

TEST_F(CudaLoading, DriverThatIsTooOld) {
  use_library(EMULATED_LIBRARY);
  lack("driver");
  EXPECT_THAT(error_text(), HasSubstr("driver is too old: it serves CUDA 10.0"));
}

TEST_F(CudaLoading, NoCodeForTheDevice) {
  use_library(EMULATED_LIBRARY);
  lack("kernels");
  EXPECT_THAT(error_text(), AllOf(HasSubstr("no code for the GPU, whose compute capability is"),
                                  HasSubstr("CMAKE_CUDA_ARCHITECTURES")));
}

TEST_F(CudaLoading, TooLittleMemory) {
  use_library(EMULATED_LIBRARY);
  lack("memory");
  EXPECT_THAT(error_text(), HasSubstr("The GPU's memory is too small"));
}

}  // namespace
}  // namespace stereogrid::test

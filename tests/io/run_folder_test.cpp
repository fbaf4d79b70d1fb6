// SPDX-License-Identifier: Apache-2.0
#include <regex>

#include "stereogrid/io/file.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/run_folder/checkpoint.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "support.hpp"

// The library reads a run that it has written. The tool's tests cover the files' contents.
namespace stereogrid::io::testing {
namespace {

using ::testing::ElementsAre, ::testing::HasSubstr;

constexpr GridGeometry grid{0, -1, 0.5, 3, 4};
constexpr Rig given_rig{160, 100, 80, 79.5, 50, 0.5, 1.65, 0, 0};

RunDescription description() {
  RunDescription run;
  run.preset = "paper";
  run.config = preset("paper");
  run.input = {"plain folder", {"drives/one"}, "odometry", "drives/one/calibration.yaml", ""};
  run.matcher = "own";
  run.fuse_source = "none";
  run.device = "cpu";
  run.rig = given_rig;
  run.grid = grid;
  run.world_grid = {0, 0, 0.25, 2, 3};
  run.frames = {5, 9};
  return run;
}

/// Rig estimated by the run up to the frame.
Rig rig_at(std::int64_t index) {
  Rig rig{given_rig};
  rig.camera_height_m = static_cast<double>(index);
  rig.camera_pitch_rad = 0.01 * static_cast<double>(index);
  rig.camera_roll_rad = -0.002;
  return rig;
}

StereoFrame frame_at(std::int64_t index) {
  StereoFrame frame;
  frame.name = "frame_" + std::to_string(index);
  frame.index = index;
  frame.stamp_ns = index * 100'000'000;
  return frame;
}

FrameResult result_of(std::int64_t index) {
  FrameResult result;
  const Image<float> zero{grid.nx, grid.ny};
  result.observed = zero;
  result.vehicle = {grid, zero, zero, zero, zero, zero, zero, zero, zero};
  const Image<float> none{2, 3};
  result.world = {{-1.5, 2.25, 0.25, 2, 3}, none, none, none, none, none, none, none, none};
  result.world.occupancy(1, 2) = 0.75F;
  result.world_from_vehicle = {1, 2, 0.5};
  result.vehicle.occupancy.fill(static_cast<float>(index) / 10);
  result.vehicle.velocity_y(2, 1) = -3;
  result.timing_ms.total = static_cast<double>(index);
  result.warnings = {{"dark", FrameStatus::few_matches}, {"no lidar"}};
  result.status = {FrameStatus::few_matches};
  result.obstacles.emplace_back();
  result.obstacles.back().id = 7;
  result.obstacles.back().x_m = 1.25;
  result.obstacles.back().velocity_covariance = {4, -1, 2};
  return result;
}

/// Frames 5 and 7 of four are done; 6 is skipped.
struct RunFolder : FolderTest {
  void SetUp() override {
    RunRecord record{folder.path(), description()};
    record.begin();
    create_folder(folder / "grids");
    std::string lines;
    for (const std::int64_t index : {5, 7}) {
      const FrameResult result{result_of(index)};
      write_grids(folder / "grids" / (frame_at(index).name + ".npz"), result);
      lines += frame_line(frame_at(index), result, rig_at(index)) + "\n";
      record.add_frame({static_cast<std::size_t>(index), result.timing_ms, result.warnings, result.status});
    }
    record.add_skipped({6, "frame_6", "damaged"});
    put(folder / "frames.jsonl", lines);
    record.save(false);
  }
};

TEST_F(RunFolder, IsReadAgain) {
  const RunReader run{folder.path()};
  EXPECT_EQ(run.grid(), grid);
  EXPECT_EQ(run.preset(), "paper");
  EXPECT_EQ(run.rig(), given_rig);
  EXPECT_EQ(run.input().kind, "plain folder");
  EXPECT_THAT(run.input().paths, ElementsAre("drives/one"));
  EXPECT_EQ(run.input().calibration, "drives/one/calibration.yaml");
  ASSERT_EQ(run.frames().size(), 2U);
  EXPECT_EQ(run.frames()[1].index, 7U);
  EXPECT_EQ(run.frames()[1].name, "frame_7");
  EXPECT_EQ(run.frames()[1].world_from_vehicle, (Pose2{1, 2, 0.5}));
  EXPECT_EQ(run.frames()[1].timing_ms.total, 7);
  EXPECT_EQ(run.frames()[1].stamp_ns, 700'000'000);
  ASSERT_EQ(run.frames()[1].obstacles.size(), 1U);
  EXPECT_EQ(run.frames()[1].obstacles[0].id, 7);
  EXPECT_EQ(run.frames()[1].obstacles[0].x_m, 1.25);
  EXPECT_EQ(run.frames()[1].obstacles[0].velocity_covariance.xy, -1);
  const RunGrids grids{run.grids("frame_7")};
  EXPECT_EQ(grids.occupancy(0, 3), 0.7F);
  EXPECT_EQ(grids.velocity_y(2, 1), -3);
  EXPECT_EQ(grids.velocity_x(2, 1), 0);
}

TEST_F(RunFolder, SaysWhichLayersItWasWrittenWithout) {
  RunDescription some{description()};
  some.layers = {"occupancy", "velocity"};
  RunRecord{folder.path(), some}.save(false);
  write_grids(folder / "grids" / "frame_7.npz", result_of(7), some.layers);
  const RunReader run{folder.path()};
  EXPECT_EQ(run.occupancy("frame_7")(0, 3), 0.7F);
  expect_error([&] { return run.grids("frame_7"); },
               {"was written without the layer observed", "it has occupancy, velocity", "--layers"});
  expect_error([&] { return run.world_grid("frame_7"); }, {"without the layer world_occupancy"});
}

TEST(CheckpointsOfSparseRuns, BelongToFramesThatAreWritten) {
  const auto due = [](Checkpoints checkpoints) {
    std::vector<std::size_t> frames;
    for (std::size_t i{0}; i < 40; ++i) {
      if (checkpoints.is_due_after(i)) frames.push_back(i);
    }
    return frames;
  };
  EXPECT_THAT(due({3, 10}), ElementsAre(12, 22, 32));
  EXPECT_THAT(due({3, 10, 4}), ElementsAre(12, 24, 32));
  EXPECT_THAT(due({3, 10, 15}), ElementsAre(15, 30));
  EXPECT_THAT(due({3, 1, 15}), ElementsAre(15, 30));
  EXPECT_THAT(due({0, 0, 4}), ElementsAre());
  EXPECT_EQ(multiples_between(0, 0, 7), 1U);
  EXPECT_EQ(multiples_between(1, 6, 7), 0U);
  EXPECT_EQ(multiples_between(1, 14, 7), 2U);
  EXPECT_EQ(multiples_between(7, 3, 7), 0U);
}

TEST_F(RunFolder, HasTheWorldsGridWhereItWas) {
  const RunWorldGrid world{RunReader{folder.path()}.world_grid("frame_7")};
  EXPECT_EQ(world.geometry, (GridGeometry{-1.5, 2.25, 0.25, 2, 3}));
  EXPECT_EQ(world.occupancy(1, 2), 0.75F);
  std::string run{read_text(folder / "run.json", 100'000)};
  run.replace(run.find("world_grid"), 10, "other_grid");
  put(folder / "run.json", run);
  expect_error([&] { return RunReader{folder.path()}.world_grid("frame_7"); },
               {"run.json", "how large the cells", "older version"});
  const std::vector<double> one{1};
  const std::vector<NpzArray> arrays{NpzArray{"world_origin", {1}, one}};
  write_npz(folder / "grids" / "frame_7.npz", arrays);
  expect_error([&] { return RunReader{folder.path()}.world_grid("frame_7"); }, {"frame_7.npz", "world_origin"});
}

TEST_F(RunFolder, SaysHowTheCameraWasMounted) {
  const RunReader run{folder.path()};
  EXPECT_EQ(run.rig_of(run.frames()[0]), rig_at(5));
  EXPECT_EQ(run.rig_of(run.frames()[1]), rig_at(7));
  const std::string lines{read_text(folder / "frames.jsonl", 100'000)};
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text{lines};
    for (std::size_t at{0}; (at = text.find(from)) != std::string::npos;) text.replace(at, from.size(), to);
    put(folder / "frames.jsonl", text);
    return RunReader{folder.path()};
  };
  // without a ground plane: that of the next frame
  const RunReader unknown{changed("few_matches", "road_unknown")};
  EXPECT_EQ(unknown.rig_of(unknown.frames()[0]), rig_at(7));
  EXPECT_EQ(unknown.rig_of(unknown.frames()[1]), rig_at(7));
  const RunReader old{changed("\"mount\"", "\"other\"")};
  EXPECT_EQ(old.rig_of(old.frames()[0]), given_rig);
  expect_error([&] { changed("\"camera_roll_rad\":-0.002", "\"camera_roll_rad\":3"); }, {"whose rig is none"});
  expect_error([&] { changed("\"camera_roll_rad\":-0.002", "\"camera_roll_rad\":\"x\""); }, {"line 1"});
}

TEST_F(RunFolder, MayHaveOutlinesOfObstacles) {
  ASSERT_EQ(RunReader{folder.path()}.frames()[0].obstacles.size(), 1U);
  const std::string lines{read_text(folder / "frames.jsonl", largest_bytes::json)};
  const auto with = [&](const std::string& fields) {
    std::string changed{lines};
    for (const std::string name : {"\"kind\"", "\"outline_m\""}) changed.replace(changed.find(name), 2, "\"_");
    const std::string before{"\"x_m\":1.25,"};
    changed.replace(changed.find(before), before.size(), before + fields);
    put(folder / "frames.jsonl", changed);
    return RunReader{folder.path()}.frames();
  };
  const auto frames{with(R"("outline_m":[[1,2],[3,4.5]],"kind":"extended",)")};
  ASSERT_EQ(frames[0].obstacles.size(), 1U);
  ASSERT_EQ(frames[0].obstacles[0].outline.size(), 2U);
  EXPECT_EQ(frames[0].obstacles[0].outline[1].y, 4.5);
  EXPECT_EQ(frames[0].obstacles[0].kind, ObstacleKind::boundary);
  const auto none{with(R"("outline_m":null,)")};
  EXPECT_TRUE(none[0].obstacles[0].outline.empty());
  EXPECT_EQ(none[0].obstacles[0].kind, ObstacleKind::object);
  const auto refuses = [&](const std::string& fields) {
    expect_error([&] { return with(fields); }, {"frames.jsonl", "line 1 is not understood"});
  };
  refuses(R"("outline_m":{},)");
  refuses(R"("outline_m":[[1]],)");
  refuses(R"("outline_m":[[1,1e9]],)");
  refuses(R"("outline_m":[[1,"2"]],)");
  refuses(R"("kind":3,)");
  std::string many{"[0,0]"};
  for (std::size_t i{0}; i < Outline::points_max; ++i) many += ",[0,0]";
  refuses("\"outline_m\":[" + many + "],");
}

TEST_F(RunFolder, KeepsHowObstaclesTurnAndHowSurelyTheirBoxesAreKnown) {
  FrameResult result;
  result.obstacles.resize(2);
  result.obstacles[1].yaw_rate_radps = -0.21234;
  result.obstacles[1].length_sigma_m = 0.15678;
  result.obstacles[1].yaw_sigma_rad = 0.02;
  for (const bool compact : {false, true}) {
    const std::string line{frame_line(frame_at(0), result, {}, compact)};
    put(folder / "lines.jsonl", line + "\n");
    const auto read{read_run_frames(folder / "lines.jsonl").at(0).obstacles};
    EXPECT_THAT(line, HasSubstr("\"width_sigma_m\":null")) << "unknown";
    EXPECT_EQ(read.at(0).yaw_rate_radps, 0);
    EXPECT_TRUE(std::isinf(read.at(0).yaw_sigma_rad));
    EXPECT_EQ(read.at(1).yaw_rate_radps, compact ? -0.212 : -0.21234);
    EXPECT_EQ(read.at(1).length_sigma_m, compact ? 0.157 : 0.15678);
    EXPECT_TRUE(std::isinf(read.at(1).width_sigma_m));
    EXPECT_EQ(read.at(1).yaw_sigma_rad, 0.02);
  }
}

TEST_F(RunFolder, KeepsTheSpeedLimitAndItsReason) {
  const auto read_back = [&](const FrameResult& result) {
    put(folder / "lines.jsonl", frame_line(frame_at(0), result, {}, false) + "\n");
    return read_run_frames(folder / "lines.jsonl").at(0);
  };
  FrameResult result;
  EXPECT_TRUE(std::isinf(read_back(result).speed_limit_mps));
  result.speed_limit_mps = 2.5;
  result.speed_limit_reason = SpeedReason::descents;
  const RunFrame read{read_back(result)};
  EXPECT_EQ(read.speed_limit_mps, 2.5);
  EXPECT_EQ(read.speed_limit_reason, SpeedReason::descents);
}

TEST_F(RunFolder, GoesOnWithWhatItHolds) {
  RunRecord record{folder.path(), description()};
  record.resume();
  ASSERT_EQ(record.finished().size(), 2U);
  EXPECT_EQ(record.finished()[1].index, 7U);
  EXPECT_EQ(record.finished()[1].warnings, result_of(7).warnings);
  EXPECT_EQ(record.frames_with(FrameStatus::few_matches), 2U);
  EXPECT_EQ(record.frames_with(FrameStatus::road_unknown), 0U);
  ASSERT_EQ(record.skipped().size(), 1U);
  EXPECT_EQ(record.skipped()[0].reason, "damaged");
  EXPECT_THAT(record.unaccounted(), ElementsAre());
  EXPECT_DOUBLE_EQ(record.timing(&StageTimes::total).mean, 6);
}

// Also where an editor has put a mark of the byte order before it.
TEST_F(RunFolder, LosesNoMoreThanATornLine) {
  const fs::path lines{folder / "frames.jsonl"};
  for (const std::string mark : {"", "\xef\xbb\xbf"}) {
    const std::string whole{mark + frame_line(frame_at(5), result_of(5), rig_at(5)) + "\n"};
    put(lines, whole + R"({"index": 6, "na)");
    EXPECT_EQ(take_finished_frames(lines).size(), 1U);
    EXPECT_EQ(fs::file_size(lines), whole.size());
    EXPECT_EQ(take_finished_frames(lines).size(), 1U);
  }
}

TEST_F(RunFolder, GoesOnWithItsOwnSettingsOnly) {
  RunDescription other{description()};
  other.config.grid.length_m += 1;
  other.threads += 1;
  expect_error<ConfigError>([&] { RunRecord(folder.path(), other).resume(); },
                            {"begun with other settings", "config/grid/length_m"});
  other = description();
  other.frames.first = 4;
  expect_error<ConfigError>([&] { RunRecord(folder.path(), other).resume(); }, {"first frame: was 5, is 4"});
  const std::string record{read_file(folder / "run.json")};
  put(folder / "run.json", std::regex_replace(record, std::regex{R"(,\s*"rear_m":[^,}]*)"}, ""));
  expect_error<ConfigError>([&] { RunRecord(folder.path(), description()).resume(); },
                            {"by another version", "another --out", "config/grid/rear_m: was null"});
  put(folder / "run.json", record);
  expect_error<ConfigError>([&] { RunRecord(folder.path(), description()).begin(); }, {"already holds a run"});
}

TEST_F(RunFolder, KeepsWhatPipelineAndOdometryRemember) {
  EXPECT_FALSE(read_checkpoint(folder.path()).has_value());
  OdometryState odometry;
  odometry.reference = Image<std::uint8_t>{4, 3, 9};
  odometry.landmarks.resize(2);
  odometry.speed = {1, 2, 3, 4, 5, 6};
  odometry.last_stamp_ns = 123;
  odometry.covariance_at_reference[8] = 0.25;
  odometry.covariance_since_reference[0] = 0.5;
  write_checkpoint(folder.path(), {7, {std::byte{1}, std::byte{2}}, odometry});
  const auto read{read_checkpoint(folder.path())};
  ASSERT_TRUE(read && read->odometry);
  EXPECT_EQ(read->index, 7U);
  EXPECT_THAT(read->pipeline, ElementsAre(std::byte{1}, std::byte{2}));
  EXPECT_EQ(read->odometry->reference, odometry.reference);
  EXPECT_EQ(read->odometry->landmarks.size(), 2U);
  EXPECT_EQ(read->odometry->speed, odometry.speed);
  EXPECT_EQ(read->odometry->last_stamp_ns, 123);
  EXPECT_EQ(read->odometry->covariance_at_reference, odometry.covariance_at_reference);
  EXPECT_EQ(read->odometry->covariance_since_reference, odometry.covariance_since_reference);
}

}  // namespace
}  // namespace stereogrid::io::testing

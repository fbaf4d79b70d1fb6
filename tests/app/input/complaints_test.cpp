// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using BadFrame = FolderTest;
using ExitCodes = FolderTest;

/// A simulated drive on the disk.
void simulate(const fs::path& folder, const std::string& scene, const std::string& more) {
  run_well({"simulate", small_scene(scene, more), "--out", folder});
}

std::vector<std::string> run_words(const fs::path& input, const fs::path& out) {
  return {"run", input, "--out", out};
}

void cut_in_half(const fs::path& path) {
  fs::resize_file(path, fs::file_size(path) / 2);
}

TEST_F(BadFrame, InTheMiddleIsSkippedAndCounted) {
  simulate(folder / "drive", "street", "&frames=5");
  cut_in_half(folder / "drive" / "left" / "000002.png");
  const Outcome outcome{run_well(run_words(folder / "drive", folder / "run"))};
  EXPECT_THAT(outcome.errors, HasSubstr("000002"));
  EXPECT_THAT(outcome.output, HasSubstr("4 frames, 1 of 5 skipped"));
  const Json run(json_of(folder / "run" / "run.json"));
  EXPECT_EQ(run["frames"]["done"], 4);
  EXPECT_EQ(run["frames"]["complete"], true);
  ASSERT_EQ(run["skipped"].size(), 1U);
  EXPECT_EQ(run["skipped"][0]["name"], "000002");
  EXPECT_THAT(run["skipped"][0]["reason"].get<std::string>(), HasSubstr("000002.png"));
  const std::vector<Json> lines(lines_of(folder / "run"));
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[2]["index"], 3);
  EXPECT_FALSE(fs::exists(folder / "run" / "grids" / "000002.npz"));
}

TEST_F(BadFrame, AtTheStartIsSkippedToo) {
  simulate(folder / "drive", "street", "&frames=3");
  cut_in_half(folder / "drive" / "right" / "000000.png");
  run_well(run_words(folder / "drive", folder / "run"));
  EXPECT_EQ(lines_of(folder / "run").size(), 2U);
}

TEST_F(BadFrame, EverywhereEndsTheRunBeforeItBegins) {
  simulate(folder / "drive", "street", "&frames=2");
  for (const char* name : {"000000.png", "000001.png"}) cut_in_half(folder / "drive" / "left" / name);
  EXPECT_THAT(errors_of(65, run_words(folder / "drive", folder / "run")), HasSubstr("000000.png"));
  EXPECT_FALSE(fs::exists(folder / "run" / "run.json"));
}

TEST(Swapped, LeftAndRightAreRefused) {
  const TemporaryFolder folder;
  run_well({"simulate", "scene:street?frames=2&width=320&height=200", "--out", folder / "drive"});
  fs::rename(folder / "drive" / "left", folder / "drive" / "other");
  fs::rename(folder / "drive" / "right", folder / "drive" / "left");
  fs::rename(folder / "drive" / "other", folder / "drive" / "right");
  const Outcome run{run_tool(run_words(folder / "drive", folder / "run"))};
  EXPECT_EQ(run.exit_code, 65);
  EXPECT_THAT(run.errors, HasSubstr("swapped"));
  EXPECT_FALSE(fs::exists(folder / "run" / "run.json"));
  const Outcome info{run_tool({"info", folder / "drive"})};
  EXPECT_EQ(info.exit_code, 65);
  EXPECT_THAT(info.output, HasSubstr("swapped"));
}

TEST_F(ExitCodes, WrongUsageIs64) {
  const std::string out{folder / "run"};
  for (const Refused& wrong :
       std::vector<Refused>{{{}, "command"},
                            {{"fly"}, "fly"},
                            {{"run", "scene:empty"}, "--out"},
                            {{"run", "scene:empty", "--out", out, "--frobnicate"}, "--frobnicate"},
                            {{"run", "scene:empty", "--out", out, "--no\xff"}, R"(--no\xFF)"},
                            {{"run", "scene:empty", "--out", out, "--device", "abacus"}, "abacus"},
                            {{"run", "scene:empty", "--out", out, "--device", "cuda:first"}, "cuda:1"},
                            {{"run", "scene:empty", "--out", out, "--device", "cuda:-1"}, "cuda:1"},
                            {{"run", "scene:empty", "--out", out, "--set", "grid.lenght_m=3"}, "grid.length_m"},
                            {{"run", "scene:empty", "--out", out, "--set", "grid.length_m"}, "KEY=VALUE"},
                            {{"run", "scene:empty", "--out", out, "--set", "no\xff=UTF-8"}, R"(no\xFF)"},
                            {{"run", "scene:empty", "--out", out, "--set", "grid.length_m=-3"}, "must lie in"},
                            {{"run", "scene:empty", "--out", out, "--value-scale", "nav2"}, "--value-scale is of"},
                            {{"run", "scene:empty", "--out", out, "--preset", "nice"}, "preset"},
                            {{"run", "scene:empty", "--out", out, "--calibration", "x.yaml"}, "scene"},
                            {{"run", "scene:empty", "--out", out, "--resume", "--video", "x.mp4"}, "--video"}}) {
    expect_refused(wrong);
  }
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(ExitCodes, BadInputIs65) {
  const std::string out{folder / "run"};
  fs::create_directory(folder / "nothing");
  EXPECT_EQ(run_tool({"run", folder / "not_there", "--out", out}).exit_code, 65);
  EXPECT_EQ(run_tool({"run", folder / "nothing", "--out", out}).exit_code, 65);
  EXPECT_EQ(run_tool({"run", "scene:moon", "--out", out}).exit_code, 65);
  EXPECT_THAT(run_tool({"run", "scene:no\xff", "--out", out}).errors, HasSubstr(R"(no\xFF)"));
  EXPECT_EQ(run_tool({"run", "scene:empty", "--out", out, "--config", folder / "no.yaml"}).exit_code, 65);
  EXPECT_EQ(run_tool({"info", folder / "nothing"}).exit_code, 65);
  EXPECT_EQ(run_tool({"evaluate", folder / "nothing", "scene:empty"}).exit_code, 65);
  EXPECT_FALSE(fs::exists(out));
}

// on a machine with a GPU, too
constexpr const char* no_cuda{"STEREOGRID_CUDA_LIBRARY=missing.so"};

TEST(Device, AutoFallsBackToTheCpuAndSaysSo) {
  const TemporaryFolder folder;
  const fs::path out{folder / "run"};
  const Outcome outcome{
      run_tool({"run", small_scene("empty", "&frames=1"), "--out", out, "--device", "auto"}, no_cuda)};
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.errors, HasSubstr("on the CPU. No GPU: The CUDA library missing.so"));
  EXPECT_EQ(json_of(out / "run.json")["device"], "cpu");
  // without --device auto: only with -v
  const std::string scene{small_scene("empty", "&frames=1")};
  EXPECT_THAT(errors_of(0, {"run", scene, "--out", folder / "other"}, no_cuda), Not(HasSubstr("GPU")));
  EXPECT_THAT(errors_of(0, {"run", scene, "--out", folder / "verbose", "-v"}, no_cuda),
              HasSubstr("on the CPU. No GPU"));
}

TEST_F(ExitCodes, WhatMayWorkLaterIs75) {
  const std::string out{folder / "run"};
  const std::string scene{small_scene("empty", "&frames=1")};
  EXPECT_THAT(errors_of(75, {"run", scene, "--out", out, "--device", "cuda"}, no_cuda),
              ::testing::AllOf(HasSubstr("--device cuda"), HasSubstr("missing.so could not be loaded")));
  std::ofstream{folder / "a_file"} << "x";
  EXPECT_EQ(run_tool({"run", scene, "--out", folder / "a_file" / "run"}).exit_code, 75);
  EXPECT_THAT(errors_of(75, {"run", scene, "--out", out, "--video", "x.mp4"}, "PATH=/nonexistent"),
              HasSubstr("ffmpeg"));
}

TEST(Quiet, SaysNothing) {
  const TemporaryFolder folder;
  const Outcome outcome{run_well({"run", small_scene("empty", "&frames=1"), "--out", folder / "run", "--quiet"})};
  EXPECT_EQ(outcome.output, "");
  EXPECT_EQ(outcome.errors, "");
}

}  // namespace
}  // namespace stereogrid::app::testing

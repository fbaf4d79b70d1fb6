// SPDX-License-Identifier: Apache-2.0
//
// Runs of which only a part is written: --every, --layers.
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using Sparse = FolderTest;

Words street(const fs::path& out, const Words& more) {
  return joined({"run", "scene:street?frames=40&width=160&height=100", "--out", out}, more);
}

std::vector<std::size_t> indices_of(const fs::path& run) {
  std::vector<std::size_t> indices;
  for (const Json& line : lines_of(run)) indices.push_back(line["index"]);
  return indices;
}

void expect_equal_frames(const fs::path& some, const fs::path& all) {
  const std::vector<Json> lines(lines_of(all, false));
  for (const Json& line : lines_of(some, false)) {
    EXPECT_EQ(line, lines.at(line["index"].get<std::size_t>()));
    const std::string file{line["name"].get<std::string>() + ".npz"};
    EXPECT_EQ(text_of(some / "grids" / file), text_of(all / "grids" / file)) << file;
  }
}

TEST_F(Sparse, FramesAreThoseOfTheWholeRun) {
  run_well(street(folder / "all", {}));
  run_well(street(folder / "some", {"--every", "9"}));
  EXPECT_THAT(indices_of(folder / "some"), ElementsAre(0, 9, 18, 27, 36));
  EXPECT_EQ(files_in(folder / "some" / "grids").size(), 5U);
  expect_equal_frames(folder / "some", folder / "all");
  const Json run(json_of(folder / "some" / "run.json"));
  EXPECT_EQ(run["every"], 9);
  EXPECT_EQ(run["frames"]["done"], 5);
  EXPECT_EQ(run["frames"]["skipped"], 0);
  EXPECT_EQ(run["frames"]["complete"], true);
  // by the place in the input, wherever a run begins
  run_well(street(folder / "later", {"--every", "9", "--frames", "10:30"}));
  EXPECT_THAT(indices_of(folder / "later"), ElementsAre(18, 27));
  run_well(street(folder / "none", {"--every", "9", "--frames", "10:17"}));
  EXPECT_THAT(indices_of(folder / "none"), ElementsAre());
  EXPECT_THAT(run_tool({"evaluate", folder / "none"}).errors, HasSubstr("has no frames"));
}

TEST_F(Sparse, GoesOnWithItsOwnSettingsOnly) {
  run_well(street(folder / "run", {"--every", "4", "--layers", "velocity,occupancy", "--frames", ":4"}));
  const auto other = [&](const char* every, const char* layers) {
    const Outcome outcome{
        run_tool(street(folder / "run", {"--every", every, "--layers", layers, "--frames", ":8", "--resume"}))};
    EXPECT_EQ(outcome.exit_code, 64);
    return outcome.errors;
  };
  EXPECT_THAT(other("3", "occupancy,velocity"), HasSubstr("every: was 4, is 3"));
  EXPECT_THAT(other("4", "occupancy,observed"), HasSubstr("layers/0: was \"occupancy\", is \"observed\""));
  EXPECT_THAT(other("4", "occupancy"), HasSubstr("layers/1: was \"velocity\", is null"));
  run_well(street(folder / "run", {"--every", "4", "--layers", "occupancy,velocity", "--frames", ":8", "--resume"}));
  EXPECT_THAT(indices_of(folder / "run"), ElementsAre(0, 4, 8));
}

// Unreadable frames are reported whether they are written or not, also by a killed run.
TEST_F(Sparse, SkippedFramesAreAllReported) {
  const fs::path drive{folder / "drive"};
  run_well({"simulate", small_scene("street", "&frames=20"), "--out", drive, "--no-truth"});
  for (const char* name : {"000003.png", "000006.png", "000011.png", "000014.png", "000019.png"}) {
    fs::resize_file(drive / "left" / name, 0);
  }
  const auto command = [&](const fs::path& out, const char* frames) {
    return std::vector<std::string>{
        "run", drive, "--out", out, "--every", "3", "--frames", frames, "--resume", "-q", "--checkpoint-every", "4"};
  };
  run_well(command(folder / "whole", ":"));
  EXPECT_THAT(indices_of(folder / "whole"), ElementsAre(0, 9, 12, 15, 18));
  const Json whole(json_of(folder / "whole" / "run.json"));
  ASSERT_EQ(whole["skipped"].size(), 5U);
  run_well(command(folder / "parts", ":13"));
  // a killed run has recorded the frames skipped before its last checkpoint only
  Json killed(json_of(folder / "parts" / "run.json"));
  ASSERT_EQ(killed["skipped"].size(), 3U);
  std::ofstream{folder / "parts" / "run.json"} << killed;
  run_well(command(folder / "parts", ":"));
  EXPECT_EQ(json_of(folder / "parts" / "run.json")["skipped"], whole["skipped"]);
  expect_equal_runs(folder / "whole", folder / "parts");
}

TEST_F(Sparse, LayersAreThoseAskedFor) {
  run_well(street(folder / "all", {"--frames", ":2"}));
  const Outcome outcome{
      run_well(street(folder / "some", {"--frames", ":2", "--layers", "world_occupancy,age,occupancy,age_s"}))};
  EXPECT_THAT(outcome.output, AllOf(HasSubstr("  view  "), Not(HasSubstr("  evaluate  ")))) << "needs more layers";
  const Arrays all{io::read_npz(folder / "all" / "grids" / "000002.npz")};
  const Arrays some{io::read_npz(folder / "some" / "grids" / "000002.npz")};
  std::vector<std::string> names;
  for (const auto& [name, array] : some) {
    names.push_back(name);
    EXPECT_EQ(array.shape, all.at(name).shape);
    EXPECT_EQ(array.to<double>(), all.at(name).to<double>());
  }
  EXPECT_THAT(names, ElementsAre("age_s", "occupancy", "world_occupancy", "world_origin"));
  EXPECT_EQ(json_of(folder / "some" / "run.json")["layers"],
            Json::parse(R"(["occupancy", "age_s", "world_occupancy"])"));
  EXPECT_EQ(text_of(folder / "some" / "frames.jsonl").size() > 100, true);
  EXPECT_EQ(lines_of(folder / "some", false), lines_of(folder / "all", false));
}

TEST_F(Sparse, UnknownLayersAreRefusedAndThoseThereAreNamed) {
  EXPECT_THAT(errors_of(64, street(folder / "run", {"--layers", "occupancy,speed"})),
              HasSubstr("--layers speed: there is no such layer. There are: observed, elevation_m, "
                        "elevation_sigma_m, occupancy, mov"));
  EXPECT_THAT(errors_of(64, street(folder / "run", {"--layers", "world_elevation_m", "--set", "ground.model=plane"})),
              HasSubstr("--layers world_elevation_m: only with ground.model=terrain."));
  EXPECT_THAT(errors_of(64, street(folder / "run", {"--compact", "--layers", "world_occupancy"})),
              HasSubstr("no such layer in --compact. There are: observed, occupancy, moving, age_s, vel"));
  EXPECT_EQ(run_tool(street(folder / "run", {"--every", "0"})).exit_code, 64);
  EXPECT_EQ(run_tool(street(folder / "run", {"--every", "-1"})).exit_code, 64);
  EXPECT_FALSE(fs::exists(folder / "run"));
}

TEST_F(Sparse, WhatNeedsAnotherLayerSaysSo) {
  const fs::path run{folder / "run"};
  run_well(street(run, {"--frames", ":12", "--layers", "occupancy,velocity,age"}));
  const auto error_text = [&](Words words) {
    words.insert(words.begin() + 1, run.string());
    return errors_of(65, words);
  };
  const auto expected = [](const std::string& layer) {
    return HasSubstr("was written without the layer " + layer +
                     ", which is needed here; it has occupancy, age_s, velo");
  };
  EXPECT_THAT(error_text({"evaluate"}), expected("observed"));
  EXPECT_THAT(error_text({"export", "--nav2-map", folder / "map"}), expected("world_occupancy"));
  run_well({"export", run, "--laserscan", folder / "scan.csv"});
  const fs::path small{folder / "small"};
  run_well(street(small, {"--frames", ":1", "--compact"}));
  EXPECT_THAT(run_tool({"export", small, "--nav2-map", folder / "map"}).errors, HasSubstr("or without --compact"));
}

/// Permitted differences of a compact line from the exact one.
void expect_rounded(const Json& small, const Json& whole) {
  ASSERT_EQ(small.size(), whole.size());
  for (const auto& [key, value] : whole.items()) {
    if (key == "outline_m") {
      ASSERT_EQ(small[key].size(), value.size());
      for (std::size_t i{0}; i < value.size(); ++i) {
        for (const int axis : {0, 1}) {
          EXPECT_NEAR(small[key][i][axis].get<double>(), value[i][axis].get<double>(), 0.005 + 1e-9);
        }
      }
    } else if (key.ends_with("covariance")) {
      for (const int i : {0, 1, 2}) {
        const double exact{value[i]};
        EXPECT_NEAR(small[key][i].get<double>(), exact, 5.01e-4 * std::abs(exact)) << key;
      }
    } else if (value.is_number_float()) {
      EXPECT_NEAR(small[key].get<double>(), value.get<double>(), (key == "yaw_rad" ? 0.5e-4 : 0.5e-3) + 1e-9) << key;
    } else {
      EXPECT_EQ(small[key], value) << key;
    }
  }
}

TEST_F(Sparse, CompactLinesAreRounded) {
  run_well(street(folder / "whole", {}));
  run_well(street(folder / "small", {"--compact"}));
  const std::vector<Json> whole(lines_of(folder / "whole"));
  const std::vector<Json> small(lines_of(folder / "small"));
  ASSERT_EQ(small.size(), whole.size());
  std::size_t obstacles{0};
  for (std::size_t i{0}; i < whole.size(); ++i) {
    for (const char* key : {"index", "name", "stamp_ns", "pose", "ground", "mount", "status", "warnings"}) {
      EXPECT_EQ(small[i][key], whole[i][key]);
    }
    for (const char* key : {"obstacle", "road"}) {
      EXPECT_NEAR(small[i]["density"][key].get<double>(), whole[i]["density"][key].get<double>(), 0.51e-4);
    }
    ASSERT_EQ(small[i]["obstacles"].size(), whole[i]["obstacles"].size());
    for (std::size_t o{0}; o < whole[i]["obstacles"].size(); ++o) {
      expect_rounded(small[i]["obstacles"][o], whole[i]["obstacles"][o]);
      ++obstacles;
    }
  }
  EXPECT_GT(obstacles, 20U);
  EXPECT_LT(fs::file_size(folder / "small" / "frames.jsonl") * 5, fs::file_size(folder / "whole" / "frames.jsonl") * 4);
}

// Drives with many damaged frames.

/// A plain folder of empty images, but for those that `usable` frames have.
class Skipped : public ::testing::Test {
 protected:
  void make_drive(int frames, const std::vector<int>& usable) {
    run_well({"simulate", small_scene("street", "&frames=1"), "--out", folder / "one", "--no-truth"});
    fs::create_directories(drive() / "left");
    fs::create_directories(drive() / "right");
    fs::copy(folder / "one" / "calibration.yaml", drive() / "calibration.yaml");
    for (const char* side : {"left", "right"}) {
      for (int i{0}; i < frames; ++i) std::ofstream{drive() / side / file(i)};
      for (const int i : usable) {
        fs::copy(folder / "one" / side / "000000.png", drive() / side / file(i), fs::copy_options::overwrite_existing);
      }
    }
  }

  static std::string file(int index) {
    std::string number{std::to_string(index)};
    return number.insert(0, 6 - number.size(), '0') + ".png";
  }

  [[nodiscard]] fs::path drive() const { return fs::canonical(folder.path()) / "drive"; }
  [[nodiscard]] fs::path out() const { return fs::canonical(folder.path()) / "run"; }

  [[nodiscard]] Words command(const std::string& more = "--quiet") const {
    return {"run", drive(), "--poses", "none", "--out", out(), more};
  }

  const TemporaryFolder folder;
};

#ifdef STEREOGRID_FAULTS_LIBRARY
// Each of them once wrote the list of all before it.
TEST_F(Skipped, ManyDoNotWriteRunJsonAsOften) {
  make_drive(300, {0, 150});
  const fs::path report{folder / "calls"};
  const Outcome outcome{
      run_tool(command(), "LD_PRELOAD=" + quoted(STEREOGRID_FAULTS_LIBRARY) +
                              " STEREOGRID_FAULTS_UNDER=" + quoted(fs::canonical(folder.path()).string()) +
                              " STEREOGRID_FAULTS_REPORT=" + quoted(report.string()))};
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  int written{0};
  std::istringstream calls{text_of(report)};
  for (std::string call; std::getline(calls, call);) {
    if (call.starts_with("rename ") && call.ends_with("/run.json")) ++written;
  }
  EXPECT_GE(written, 3);
  EXPECT_LE(written, 12);
  const Json run(json_of(out() / "run.json"));
  EXPECT_EQ(run["frames"]["done"], 2);
  EXPECT_EQ(run["frames"]["skipped"], 298);
  ASSERT_EQ(run["skipped"].size(), 298U);
  EXPECT_EQ(run["skipped"].back()["index"], 299);
}
#endif

// A killed run has not recorded all skipped frames.
TEST_F(Skipped, AreFoundAgainWhereAKilledRunHasNotNotedThem) {
  make_drive(12, {0, 4, 5, 9});
  run_well(command());
  const Json whole(json_of(out() / "run.json"));
  ASSERT_EQ(whole["skipped"].size(), 8U);
  for (const std::vector<int>& noted : {std::vector<int>{}, std::vector<int>{1, 7}}) {
    Json killed(whole);
    killed["skipped"] = Json::array();
    for (const Json& frame : whole["skipped"]) {
      if (std::ranges::find(noted, frame["index"].get<int>()) != noted.end()) killed["skipped"].push_back(frame);
    }
    std::ofstream{out() / "run.json"} << killed;
    run_well(command("--resume"));
    EXPECT_EQ(json_of(out() / "run.json")["skipped"], whole["skipped"]);
    EXPECT_EQ(lines_of(out()).size(), 4U);
  }
}

TEST_F(Skipped, WhoseFilesHaveBeenMendedSinceAreReported) {
  make_drive(3, {0, 2});
  run_well(command());
  Json killed(json_of(out() / "run.json"));
  killed["skipped"] = Json::array();
  std::ofstream{out() / "run.json"} << killed;
  for (const char* side : {"left", "right"}) {
    fs::copy(drive() / side / file(0), drive() / side / file(1), fs::copy_options::overwrite_existing);
  }
  run_well(command("--resume"));
  const Json run(json_of(out() / "run.json"));
  ASSERT_EQ(run["skipped"].size(), 1U);
  EXPECT_EQ(run["skipped"][0]["name"], "000001");
  EXPECT_THAT(run["skipped"][0]["reason"].get<std::string>(), HasSubstr("before it had noted why"));
}

}  // namespace
}  // namespace stereogrid::app::testing

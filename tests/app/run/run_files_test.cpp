// SPDX-License-Identifier: Apache-2.0
#include <signal.h>

#include "stereogrid/io/image_file.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using Summary = FolderTest;

using Shape = std::vector<std::size_t>;

std::set<std::string> keys_of(const Json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.insert(key);
  return keys;
}

std::set<std::string> names_of(const Arrays& arrays) {
  std::set<std::string> names;
  for (const auto& [name, array] : arrays) names.insert(name);
  return names;
}

void expect_array(const Arrays& arrays, const std::string& name, io::DType dtype, const Shape& shape) {
  ASSERT_TRUE(arrays.contains(name)) << name;
  EXPECT_EQ(arrays.at(name).dtype, dtype) << name;
  EXPECT_EQ(arrays.at(name).shape, shape) << name;
}

const std::set<std::string> obstacle_keys(keys_of(Json::parse(R"({
    "id": 0, "x_m": 0, "y_m": 0, "vx_mps": 0, "vy_mps": 0, "length_m": 0, "width_m": 0, "yaw_rad": 0, "yaw_rate_radps": 0,
    "length_sigma_m": 0, "width_sigma_m": 0, "yaw_sigma_rad": 0, "height_m": 0, "occupancy": 0, "age_s": 0,
    "unseen_s": 0, "confirmed": 0, "moving": 0, "coasting": 0, "kind": 0, "outline_m": 0,
    "position_covariance": 0, "velocity_covariance": 0})")));

/// One run with everything, looked at by all tests of this file.
class RunFiles : public SharedFolderTest {
 protected:
  static void SetUpTestSuite() {
    SharedFolderTest::SetUpTestSuite();
    run_well({"run", small_scene("crossing", "&frames=3"), "--out", run(), "--save-stages", "--pictures", "--set",
              "grid.length_m=16", "--set", "matching.disparities=48"});
  }
  static fs::path run() { return folder->path() / "run"; }
};

TEST_F(RunFiles, EveryFrameHasItsFilesAndNothingElseIsLeft) {
  EXPECT_THAT(files_in(run()), ElementsAre("frames.jsonl", "grids", "pictures", "run.json", "stages"));
  EXPECT_THAT(files_in(run() / "grids"), ElementsAre("000000.npz", "000001.npz", "000002.npz"));
  EXPECT_THAT(files_in(run() / "stages"), ElementsAre("000000.npz", "000001.npz", "000002.npz"));
  EXPECT_THAT(files_in(run() / "pictures"), ElementsAre("000000.png", "000001.png", "000002.png"));
}

TEST_F(RunFiles, CompactGridsAreThoseToTheirSteps) {
  const fs::path compact{folder->path() / "compact"};
  run_well({"run", small_scene("crossing", "&frames=3"), "--out", compact, "--compact", "--set", "grid.length_m=16",
            "--set", "matching.disparities=48"});
  const fs::path file{fs::path{"grids"} / "000002.npz"};
  const Arrays whole{io::read_npz(run() / file)};
  const Arrays small{io::read_npz(compact / file)};
  EXPECT_EQ(names_of(small), (std::set<std::string>{"age_s", "moving", "observed", "occupancy", "velocity"}));
  for (const auto& [name, array] : small) {
    EXPECT_EQ(array.dtype, io::DType::float16) << name;
    EXPECT_EQ(array.shape, whole.at(name).shape) << name;
    const double step{name == "velocity" ? 1.0 / 16 : name == "age_s" ? 1.0 / 64 : 1.0 / 256};
    const std::vector<float> read{array.to<float>()};
    const std::vector<float> exact{whole.at(name).to<float>()};
    for (std::size_t c{0}; c < exact.size(); ++c) {
      if (std::isinf(exact[c])) {
        ASSERT_EQ(read[c], exact[c]) << name;
      } else {
        ASSERT_NEAR(read[c], exact[c], step / 2 + 1e-6) << name;
      }
    }
  }
  EXPECT_LT(fs::file_size(compact / file), fs::file_size(run() / file) / 10);
}

TEST_F(RunFiles, RunJsonDescribesWhatWasDone) {
  const Json json(json_of(run() / "run.json"));
  for (const char* key : {"version", "preset", "config", "input", "frames", "device", "simd_target", "timing_ms", "rig",
                          "grid", "world_grid", "skipped", "status", "warnings"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(keys_of(json["rig"]),
            (std::set<std::string>{"focal_px", "cx_px", "cy_px", "baseline_m", "width_px", "height_px",
                                   "camera_height_m", "camera_pitch_rad", "camera_roll_rad"}));
  EXPECT_EQ(json["grid"],
            Json::parse(R"({"x_min_m": 0.0, "y_min_m": -10.0, "cell_size_m": 0.2, "nx": 80, "ny": 100})"));
  EXPECT_EQ(keys_of(json["world_grid"]), (std::set<std::string>{"cell_size_m", "nx", "ny"}));
  EXPECT_EQ(json["config"]["grid"]["length_m"], 16.0);
  EXPECT_EQ(json["config"]["matching"]["disparities"], 48);
  EXPECT_EQ(json["frames"]["done"], 3);
  EXPECT_EQ(json["frames"]["complete"], true);
  for (const char* stage : {"match", "ground", "count", "project", "filter", "track", "total"}) {
    EXPECT_EQ(keys_of(json["timing_ms"][stage]), (std::set<std::string>{"p50", "p90", "p99", "mean"})) << stage;
  }
  EXPECT_GT(json["timing_ms"]["total"]["p50"], 0);
}

// A frame whose first camera has no image is processed with the others.
TEST_F(Summary, OfADriveWithTwoCameras) {
  const fs::path drive{folder / "drive"};
  const fs::path run{folder / "run"};
  run_well({"simulate", "scene:around?cameras=2&turn_deg=180&focal=96", "--frames", "4", "--width", "192", "--height",
            "120", "--no-truth", "--out", drive});
  fs::remove(drive / "camera0" / "left" / "000002.png");
  std::ofstream{drive / "camera1" / "left" / "000001.png"} << "no image";
  run_well({"run", drive, "--out", run, "--pictures", "--set", "grid.rear_m=10", "--set", "grid.length_m=10"});
  const std::vector<Json> lines(lines_of(run));
  ASSERT_EQ(lines.size(), 4U);
  for (const Json& line : lines) {
    const bool misses{line["name"] == "000002"};
    EXPECT_EQ(line["warnings"].dump().find("camera0: no usable images") != std::string::npos, misses);
    EXPECT_EQ(line["warnings"].dump().find("camera1: no usable images") != std::string::npos, line["name"] == "000001");
  }
  EXPECT_EQ(files_in(run / "pictures").size(), 4U);
  const Json about(json_of(run / "run.json"));
  EXPECT_EQ(about["camera_names"], (Json{"camera0", "camera1"}));
  ASSERT_EQ(about["other_rigs"].size(), 1U);
  EXPECT_EQ(about["other_rigs"][0]["focal_px"], about["rig"]["focal_px"]);
  EXPECT_NEAR(about["other_rigs"][0]["camera_yaw_rad"], 3.14159265, 1e-6);
  const std::string output{run_well({"info", drive, "--set", "grid.rear_m=10", "--set", "grid.length_m=10"}).output};
  EXPECT_THAT(output, HasSubstr("camera0: 4 of 4 frames, 3 can be used"));
  EXPECT_THAT(output, HasSubstr("camera1: 4 of 4 frames, 3 can be used"));
  EXPECT_THAT(output, HasSubstr("1 of 4 frames lack a camera's images. frame 000001: camera1: no usable images"));
  EXPECT_THAT(output, HasSubstr("camera0: frame 000002: no usable images"));
}

// Two cameras, of which the second one's images are unrelated.
TEST_F(Summary, FindsTheFaultOfASecondCamera) {
  const fs::path drive{folder / "drive"};
  run_well({"simulate", "scene:around?cameras=2&turn_deg=180&focal=96", "--frames", "3", "--width", "192", "--height",
            "120", "--no-truth", "--out", drive});
  fs::remove_all(drive / "camera1" / "right");
  fs::copy(drive / "camera0" / "left", drive / "camera1" / "right");
  const std::vector<std::string> grid{"--set", "grid.rear_m=10", "--set", "grid.length_m=10"};
  const std::string output{run_well({"info", drive, grid[0], grid[1], grid[2], grid[3]}).output};
  EXPECT_THAT(output, ::testing::ContainsRegex("problem +camera1: in 3 of 3 frames left and right image hardly match"));
  EXPECT_THAT(output, Not(::testing::ContainsRegex("problem +camera0")));
  EXPECT_THAT(output, HasSubstr("camera1: cannot be used"));
  EXPECT_THAT(output, ::testing::ContainsRegex("verdict +usable"));
  const std::string errors{
      run_well({"run", drive, "--out", folder / "run", grid[0], grid[1], grid[2], grid[3]}).errors};
  EXPECT_THAT(errors, HasSubstr("camera1: "));
}

TEST_F(RunFiles, EveryLineHasEveryKey) {
  const std::vector<Json> lines(lines_of(run()));
  ASSERT_EQ(lines.size(), 3U);
  for (std::size_t i{0}; i < 3; ++i) {
    const Json& line{lines[i]};
    EXPECT_EQ(keys_of(line), (std::set<std::string>{"index", "name", "stamp_ns", "pose", "ground", "mount", "timing_ms",
                                                    "density", "speed_limit", "obstacles", "status", "warnings"}));
    EXPECT_EQ(line["status"], Json::array());
    EXPECT_EQ(line["index"], i);
    EXPECT_EQ(line["name"], "00000" + std::to_string(i));
    EXPECT_EQ(line["stamp_ns"], i * 100'000'000);
    EXPECT_EQ(keys_of(line["pose"]), (std::set<std::string>{"x_m", "y_m", "yaw_rad"}));
    EXPECT_EQ(keys_of(line["ground"]), (std::set<std::string>{"height_m", "pitch_rad", "roll_rad", "estimated",
                                                              "height_sigma_m", "pitch_sigma_rad", "roll_sigma_rad"}));
    EXPECT_GT(line["ground"]["pitch_sigma_rad"], 0);
    EXPECT_EQ(keys_of(line["density"]), (std::set<std::string>{"obstacle", "road"}));
    EXPECT_GT(line["density"]["road"], 0.05);
    for (Json obstacle : line["obstacles"]) {
      EXPECT_EQ(keys_of(obstacle), obstacle_keys);
      EXPECT_EQ(obstacle["position_covariance"].size(), 3U);
      EXPECT_GT(obstacle["velocity_covariance"][0].get<double>(), 0);
      for (const char* may_be_unknown : {"length_sigma_m", "width_sigma_m", "yaw_sigma_rad"})
        obstacle.erase(may_be_unknown);
      EXPECT_EQ(obstacle.dump().find("null"), std::string::npos);
    }
    Json rest(line);
    rest.erase("obstacles");
    EXPECT_EQ(rest.dump().find("null"), std::string::npos);
  }
}

TEST_F(RunFiles, PredictionsHaveTheirShapes) {
  const TemporaryFolder elsewhere;
  const fs::path out{elsewhere.path() / "run"};
  run_well({"run", small_scene("crossing", "&frames=2"), "--out", out, "--predict", "0.5,2", "--set",
            "matching.disparities=48"});
  EXPECT_EQ(json_of(out / "run.json")["predict_s"], Json::parse("[0.5, 2.0]"));
  const Arrays arrays{io::read_npz(out / "predictions" / "000001.npz")};
  EXPECT_EQ(names_of(arrays), (std::set<std::string>{"horizon_s", "occupancy", "world_occupancy", "world_origin"}));
  expect_array(arrays, "horizon_s", io::DType::float64, {2});
  expect_array(arrays, "occupancy", io::DType::float32, {2, 100, 100});
  expect_array(arrays, "world_origin", io::DType::float64, {2});
  EXPECT_EQ(run_tool({"run", small_scene("crossing", "&frames=2"), "--out", out, "--predict", "0"}).exit_code, 64);
}

TEST_F(RunFiles, GridsHaveTheirShapes) {
  const Json json(json_of(run() / "run.json"));
  const auto world{json["world_grid"]["nx"].get<std::size_t>()};
  ASSERT_EQ(json["world_grid"]["ny"], world);
  const Arrays arrays{io::read_npz(run() / "grids" / "000002.npz")};
  EXPECT_EQ(names_of(arrays),
            (std::set<std::string>{"observed", "elevation_m", "elevation_sigma_m", "terrain", "witness", "occupancy",
                                   "moving", "age_s", "velocity", "velocity_covariance", "world_occupancy",
                                   "world_moving", "world_velocity", "world_velocity_covariance", "world_age_s",
                                   "world_elevation_m", "world_elevation_sigma_m", "world_terrain", "world_origin"}));
  for (const char* name : {"observed", "occupancy", "age_s", "moving"}) {
    expect_array(arrays, name, io::DType::float32, {100, 80});
  }
  for (const char* name : {"world_occupancy", "world_elevation_m", "world_age_s", "world_moving"}) {
    expect_array(arrays, name, io::DType::float32, {world, world});
  }
  expect_array(arrays, "velocity", io::DType::float32, {2, 100, 80});
  expect_array(arrays, "velocity_covariance", io::DType::float32, {3, 100, 80});
  expect_array(arrays, "world_terrain", io::DType::uint8, {world, world});
  expect_array(arrays, "world_velocity", io::DType::float32, {2, world, world});
  expect_array(arrays, "world_velocity_covariance", io::DType::float32, {3, world, world});
  expect_array(arrays, "world_origin", io::DType::float64, {2});
  const auto age{arrays.at("age_s").to<float>()};
  EXPECT_TRUE(std::any_of(age.begin(), age.end(), [](float a) { return std::isinf(a); }));
  EXPECT_TRUE(std::any_of(age.begin(), age.end(), [](float a) { return a == 0; }));
}

// The window lies around the vehicle, which stands at the world's origin: the cell 5 m ahead is in both grids.
TEST_F(RunFiles, WorldOriginIsTheCornerOfTheFirstCell) {
  const Json json(json_of(run() / "run.json"));
  const Arrays arrays{io::read_npz(run() / "grids" / "000002.npz")};
  const auto origin{arrays.at("world_origin").to<double>()};
  const double cell{json["world_grid"]["cell_size_m"].get<double>()};
  const Image<float> world{arrays.at("world_occupancy").to_image<float>()};
  const Image<float> vehicle{arrays.at("occupancy").to_image<float>()};
  const int x{static_cast<int>(std::floor((5.05 - origin[0]) / cell))};
  const int y{static_cast<int>(std::floor((0.05 - origin[1]) / cell))};
  ASSERT_LT(x, world.width());
  ASSERT_LT(y, world.height());
  EXPECT_LT(world(x, y), 0.3F);
  EXPECT_NEAR(world(x, y), vehicle(25, 50), 0.02F);
}

TEST_F(RunFiles, StagesHaveTheirShapes) {
  const Arrays arrays{io::read_npz(run() / "stages" / "000001.npz")};
  EXPECT_EQ(arrays.size(), 12U);
  expect_array(arrays, "obstacle_disparity", io::DType::float32, {100, 160});
  expect_array(arrays, "road_disparity", io::DType::float32, {100, 160});
  expect_array(arrays, "match_confidence", io::DType::float32, {100, 160});
  expect_array(arrays, "ambiguous", io::DType::uint8, {100, 160});
  expect_array(arrays, "possible", io::DType::int32, {48});
  expect_array(arrays, "visible", io::DType::uint16, {48, 160});
  expect_array(arrays, "observed_pixels", io::DType::uint16, {48, 160});
  for (const char* name :
       {"visibility", "obstacle_confidence", "road_confidence", "u_occupancy", "u_occupancy_smooth"}) {
    expect_array(arrays, name, io::DType::float32, {48, 160});
  }
}

TEST_F(RunFiles, PicturesHaveOneSizeAndShowSomething) {
  const io::RgbImage first{io::read_rgb(run() / "pictures" / "000000.png")};
  const io::RgbImage last{io::read_rgb(run() / "pictures" / "000002.png")};
  EXPECT_EQ(first.width, last.width);
  EXPECT_EQ(first.height, last.height);
  EXPECT_GT(first.width, 800);
  EXPECT_LT(first.width, 3000);
  EXPECT_GT(first.height, 500);
  int blue{0};  // the road's tint
  for (const auto [u, v] : raster(last.width, last.height)) {
    const std::uint8_t* rgb{last.pixels.row(v) + 3 * u};
    if (rgb[2] > rgb[0] + 60) ++blue;
  }
  EXPECT_GT(blue, 20000);
}

TEST(Run, GivesTheSameOnOneAndTwoThreads) {
  const TemporaryFolder folder;
  for (const char* threads : {"1", "2"}) {
    run_well(
        {"run", small_scene("street", "&frames=3"), "--out", folder / threads, "--threads", threads, "--save-stages"});
  }
  expect_equal_runs(folder / "1", folder / "2");
}

TEST(Run, FramesAreBothInclusive) {
  const TemporaryFolder folder;
  run_well({"run", small_scene("empty", "&frames=5"), "--out", folder / "middle", "--frames", "1:3"});
  EXPECT_THAT(files_in(folder / "middle" / "grids"), ElementsAre("000001.npz", "000002.npz", "000003.npz"));
  run_well({"run", small_scene("empty", "&frames=5"), "--out", folder / "end", "--frames", "3:"});
  EXPECT_THAT(files_in(folder / "end" / "grids"), ElementsAre("000003.npz", "000004.npz"));
}

TEST(Run, MakesAVideo) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not here";
  const TemporaryFolder folder;
  run_well(
      {"run", small_scene("empty", "&frames=3"), "--out", folder / "run", "--video", folder / "film" / "street.mp4"});
  EXPECT_THAT(files_in(folder / "film"), ElementsAre("street.mp4"));
  const std::string film{text_of(folder / "film" / "street.mp4")};
  EXPECT_GT(film.size(), 3000U);
  EXPECT_EQ(film.substr(4, 4), "ftyp");
  EXPECT_FALSE(fs::exists(folder / "run" / "pictures"));
}

TEST(Run, MakesAnAnimatedImage) {
  if (std::system("ffmpeg -encoders 2>/dev/null | grep -q libwebp_anim") != 0) GTEST_SKIP() << "no ffmpeg with WebP";
  const TemporaryFolder folder;
  for (const char* name : {"street.gif", "street.WEBP"}) {
    run_well(
        {"run", small_scene("empty", "&frames=3"), "--out", folder / name / "run", "--video", folder / name / name});
  }
  EXPECT_EQ(text_of(folder / "street.gif" / "street.gif").substr(0, 6), "GIF89a");
  const std::string webp{text_of(folder / "street.WEBP" / "street.WEBP")};
  EXPECT_EQ(webp.substr(8, 4), "WEBP");
  EXPECT_NE(webp.find("ANMF"), std::string::npos) << "several frames";
}

TEST_F(Summary, NamesTimesAndTheCommandsThatFollow) {
  const std::string out{folder / "my run"};
  const std::string output{
      run_well({"run", small_scene("street", "&frames=2"), "--out", out, "--pictures", "--mcap"}).output};
  for (const std::string& part :
       {std::string{"2 frames, "}, std::string{"frames per second"}, std::string{"seconds: pipeline "},
        std::string{", writing "}, std::string{", total "}, "results in " + out, out + "/pictures", out + "/run.mcap",
        "stereogrid view '" + out + "'", "stereogrid evaluate '" + out + "'  (exact truth)"}) {
    EXPECT_THAT(output, HasSubstr(part));
  }
  EXPECT_THAT(output, Not(HasSubstr("--resume")));
  EXPECT_GT(fs::file_size(fs::path{out} / "run.mcap"), 10'000U);
}

TEST_F(Summary, OfAStoppedRunSaysHowToContinue) {
  const fs::path out{folder / "run"};
  Process process{"sh",
                  {"-c", "exec " + quoted(STEREOGRID_TOOL) + " run " + quoted(small_scene("street", "&frames=400")) +
                             " --out " + quoted(out.string()) + " >" + quoted((folder / "output").string())}};
  wait_for_frames(out, 2);
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 130);
  const std::string output{text_of(folder / "output")};
  EXPECT_THAT(output, ::testing::ContainsRegex("^stopped after [0-9]+ of 400 frames"));
  EXPECT_THAT(output, HasSubstr("continue   the same command with --resume"));
}

}  // namespace
}  // namespace stereogrid::app::testing

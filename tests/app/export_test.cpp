// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Exports equal the content of the run's folder. Maps are loaded by the rules of Nav2's map_server
// (nav2_map_server/src/map_io.cpp).
#include <cmath>
#include <fstream>
#include <sstream>

#include "stereogrid/frame.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using messages::sensor_msgs::LaserScan;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Row = std::map<std::string, std::string>;

/// Splits fields without quotation marks.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream text{line + ","};
  for (std::string field; std::getline(text, field, ',');) fields.push_back(field);
  return fields;
}

std::vector<Row> rows_of(const fs::path& csv) {
  std::ifstream file{csv};
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> names{fields_of(line)};
  std::vector<Row> rows;
  while (std::getline(file, line)) {
    const std::vector<std::string> fields{fields_of(line)};
    EXPECT_EQ(fields.size(), names.size()) << line;
    Row row;
    for (std::size_t i{0}; i < std::min(fields.size(), names.size()); ++i) row[names[i]] = fields[i];
    rows.push_back(row);
  }
  return rows;
}

double number(const Row& row, const std::string& name) {
  return std::stod(row.at(name));
}

/// A map as map_server has it: 100, 0 or −1 of each cell, from the corner of the smallest x and y.
struct LoadedMap {
  std::map<std::string, std::string> keys;
  std::vector<std::int8_t> data;
};

LoadedMap loaded(const fs::path& yaml) {
  LoadedMap map;
  std::ifstream file{yaml};
  for (std::string line; std::getline(file, line);) {
    map.keys[line.substr(0, line.find(": "))] = line.substr(line.find(": ") + 2);
  }
  EXPECT_EQ(map.keys["mode"], "trinary");
  EXPECT_EQ(map.keys["negate"], "0");
  const std::string image_name{map.keys["image"].substr(1, map.keys["image"].size() - 2)};
  const Image<std::uint8_t> image{io::read_grey(yaml.parent_path() / image_name)};
  for (int y{image.height() - 1}; y >= 0; --y) {
    for (int x{0}; x < image.width(); ++x) {
      const double occupied{(255 - image(x, y)) / 255.0};
      const bool is_free{occupied < std::stod(map.keys["free_thresh"])};
      map.data.push_back(occupied > std::stod(map.keys["occupied_thresh"]) ? 100 : is_free ? 0 : -1);
    }
  }
  return map;
}

/// One run, exported by all tests of this file.
class Export : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = std::make_unique<TemporaryFolder>();
    run_well({"run", small_scene("crossing", "&frames=8"), "--out", run().string(), "--frames", "2:6", "--mcap",
              (*folder / "scan.mcap").string(), "--mcap-topics", "scan"});
  }
  static void TearDownTestSuite() { folder.reset(); }
  static fs::path run() { return folder->path() / "run"; }
  static Arrays grids(int index) { return io::read_npz(run() / "grids" / ("00000" + std::to_string(index) + ".npz")); }
  /// The words of a command that writes into the tests' folder.
  static std::vector<std::string> words(std::vector<std::string> options) {
    options.insert(options.begin(), {"export", run().string()});
    return options;
  }
  static std::string at(const std::string& name) { return (*folder / name).string(); }

  static std::unique_ptr<TemporaryFolder> folder;
};
std::unique_ptr<TemporaryFolder> Export::folder;

TEST_F(Export, AMapIsLoadedAsTheGridWas) {
  run_well(words({"--nav2-map", at("maps/last")}));
  run_well(words({"--nav2-map", at("maps/third"), "--frame", "3"}));
  EXPECT_THAT(files_in(at("maps/last")), ElementsAre("map.pgm", "map.yaml"));
  for (const auto& [name, index] : {std::pair{"last", 6}, std::pair{"third", 3}}) {
    const LoadedMap map{loaded(*folder / "maps" / name / "map.yaml")};
    const Image<float> cells{grids(index).at("world_occupancy").to_image<float>()};
    EXPECT_EQ(map.data, occupancy_values(cells.view(), OccupancyScale::trinary));
    for (const int value : {100, 0, -1}) EXPECT_THAT(map.data, ::testing::Contains(value));
    const auto origin{grids(index).at("world_origin").to<double>()};
    std::istringstream corner{map.keys.at("origin").substr(1)};
    double x{0};
    double y{0};
    char comma{' '};
    corner >> x >> comma >> y;
    EXPECT_EQ(x, origin[0]);
    EXPECT_EQ(y, origin[1]);
    EXPECT_EQ(std::stod(map.keys.at("resolution")), json_of(run() / "run.json")["world_grid"]["cell_size_m"]);
  }
}

TEST_F(Export, ScansAreThoseOfTheRecording) {
  run_well(words({"--laserscan", at("new/scan.csv")}));
  const std::vector<Row> rows{rows_of(at("new/scan.csv"))};
  const auto bag{mcap::open_bag(at("scan.mcap"))};
  const auto cursor{bag->messages({.topics = {"/stereo_grid/scan"}})};
  ASSERT_EQ(rows.size(), 5U);
  for (const Row& row : rows) {
    const mcap::Message* const one{cursor->next()};
    ASSERT_NE(one, nullptr);
    LaserScan scan;
    messages::decode(one->data, scan);
    EXPECT_EQ(row.at("stamp_ns"), std::to_string(one->log_time_ns));
    EXPECT_EQ(std::stof(row.at("angle_min")), scan.angle_min);
    EXPECT_EQ(std::stof(row.at("angle_max")), scan.angle_max);
    EXPECT_EQ(std::stof(row.at("angle_increment")), scan.angle_increment);
    EXPECT_EQ(std::stof(row.at("range_min")), scan.range_min);
    EXPECT_EQ(std::stof(row.at("range_max")), scan.range_max);
    ASSERT_EQ(row.size(), 6 + scan.ranges.size());
    for (std::size_t i{0}; i < scan.ranges.size(); ++i) {
      const float range{std::stof(row.at("range_" + std::to_string(i)))};
      EXPECT_TRUE(range == scan.ranges[i] || (std::isnan(range) && std::isnan(scan.ranges[i]))) << i;
    }
  }
}

TEST_F(Export, FramesAndObstaclesAreThoseOfTheLines) {
  run_well(words({"--csv", at("csv")}));
  const std::vector<Json> lines(lines_of(run()));
  const std::vector<Row> frames{rows_of(*folder / "csv" / "frames.csv")};
  const std::vector<Row> obstacles{rows_of(*folder / "csv" / "obstacles.csv")};
  EXPECT_THAT(
      text_of(*folder / "csv" / "obstacles.csv"),
      StartsWith("index,name,stamp_ns,id,kind,x_m,y_m,world_x_m,world_y_m,vx_mps,vy_mps,length_m,width_m,height_m,"
                 "yaw_rad,yaw_rate_radps,length_sigma_m,width_sigma_m,yaw_sigma_rad,age_s,unseen_s,occupancy,"
                 "confirmed,moving,coasting,position_xx_m2,position_xy_m2,position_yy_m2,velocity_xx_m2ps2,"
                 "velocity_xy_m2ps2,velocity_yy_m2ps2\n"));
  ASSERT_EQ(frames.size(), lines.size());
  auto obstacle{obstacles.begin()};
  for (std::size_t i{0}; i < lines.size(); ++i) {
    const Json& line{lines[i]};
    EXPECT_EQ(frames[i].at("index"), std::to_string(i + 2));
    EXPECT_EQ(frames[i].at("name"), line["name"]);
    EXPECT_EQ(frames[i].at("stamp_ns"), std::to_string(line["stamp_ns"].get<std::int64_t>()));
    EXPECT_EQ(number(frames[i], "x_m"), line["pose"]["x_m"]);
    EXPECT_EQ(number(frames[i], "total_ms"), line["timing_ms"]["total"]);
    EXPECT_EQ(number(frames[i], "obstacles"), static_cast<double>(line["obstacles"].size()));
    for (const Json& told : line["obstacles"]) {
      ASSERT_NE(obstacle, obstacles.end());
      EXPECT_EQ(obstacle->at("index"), frames[i].at("index"));
      for (const char* key : {"id", "x_m", "y_m", "vx_mps", "vy_mps", "length_m", "width_m", "height_m", "yaw_rad",
                              "age_s", "unseen_s", "occupancy"}) {
        EXPECT_EQ(number(*obstacle, key), told[key]) << key;
      }
      EXPECT_EQ(obstacle->at("kind"), told["kind"]);
      EXPECT_EQ(obstacle->at("confirmed") == "1", told["confirmed"]);
      EXPECT_EQ(number(*obstacle, "velocity_xx_m2ps2"), told["velocity_covariance"][0]);
      const Pose2 pose{line["pose"]["x_m"], line["pose"]["y_m"], line["pose"]["yaw_rad"]};
      EXPECT_EQ(number(*obstacle, "world_y_m"), (pose * Point2{told["x_m"], told["y_m"]}).y);
      ++obstacle;
    }
  }
  EXPECT_EQ(obstacle, obstacles.end());
  EXPECT_FALSE(obstacles.empty());
}

TEST_F(Export, TheCellsAreThoseOfTheChosenFrame) {
  run_well(words({"--csv", at("cells"), "--frame", "4", "--nav2-map", at("cells")}));
  const std::vector<Row> rows{rows_of(*folder / "cells" / "grid.csv")};
  const Image<float> occupancy{grids(4).at("occupancy").to_image<float>()};
  ASSERT_EQ(rows.size(), occupancy.size());
  const Json grid(json_of(run() / "run.json")["grid"]);
  for (std::size_t i{0}; i < rows.size(); i += 97) {
    const int ix{std::stoi(rows[i].at("ix"))};
    const int iy{std::stoi(rows[i].at("iy"))};
    EXPECT_EQ(std::stof(rows[i].at("occupancy")), occupancy(ix, iy));
    EXPECT_NEAR(number(rows[i], "y_m"), grid["y_min_m"].get<double>() + (iy + 0.5) * grid["cell_size_m"].get<double>(),
                1e-4);
  }
  EXPECT_TRUE(fs::exists(*folder / "cells" / "map.yaml"));
}

TEST_F(Export, QuotesNamesThatHoldCommas) {
  const fs::path odd{*folder / "odd"};
  fs::copy(run(), odd, fs::copy_options::recursive);
  std::string lines{text_of(odd / "frames.jsonl")};
  const std::string name{"\"name\":\"000002\""};
  lines.replace(lines.find(name), name.size(), "\"name\":\"a,\\\"b\"");
  std::ofstream{odd / "frames.jsonl"} << lines;
  run_well({"export", odd.string(), "--csv", at("odd_csv")});
  EXPECT_THAT(text_of(*folder / "odd_csv" / "frames.csv"), HasSubstr("\n2,\"a,\"\"b\",200000000,"));
}

struct Refused {
  std::vector<std::string> words;
  int exit_code;
  std::string said;
};

TEST_F(Export, RefusesWhatCannotBe) {
  std::ofstream{*folder / "mine.csv"} << "mine";
  fs::create_directories(*folder / "there");
  std::ofstream{*folder / "there" / "map.pgm"} << "mine";
  const std::vector<Refused> all{
      {words({}), 64, "one or more of --nav2-map DIR, --laserscan FILE.csv and --csv DIR"},
      {words({"--frame", "3", "--laserscan", at("never")}), 64, "--frame chooses the grid of"},
      {words({"--frame", "7", "--csv", at("never")}), 64, "Its frames are 2 to 6."},
      {words({"--frame", "-1", "--csv", at("never")}), 64, "-1 is no whole number"},
      {words({"--laserscan", at("mine.csv"), "--csv", at("never")}), 64, "mine.csv is there already"},
      {words({"--nav2-map", at("there")}), 64, "map.pgm is there already"},
      {{"export", folder->path().string(), "--csv", at("never")}, 65, "run.json"}};
  for (const Refused& refused : all) {
    const Outcome outcome{run_tool(refused.words)};
    EXPECT_EQ(outcome.exit_code, refused.exit_code) << outcome.errors;
    EXPECT_THAT(outcome.errors, HasSubstr(refused.said));
  }
  EXPECT_EQ(text_of(*folder / "mine.csv"), "mine");
  EXPECT_FALSE(fs::exists(*folder / "never"));
}

TEST_F(Export, WritesNothingWhereAGridIsDamaged) {
  const fs::path damaged{*folder / "damaged"};
  fs::copy(run(), damaged, fs::copy_options::recursive);
  std::ofstream{damaged / "grids" / "000006.npz"} << "no grid";
  for (const char* option : {"--laserscan", "--nav2-map", "--csv"}) {
    EXPECT_THAT(errors_of(65, {"export", damaged.string(), option, at("none")}), HasSubstr("000006.npz"));
    EXPECT_FALSE(fs::exists(*folder / "none"));
  }
}

}  // namespace
}  // namespace stereogrid::app::testing

// SPDX-License-Identifier: Apache-2.0
//
// Exports equal the content of the run's folder. Maps are loaded by the rules of Nav2's map_server
// (nav2_map_server/src/map_io.cpp).
#include <fstream>

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
class Export : public SharedFolderTest {
 protected:
  static void SetUpTestSuite() {
    SharedFolderTest::SetUpTestSuite();
    run_well({"run", small_scene("crossing", "&frames=8"), "--out", run(), "--frames", "2:6", "--mcap",
              *folder / "scan.mcap", "--mcap-topics", "scan"});
  }
  static fs::path run() { return folder->path() / "run"; }
  static Arrays grids(int index) { return io::read_npz(run() / "grids" / ("00000" + std::to_string(index) + ".npz")); }
  /// The words of a command that writes into the tests' folder.
  static Words words(const Words& options) { return joined({"export", run()}, options); }
  static std::string at(const std::string& name) { return (*folder / name).string(); }
};

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

TEST_F(Export, APageShowsRunsBesideThisOne) {
  run_well(words({"--web", at("page"), "--beside", run()}));
  const std::string page{text_of(*folder / "page" / "index.html")};
  EXPECT_THAT(page, HasSubstr(R"("name":"run, run_2")"));
  for (const char* topic : {"/run/stereo_grid/scan", "/run_2/stereo_grid/scan"}) EXPECT_THAT(page, HasSubstr(topic));
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

TEST_F(Export, RefusesWhatCannotBe) {
  std::ofstream{*folder / "mine.csv"} << "mine";
  fs::create_directories(*folder / "there");
  for (const char* name : {"map.pgm", "index.html"}) std::ofstream{*folder / "there" / name} << "mine";
  for (const Refused& refused : std::vector<Refused>{
           {words({}), "Give --web DIR, --nav2-map DIR or --laserscan FILE.csv"},
           {words({"--frame", "3", "--laserscan", at("never")}), "--frame chooses the grid of"},
           {words({"--frame", "7", "--nav2-map", at("never"), "--web", at("never")}), "Its frames are 2 to 6."},
           {words({"--frame", "-1", "--nav2-map", at("never")}), "-1 is not a whole number"},
           {words({"--laserscan", at("mine.csv"), "--nav2-map", at("never")}), "mine.csv is there already"},
           {words({"--nav2-map", at("there")}), "map.pgm is there already"},
           {words({"--web", at("there")}), "index.html is there already"},
           {{"export", folder->path(), "--laserscan", at("never")}, "is not a run. Give the folder", 65}}) {
    expect_refused(refused);
  }
  EXPECT_EQ(text_of(*folder / "mine.csv"), "mine");
  EXPECT_FALSE(fs::exists(*folder / "never"));
}

TEST_F(Export, WritesNothingWhereAGridIsDamaged) {
  const fs::path damaged{*folder / "damaged"};
  fs::copy(run(), damaged, fs::copy_options::recursive);
  std::ofstream{damaged / "grids" / "000006.npz"} << "no grid";
  for (const char* option : {"--laserscan", "--nav2-map", "--web"}) {
    EXPECT_THAT(errors_of(65, {"export", damaged, option, at("none")}), HasSubstr("000006.npz"));
    EXPECT_FALSE(fs::exists(*folder / "none"));
  }
}

// Output of nav2-params; tests/messages/planners_test.cpp applies Nav2's rules to it.

TEST(Nav2Params, AreThoseOfTheRunOrOfItsCalibration) {
  const TemporaryFolder folder;
  const Words settings{"--preset", "robot", "--set", "grid.length_m=4"};
  run_well(joined({"run", small_scene("corridor", "&frames=2"), "--out", folder / "run", "--predict", "1"}, settings));
  const std::string of_run{run_well({"nav2-params", folder / "run"}).output};
  EXPECT_THAT(of_run, AllOf(HasSubstr("map_topic: /stereo_grid/planning_grid\n"), HasSubstr(" width: 10\n")))
      << "4 m ahead and 3 m aside are 5 m away";
  run_well({"simulate", small_scene("corridor", "&frames=1"), "--out", folder / "drive"});
  const Words rig{joined({"nav2-params", folder / "drive" / "calibration.yaml", "--predict", "1"}, settings)};
  EXPECT_EQ(run_well(rig).output, of_run);
  EXPECT_THAT(run_well(joined(rig, {"--source", "scan", "--ros2-node", "a/b", "--frames", "map,base"})).output,
              AllOf(HasSubstr(" topic: /a/b/scan\n"), HasSubstr(" global_frame: map\n"),
                    HasSubstr(" robot_base_frame: base\n")));
}

TEST(Nav2Params, OfARunTakeNoSettings) {
  const TemporaryFolder folder;
  run_well({"run", small_scene("corridor", "&frames=1"), "--out", folder / "run"});
  EXPECT_THAT(run_well({"nav2-params", folder / "run"}).output, HasSubstr("/stereo_grid/occupancy_grid\n"));
  EXPECT_THAT(run_well({"nav2-params", folder / "run", "--source", "layer"}).output,
              AllOf(HasSubstr(" plugin: stereogrid_nav2::GridLayer\n"), Not(HasSubstr("prediction_topic"))));
  for (const auto& setting : {std::array{"--preset", "robot"}, {"--set", "grid.length_m=4"}, {"--predict", "1"}}) {
    EXPECT_THAT(errors_of(64, {"nav2-params", folder / "run", setting[0], setting[1]}),
                HasSubstr("A run has its own settings"));
  }
  EXPECT_THAT(errors_of(65, {"nav2-params", folder / "none.yaml"}), HasSubstr("none.yaml"));
  EXPECT_THAT(errors_of(65, {"nav2-params", folder / "run" / "grids"}),
              HasSubstr("grids: is not a run. Give its calibration file"));
  std::ofstream{folder / "P.txt"} << "P0: 100 0 80 0 0 100 50 0 0 0 1 0\nP1: 100 0 80 -20 0 100 50 0 0 0 1 0\n";
  EXPECT_THAT(errors_of(65, {"nav2-params", folder / "P.txt"}),
              HasSubstr("P.txt: does not have the size of the images."));
}

}  // namespace
}  // namespace stereogrid::app::testing

// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/truth.hpp"

#include <nlohmann/json.hpp>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/recording.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

constexpr int width_px{37};
constexpr int height_px{21};
const TruthGrid grid{{0, -1, 0.5, 6, 4}, 0.15, 1.8};
const Rig rig{width_px, height_px, 30, 18, 10, 0.2, 1.3, 0.05, 0};

/// Every value of its own, so that exchanged arrays are noticed.
FrameTruth made_up_truth(const std::string& name, int big) {
  FrameTruth truth;
  truth.name = name;
  truth.stamp_ns = 100'000'000;
  truth.ego = {{1.5, -2.25, 0.125}, 8, 0.5, 0.0625};
  truth.objects.push_back({big, "car", {5, 1, -0.5}, 1.25, -2, 1.5, {1.75, 4.25, 1.5}, {{4, 0}, {6, 0}, {6, 2}}, 99});
  truth.disparity = Image<float>{width_px, height_px, 12.5F};
  truth.disparity(0, 0) = 0;
  truth.label = Image<std::uint8_t>{width_px, height_px, 2};
  truth.instance = Image<std::uint16_t>{width_px, height_px, static_cast<std::uint16_t>(big)};
  truth.seen_by_both = Image<std::uint8_t>{width_px, height_px, 255};
  truth.state = Image<std::uint8_t>{6, 4, 1};
  truth.occupied = Image<std::uint8_t>{6, 4, 0};
  truth.occupied(5, 0) = 1;
  truth.owner = Image<std::int32_t>{6, 4, big};
  truth.pixels = Image<std::int32_t>{6, 4, 77};
  truth.seen_object = Image<std::int32_t>{6, 4, 3};
  truth.free_points = Image<std::uint8_t>{6, 4, 9};
  truth.low = Image<std::uint8_t>{6, 4, 0};
  truth.low(0, 3) = 1;
  truth.velocity_x = Image<float>{6, 4, 1.25F};
  truth.velocity_y = Image<float>{6, 4, -2};
  return truth;
}

StereoFrame frame_of(const FrameTruth& truth) {
  StereoFrame frame;
  frame.name = truth.name;
  frame.stamp_ns = truth.stamp_ns;
  frame.left = Image<std::uint8_t>{width_px, height_px, 50};
  frame.right = Image<std::uint8_t>{width_px, height_px, 60};
  frame.world_from_vehicle = truth.ego.world_from_vehicle;
  return frame;
}

void expect_equal(const FrameTruth& a, const FrameTruth& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.stamp_ns, b.stamp_ns);
  EXPECT_EQ(a.ego.world_from_vehicle, b.ego.world_from_vehicle);
  EXPECT_EQ(a.ego.yaw_rate_radps, b.ego.yaw_rate_radps);
  EXPECT_EQ(a.ego.vx_mps, b.ego.vx_mps);
  EXPECT_EQ(a.ego.vy_mps, b.ego.vy_mps);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (std::size_t i{0}; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].id, b.objects[i].id);
    EXPECT_EQ(a.objects[i].kind, b.objects[i].kind);
    EXPECT_EQ(a.objects[i].world_from_object, b.objects[i].world_from_object);
    EXPECT_EQ(a.objects[i].vx_mps, b.objects[i].vx_mps);
    EXPECT_EQ(a.objects[i].height_m, b.objects[i].height_m);
    EXPECT_EQ(a.objects[i].size_m[1], b.objects[i].size_m[1]);
    EXPECT_EQ(a.objects[i].footprint.size(), b.objects[i].footprint.size());
    EXPECT_EQ(a.objects[i].pixels, b.objects[i].pixels);
  }
  EXPECT_EQ(a.disparity, b.disparity);
  EXPECT_EQ(a.label, b.label);
  EXPECT_EQ(a.instance, b.instance);
  EXPECT_EQ(a.seen_by_both, b.seen_by_both);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.occupied, b.occupied);
  EXPECT_EQ(a.owner, b.owner);
  EXPECT_EQ(a.pixels, b.pixels);
  EXPECT_EQ(a.seen_object, b.seen_object);
  EXPECT_EQ(a.free_points, b.free_points);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.velocity_x, b.velocity_x);
  EXPECT_EQ(a.velocity_y, b.velocity_y);
  EXPECT_EQ(a.terrain, b.terrain);
  EXPECT_EQ(a.elevation_m, b.elevation_m);
  EXPECT_EQ(a.step_m, b.step_m);
}

struct PlainFolder : FolderTest {
  void write(const FrameTruth& truth) {
    PlainFolderWriter writer{folder / "out", rig, grid};
    writer.write(frame_of(truth), &truth);
    writer.finish();
  }
};

TEST_F(PlainFolder, ZonesRoundTrip) {
  TruthGrid course{grid};
  course.zones = {{"edge", true, {1.5, -2}, {3, 0.25}}, {"hump", false, {4, 1}, {5, 2}}};
  PlainFolderWriter writer{folder / "out", rig, course};
  writer.finish();
  const std::vector<TruthZone> zones{TruthReader{folder / "out" / "truth"}.grid().zones};
  ASSERT_EQ(zones.size(), 2U);
  EXPECT_EQ(zones[0].kind, "edge");
  EXPECT_TRUE(zones[0].is_hazard);
  EXPECT_EQ(zones[0].low.y, -2);
  EXPECT_EQ(zones[0].high.y, 0.25);
  EXPECT_EQ(zones[1].high.x, 5);
  EXPECT_FALSE(zones[1].is_hazard);
}

TEST_F(PlainFolder, TerrainRoundTrips) {
  FrameTruth truth{made_up_truth("000007", 200)};
  truth.ego.z_m = 0.25;
  truth.ego.pitch_rad = -0.125;
  truth.ego.roll_rad = 0.0625;
  truth.ego.camera_height_m = 1.125;
  truth.ego.camera_pitch_rad = 0.03125;
  truth.ego.camera_roll_rad = -0.5;
  truth.terrain = Image<std::uint8_t>{6, 4, 3};
  truth.elevation_m = Image<float>{6, 4, -1.5F};
  truth.step_m = Image<float>{6, 4, 0.25F};
  write(truth);
  const FrameTruth again{TruthReader{folder / "out" / "truth"}.frame("000007")};
  expect_equal(again, truth);
  EXPECT_EQ(again.ego.z_m, 0.25);
  EXPECT_EQ(again.ego.pitch_rad, -0.125);
  EXPECT_EQ(again.ego.roll_rad, 0.0625);
  EXPECT_EQ(again.ego.camera_height_m, 1.125);
  EXPECT_EQ(again.ego.camera_pitch_rad, 0.03125);
  EXPECT_EQ(again.ego.camera_roll_rad, -0.5);
}

TEST_F(PlainFolder, RoundTrips) {
  const FrameTruth truth{made_up_truth("000007", 200)};
  write(truth);
  const TruthReader reader{folder / "out" / "truth"};
  EXPECT_EQ(reader.grid().geometry, grid.geometry);
  EXPECT_EQ(reader.grid().height_max_m, 1.8);
  EXPECT_EQ(reader.names(), std::vector<std::string>{"000007"});
  EXPECT_TRUE(reader.has("000007"));
  EXPECT_FALSE(reader.has("000008"));
  expect_equal(reader.frame("000007"), truth);
  const auto recording{open_recording({{folder / "out"}, {}, ""})};
  EXPECT_EQ(recording->rig(), rig);
  EXPECT_TRUE(recording->has_truth());
  const StereoFrame frame{recording->load(0)};
  EXPECT_EQ(frame.left, frame_of(truth).left);
  EXPECT_EQ(frame.stamp_ns, truth.stamp_ns);
  EXPECT_EQ(frame.world_from_vehicle, truth.ego.world_from_vehicle);
}

TEST_F(PlainFolder, ManyObjectsNeedWiderTypes) {
  const FrameTruth truth{made_up_truth("a", 300)};
  write(truth);
  expect_equal(TruthReader{folder / "out" / "truth"}.frame("a"), truth);
}

TEST_F(PlainFolder, HalfWrittenIsNotTakenForWhole) {
  const FrameTruth truth{made_up_truth("a", 3)};
  PlainFolderWriter writer{folder / "out", rig, grid};
  writer.write(frame_of(truth), &truth);
  expect_no_recording({{folder / "out"}, {}, ""}, {"no calibration"});
  expect_error([&] { PlainFolderWriter(folder / "out", rig); }, {"out", "already holds a recording"});
}

TEST_F(PlainFolder, WithoutTruth) {
  PlainFolderWriter writer{folder / "out", rig};
  writer.write(frame_of(made_up_truth("a", 3)));
  writer.finish();
  EXPECT_FALSE(open_recording({{folder / "out"}, {}, ""})->has_truth());
}

TEST_F(PlainFolder, CamerasHaveFoldersOfTheirOwn) {
  std::array rigs{rig, rig};
  rigs[1].camera_x_m = -1;
  rigs[1].camera_yaw_rad = 3;
  const FrameTruth truth{made_up_truth("a", 3)};
  StereoFrame frame{frame_of(truth)};
  frame.others.push_back(frame_of(truth));
  frame.others[0].camera = 1;
  PlainFolderWriter writer{folder / "out", rigs, grid};
  writer.write(frame, &truth);
  expect_no_recording({{folder / "out"}, {}, ""}, {"out"});
  writer.finish();
  const auto recording{open_recording({{folder / "out"}, {}, ""})};
  EXPECT_TRUE(std::ranges::equal(recording->rigs(), rigs));
  EXPECT_TRUE(recording->has_truth());
  ASSERT_EQ(recording->load(0).others.size(), 1U);
  EXPECT_EQ(recording->load(0).others[0].left, frame.left);
}

TEST_F(PlainFolder, TruthErrors) {
  write(made_up_truth("a", 3));
  const fs::path truth{folder / "out" / "truth"};
  const auto refused{[&](std::initializer_list<std::string_view> parts) {
    expect_error([&] { return TruthReader{truth}.frame("a"); }, parts);
  }};
  write_png(truth / "label" / "a.png", Image<std::uint8_t>{5, 5});
  refused({"label/a.png", "another size"});
  fs::remove(truth / "label" / "a.png");
  refused({"label/a.png", "no such file"});
  write_png(truth / "label" / "a.png", Image<std::uint8_t>{width_px, height_px});
  const std::vector<float> values(24);
  write_npz(truth / "cells" / "a.npz", std::vector<NpzArray>{{"state", {4, 6}, values}});
  refused({"cells/a.npz", "'occupied'"});
  write_npz(truth / "cells" / "a.npz", std::vector<NpzArray>{{"state", {6, 4}, values}});
  refused({"cells/a.npz", "'state'", "grid.json"});
  expect_error([&] { return TruthReader{truth}.frame("b"); }, {"no frame b"});
  put(truth / "objects.jsonl", "{\"name\": \"a\"}\n");
  refused({"objects.jsonl", "frame a is not understood"});
  put(truth / "objects.jsonl", "nonsense\n");
  refused({"objects.jsonl", "line 1"});
  put(truth / "grid.json", "{}");
  refused({"grid.json", "not understood"});
}

/// Reading a shared set and writing it again gives the same numbers, names and types.
TEST_F(PlainFolder, SharedSetsRoundTrip) {
  const auto data{data_folder()};
  if (!data) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  for (const char* const set : {"A-static-occlusion", "C-street", "E-kitti-like"}) {
    const fs::path from{*data / "synthetic" / set};
    const fs::path to{folder / set};
    const auto recording{open_recording({{from}, {}, ""})};
    const TruthReader reader{from / "truth"};
    EXPECT_EQ(reader.names().size(), recording->size());
    PlainFolderWriter writer{to, recording->rig(), reader.grid()};
    for (const std::size_t index : {std::size_t{0}, recording->size() - 1}) {
      const FrameTruth truth{reader.frame(recording->name(index))};
      writer.write(recording->load(index), &truth);
    }
    writer.finish();
    const TruthReader again{to / "truth"};
    EXPECT_EQ(read_calibration(to / "calibration.yaml").rig, recording->rig());
    for (const std::string& name : again.names()) {
      expect_equal(again.frame(name), reader.frame(name));
      const auto ours{read_npz(to / "truth" / "cells" / (name + ".npz"))};
      const auto theirs{read_npz(from / "truth" / "cells" / (name + ".npz"))};
      ASSERT_EQ(ours.size(), theirs.size());
      for (const auto& [array, content] : theirs) {
        EXPECT_EQ(ours.at(array).dtype, content.dtype) << array;
        EXPECT_EQ(ours.at(array).bytes, content.bytes) << array;
      }
    }
    const auto lines{[](const fs::path& path) {
      return nlohmann::json::parse(read_file(path).substr(0, read_file(path).find('\n')));
    }};
    EXPECT_EQ(lines(to / "truth" / "objects.jsonl"), lines(from / "truth" / "objects.jsonl")) << set;
    EXPECT_EQ(nlohmann::json::parse(read_file(to / "truth" / "grid.json")),
              nlohmann::json::parse(read_file(from / "truth" / "grid.json")));
    const std::string rows{read_file(from / "poses.csv")};
    EXPECT_TRUE(read_file(to / "poses.csv").starts_with(rows.substr(0, rows.find('\n', 31)))) << set;
  }
}

const std::string box{R"("kind": "car", "x_m": 6, "y_m": -2.5, "yaw_rad": 0.25, "length_m": 4, "width_m": 1.75)"};

struct ObjectLabels : FolderTest {
  [[nodiscard]] std::vector<LabelledFrame> read(const std::string& text) const {
    put(folder / "objects.jsonl", text);
    return read_object_labels(folder / "objects.jsonl");
  }
  void expect_refused(const std::string& text, std::string_view part) const {
    expect_error([&] { return read(text); }, {"objects.jsonl", part});
  }
};

TEST_F(ObjectLabels, AreRead) {
  const auto frames{
      read(R"({"name": "7", "objects": []})"
           "\n"
           R"({"name": "8", "objects": [{"id": 3, "occluded": 1, "moving": true, "vx_mps": 1, "vy_mps": 2, )" +
           box + R"(}, {"id": 4, "occluded": null, "moving": null, "vx_mps": null, "vy_mps": null, )" + box + "}]}\n")};
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].name, "7");
  EXPECT_TRUE(frames[0].objects.empty());
  ASSERT_EQ(frames[1].objects.size(), 2U);
  const LabelledObject& known{frames[1].objects[0]};
  EXPECT_EQ(known.id, 3);
  EXPECT_EQ(known.kind, "car");
  EXPECT_EQ(known.y_m, -2.5);
  EXPECT_EQ(known.width_m, 1.75);
  EXPECT_EQ(known.occluded, 1);
  EXPECT_EQ(known.moving, true);
  EXPECT_EQ(known.velocity_mps.value().y, 2);
  const LabelledObject& unknown{frames[1].objects[1]};
  EXPECT_EQ(unknown.occluded, 0);
  EXPECT_FALSE(unknown.moving || unknown.velocity_mps);
}

TEST_F(ObjectLabels, Findings) {
  const auto line = [](const std::string& object) { return R"({"name": "1", "objects": [{)" + object + "}]}\n"; };
  expect_refused("{\n", "line 1 is not understood");
  expect_refused(line(box), "id");
  expect_refused(line(R"("id": -1, )" + box), "'id' is not a whole number");
  expect_refused(line(R"("id": 1, "occluded": 9, )" + box), "'occluded'");
  expect_refused(line(R"("id": 1, "kind": "car", "x_m": 1e9)"), "'x_m' is out of range");
  expect_refused(R"({"name": "1", "objects": {}})", "'objects' is not a list");
  expect_refused(R"({"name": "1", "objects": []})"
                 "\n"
                 R"({"name": "1", "objects": []})",
                 "names frame 1 twice");
  expect_refused(R"({"name": "1", "objects": [{"id": 1, )" + box + R"(}, {"id": 1, )" + box + "}]}",
                 "stands for two objects");
  expect_refused(line(R"("id": 1, "kind": "car", "x_m": 1, "y_m": 1, "yaw_rad": 0, "length_m": -4)"),
                 "'length_m' is negative");
}

}  // namespace

}  // namespace stereogrid::io::testing

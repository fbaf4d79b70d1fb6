// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/truth.hpp"

#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

const std::string box{R"("kind": "car", "x_m": 6, "y_m": -2.5, "yaw_rad": 0.25, "length_m": 4, "width_m": 1.75)"};

class ObjectLabels : public ::testing::Test {
 protected:
  [[nodiscard]] std::vector<LabelledFrame> read(const std::string& text) const {
    put(folder_ / "objects.jsonl", text);
    return read_object_labels(folder_ / "objects.jsonl");
  }
  void expect_refused(const std::string& text, std::string_view part) const {
    expect_error([&] { static_cast<void>(read(text)); }, {"objects.jsonl", part});
  }

 private:
  const TemporaryFolder folder_;
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
  expect_refused(line(R"("id": -1, )" + box), "'id' is no whole number");
  expect_refused(line(R"("id": 1, "occluded": 9, )" + box), "'occluded'");
  expect_refused(line(R"("id": 1, "kind": "car", "x_m": 1e9)"), "'x_m' is no number of a size");
  expect_refused(R"({"name": "1", "objects": {}})", "'objects' is no list");
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

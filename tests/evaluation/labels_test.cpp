// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::evaluation::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const GridGeometry metre_grid{0, -5, 1, 20, 10};  // 20 m ahead, 5 m to either side

/// A sweep over a road that falls by `slope` m per m; `height` is measured from it.
class Sweep {
 public:
  explicit Sweep(double slope = 0) : slope_{slope} {
    for (double z{4.25}; z < 28; z += 1) {
      for (double y{-6.5}; y < 8; y += 2) add(z, y, 0);  // rows of cells between them stay unknown
    }
  }
  /// A return x m ahead, y m to the left.
  void add(double x, double y, double height) { points_.push_back({-y, 1.64 + slope_ * x - height, x}); }
  void add(double x, double y, double height, int times) {
    for (int i{0}; i < times; ++i) add(x, y, height);
  }
  [[nodiscard]] Labels labels(const GridGeometry& grid = metre_grid) const {
    return lidar_labels(points_, small_rig(), grid);
  }

 private:
  double slope_;
  std::vector<CameraPoint> points_;
};

// A camera pitched downwards and rolled to the right.
TEST(LidarLabels, FollowTheMounting) {
  for (const double pitch_rad : {0.2, -0.1, 0.0}) {
    constexpr double roll_rad{0.05};
    Rig rig{small_rig()};
    rig.camera_pitch_rad = pitch_rad;
    rig.camera_roll_rad = roll_rad;
    const double c{std::cos(pitch_rad)};
    const double s{std::sin(pitch_rad)};
    std::vector<CameraPoint> points;
    // x ahead, y to the left, `height` above the road, which rises to the right by the roll
    const auto add = [&](double x, double y, double height) {
      const double down{1.2 / std::cos(roll_rad) + y * std::tan(roll_rad) - height};
      points.push_back({-y, c * down - s * x, s * down + c * x});
    };
    for (double x{4.25}; x < 20; x += 0.5) {
      for (double y{-4.75}; y < 5; y += 0.5) add(x, y, 0);
    }
    for (int k{0}; k < 3; ++k) add(8.5, 0.5, 0.8 + 0.1 * k);
    const Labels labels{lidar_labels(points, rig, metre_grid, 1.2)};
    EXPECT_EQ(labels.cells(8, 5), labelled_occupied) << pitch_rad;
    EXPECT_EQ(std::ranges::count(labels.cells, labelled_occupied), 1) << pitch_rad;
    EXPECT_GT(std::ranges::count(labels.cells, labelled_free), 100) << pitch_rad;
  }
}

TEST(LidarLabels, FollowTheHeightsOfTheReturns) {
  Sweep sweep;
  sweep.add(8.5, 0.5, 1.0, 2);     // occupied
  sweep.add(9.5, 1.5, 1.0, 1);     // too few to be an obstacle, too many to be free
  sweep.add(10.5, 0.5, 0.2, 5);    // neither road nor obstacle
  sweep.add(11.5, 0.5, 2.0, 5);    // a branch
  sweep.add(12.5, 0.5, 0.29, 2);   // kerb
  sweep.add(13.5, 0.5, 0.31, 2);   // occupied
  sweep.add(14.5, 0.5, -0.11, 1);  // free
  sweep.add(15.5, 0.5, 0.0, 3);    // free, but for
  sweep.add(15.5, 0.5, 1.0, 2);    // an obstacle on it
  const Labels labels(sweep.labels());
  const auto cell = [&](int x, int y) { return labels.cells(x, y + 5); };
  EXPECT_EQ(cell(8, 0), labelled_occupied);
  EXPECT_EQ(cell(9, 1), not_scored);
  EXPECT_EQ(cell(10, 0), not_scored);
  EXPECT_EQ(cell(11, 0), not_scored);
  EXPECT_EQ(cell(12, 0), not_scored);
  EXPECT_EQ(cell(13, 0), labelled_occupied);
  EXPECT_EQ(cell(14, 0), labelled_free);
  EXPECT_EQ(cell(15, 0), labelled_occupied);
  // the road's returns at y = −0.5, 1.5 and so on
  EXPECT_EQ(cell(6, -1), labelled_free);
  EXPECT_EQ(cell(6, 0), not_scored);
  EXPECT_EQ(cell(6, 1), labelled_free);
}

TEST(LidarLabels, FindATiltedRoad) {
  Sweep sweep{0.01};
  sweep.add(18.5, 0.5, 0.25, 2);  // 0.07 m over a level road: would be free
  sweep.add(16.5, 1.5, 0.35, 2);  // 0.18 m: would be neither
  const Labels labels(sweep.labels());
  EXPECT_EQ(labels.cells(18, 5), not_scored);
  EXPECT_EQ(labels.cells(16, 6), labelled_occupied);
  EXPECT_EQ(labels.cells(19, 4), labelled_free);
}

TEST(LidarLabels, TakeOnlyWhatTheCameraSees) {
  Sweep sweep;
  sweep.add(3.5, 4.5, 1.0, 5);   // u = 100 − 129: left of the image
  sweep.add(0.5, 0.0, 1.0, 5);   // less than a metre ahead
  sweep.add(4.5, -4.4, 1.0, 2);  // u = 198
  const Labels labels(sweep.labels());
  EXPECT_EQ(labels.cells(3, 9), not_scored);
  EXPECT_EQ(labels.cells(0, 5), not_scored);
  EXPECT_EQ(labels.cells(4, 0), labelled_occupied);
}

TEST(LidarLabels, OfAnEmptySweepSayNothing) {
  const Labels labels(lidar_labels({}, small_rig(), metre_grid));
  EXPECT_TRUE(std::ranges::all_of(labels.cells, [](int label) { return label == not_scored; }));
}

/// A crate at 6 m whose returns cover the columns from y/x = −1/6 to 1/6, every one of them.
void add_crate(Sweep& sweep, double height) {
  for (double y{-1}; y <= 1; y += 0.06) sweep.add(6.1, y, height);
}

TEST(LidarLabels, KnowWhatIsPartlyHidden) {
  Sweep sweep;
  add_crate(sweep, 0.8);
  sweep.add(12.5, 0.5, 1.5, 2);  // over the crate
  sweep.add(12.5, 4.5, 1.5, 2);  // beside it
  sweep.add(14.5, 0.5, 0, 1);    // road behind it
  const Labels labels(sweep.labels());
  ASSERT_EQ(labels.cells(6, 5), labelled_occupied);
  EXPECT_EQ(labels.partly_hidden(6, 5), 0) << "the crate does not hide itself";
  ASSERT_EQ(labels.cells(12, 5), labelled_occupied);
  EXPECT_EQ(labels.partly_hidden(12, 5), 1);
  ASSERT_EQ(labels.cells(12, 9), labelled_occupied);
  EXPECT_EQ(labels.partly_hidden(12, 9), 0);
  ASSERT_EQ(labels.cells(14, 5), labelled_free);
  EXPECT_EQ(labels.partly_hidden(14, 5), 1);
  ASSERT_EQ(labels.cells(5, 4), labelled_free);
  EXPECT_EQ(labels.partly_hidden(5, 4), 0);
  EXPECT_EQ(labels.partly_hidden(13, 5), 0) << "not labelled";
}

TEST(LidarLabels, GroundBehindObstaclesIsHidden) {
  Sweep sweep;
  for (double y{-0.5}; y < 0.5; y += 0.01) sweep.add(6.02, y, 0.8);
  for (const double x : {5.52, 6.12, 7.52, 9.52, 10.12}) sweep.add(x, 0.02, 0, 1);
  sweep.add(7.52, 0.92, 0, 1);
  const Labels labels(sweep.labels({0, -1, 0.05, 300, 40}));
  const auto is_hidden = [&](int x, int y) {
    EXPECT_EQ(labels.cells(x, y), labelled_free);
    return labels.hidden_ground(x, y) == 1;
  };
  EXPECT_TRUE(is_hidden(150, 20));
  EXPECT_TRUE(is_hidden(190, 20));
  EXPECT_FALSE(is_hidden(202, 20)) << "more than 4 m behind it";
  EXPECT_FALSE(is_hidden(122, 20)) << "less than 0.25 m behind it";
  EXPECT_FALSE(is_hidden(110, 20)) << "in front of it";
  EXPECT_FALSE(is_hidden(150, 38)) << "another bearing";
  ASSERT_EQ(labels.cells(120, 20), labelled_occupied);
  EXPECT_EQ(labels.hidden_ground(120, 20), 0);
}

TEST(LidarLabels, SingleReturnsAndTheOwnBonnetHideNothing) {
  Sweep sweep;
  for (int y{-3}; y <= 2; ++y) sweep.add(6.1, y + 0.5, 0.8);  // one in each cell
  for (double y{-0.5}; y <= 0.5; y += 0.01) sweep.add(2.2, y, 0.8);
  sweep.add(12.5, 0.5, 1.5, 2);
  const Labels labels(sweep.labels());
  EXPECT_EQ(labels.cells(12, 5), labelled_occupied);
  EXPECT_EQ(labels.partly_hidden(12, 5), 0);
}

TEST(LidarLabels, LowThingsHideNothing) {
  Sweep sweep;
  add_crate(sweep, 0.25);
  sweep.add(12.5, 0.5, 1.5, 2);
  EXPECT_EQ(sweep.labels().partly_hidden(12, 5), 0);
}

TEST(LidarLabels, FreeColumnsAreEnoughNotToBeHidden) {
  Sweep sweep;
  for (double y{-1}; y <= 0.3; y += 0.06) sweep.add(6.1, y, 0.8);  // not the two leftmost of the cell's columns
  sweep.add(12.5, 0.5, 1.5, 2);
  const Labels labels(sweep.labels());
  EXPECT_EQ(labels.cells(12, 5), labelled_occupied);
  EXPECT_EQ(labels.partly_hidden(12, 5), 0);
}

/// Exact truth on metre_grid: nothing seen, sky.
FrameTruth empty_truth() {
  FrameTruth truth;
  truth.state = {20, 10};
  truth.disparity = {201, 101};
  truth.label = {201, 101};
  return truth;
}

TEST(TruthLabels, AreWhatTheCameraSees) {
  FrameTruth truth(empty_truth());
  truth.state(3, 2) = static_cast<std::uint8_t>(TruthCell::seen_free);
  truth.state(4, 2) = static_cast<std::uint8_t>(TruthCell::seen_occupied);
  const GridGeometry wider{-1, -6, 1, 30, 10};  // one cell more behind, one more to the right, and so on
  const Labels labels(truth_labels(truth, {metre_grid, 0.15, 1.8}, small_rig(), wider));
  EXPECT_EQ(labels.cells(4, 3), labelled_free);
  EXPECT_EQ(labels.cells(5, 3), labelled_occupied);
  EXPECT_EQ(std::ranges::count(labels.cells, not_scored), 298);
}

TEST(TruthLabels, KnowWhatIsPartlyHidden) {
  FrameTruth truth(empty_truth());
  truth.state(12, 5) = static_cast<std::uint8_t>(TruthCell::seen_occupied);
  truth.state(14, 5) = static_cast<std::uint8_t>(TruthCell::seen_free);
  truth.state(6, 5) = static_cast<std::uint8_t>(TruthCell::seen_occupied);
  const auto mark = [&](int v, TruthLabel label) {
    for (int u{85}; u <= 115; ++u) {
      truth.label(u, v) = static_cast<std::uint8_t>(label);
      truth.disparity(u, v) = 8;  // f·b = 50 px·m: 6.25 m ahead
    }
  };
  const auto hidden = [&] {
    const Labels labels(truth_labels(truth, {metre_grid, 0.15, 1.8}, small_rig(), metre_grid));
    return std::vector<int>{labels.partly_hidden(6, 5), labels.partly_hidden(12, 5), labels.partly_hidden(14, 5)};
  };
  mark(49, TruthLabel::obstacle);  // 1.70 m high: within the limits
  EXPECT_EQ(hidden(), (std::vector<int>{0, 1, 1}));
  mark(49, TruthLabel::low);
  EXPECT_EQ(hidden(), (std::vector<int>{0, 0, 0}));
  mark(45, TruthLabel::obstacle);  // 1.95 m
  EXPECT_EQ(hidden(), (std::vector<int>{0, 0, 0}));
}

TEST(TruthLabels, TakeThePitchIntoAccount) {
  FrameTruth truth(empty_truth());
  truth.state(12, 5) = static_cast<std::uint8_t>(TruthCell::seen_occupied);
  Rig rig(small_rig());
  rig.camera_pitch_rad = 0.2;
  const double z{6};
  // seen at a height of 1 m, 6 m along the axis: row from H − z·sin − y·cos = 1
  const double y{(rig.camera_height_m - 1 - z * std::sin(0.2)) / std::cos(0.2)};
  const int v{static_cast<int>(std::lround(50 + 100 * y / z))};
  for (int u{80}; u <= 120; ++u) {
    truth.label(u, v) = static_cast<std::uint8_t>(TruthLabel::obstacle);
    truth.disparity(u, v) = static_cast<float>(50 / z);
  }
  const auto hidden = [&](const Rig& with) {
    return truth_labels(truth, {metre_grid, 0.15, 1.8}, with, metre_grid).partly_hidden(12, 5);
  };
  EXPECT_EQ(hidden(rig), 1);
  EXPECT_EQ(hidden(small_rig()), 0) << "a level camera would see it 2.2 m high";
}

TEST(TruthLabels, RefuseCellsThatDoNotCoincide) {
  const auto shift = [](const GridGeometry& grid) { return [=] { (void)shift_between(grid, metre_grid); }; };
  EXPECT_THAT(shift({0, -5, 0.5, 20, 10}), ThrowsMessage<InputError>(HasSubstr("--set grid.cell_size_m=1")));
  EXPECT_THAT(shift({0.3, -5, 1, 20, 10}), ThrowsMessage<InputError>(HasSubstr("do not coincide")));
  EXPECT_NO_THROW(shift({-2, -7, 1, 20, 10})());
}

}  // namespace
}  // namespace stereogrid::evaluation::testing

// SPDX-License-Identifier: Apache-2.0
#include "geometry/road_plane.hpp"
#include "ground/plane_evidence.hpp"

#include "support.hpp"

namespace stereogrid::test {
namespace {

using Vector = std::array<double, 3>;

struct Seen {
  double u;
  double v;
  double disparity;
};

// A camera `height_m` above the road. The level camera points along +forward; it is then pitched nose down, then rolled
// right side down. Axes of the world: right, down, forward; the road is at down = height_m.
class Camera {
 public:
  Camera(const Rig& rig, const Ground& ground) : rig_{rig}, height_m_{ground.height_m} {
    const double cp{std::cos(ground.pitch_rad)};
    const double sp{std::sin(ground.pitch_rad)};
    const double cr{std::cos(ground.roll_rad)};
    const double sr{std::sin(ground.roll_rad)};
    forward_ = {0, sp, cp};  // nose down: the optical axis gains a downward part
    const Vector level_right{1, 0, 0};
    const Vector pitched_down{0, cp, -sp};
    for (std::size_t i{0}; i < 3; ++i) {
      right_[i] = cr * level_right[i] + sr * pitched_down[i];  // right side down
      down_[i] = cr * pitched_down[i] - sr * level_right[i];
    }
  }

  [[nodiscard]] Seen see(double right_m, double above_road_m, double forward_m) const {
    const Vector point{right_m, height_m_ - above_road_m, forward_m};
    const double depth{dot(forward_, point)};
    return {rig_.cx_px + rig_.focal_px * dot(right_, point) / depth,
            rig_.cy_px + rig_.focal_px * dot(down_, point) / depth, rig_.focal_px * rig_.baseline_m / depth};
  }

 private:
  static double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  Rig rig_;
  double height_m_;
  Vector right_{};
  Vector down_{};
  Vector forward_{};
};

const std::vector<Ground>& grounds() {
  static const std::vector<Ground> all{
      {1.65, 0, 0, false},    {1.2, 0.05, 0, false},    {1.65, -0.03, 0, false},     {1.5, 0, 0.04, false},
      {1.5, 0, -0.04, false}, {1.7, 0.02, 0.03, false}, {0.9, -0.015, -0.05, false}, {2.2, 0.2, 0.1, false},
  };
  return all;
}

TEST(GroundModel, RoadPlaneIsWhatACameraSees) {
  const Rig rig{small_kitti_rig()};
  for (const Ground& ground : grounds()) {
    const Camera camera{rig, ground};
    const RoadPlane plane{road_plane(rig, ground)};
    for (const double right_m : {-4.0, -1.0, 0.0, 2.5}) {
      for (const double forward_m : {4.0, 9.0, 25.0}) {
        const Seen seen{camera.see(right_m, 0, forward_m)};
        EXPECT_NEAR(plane.disparity(seen.u, seen.v), seen.disparity, 1e-9)
            << "pitch " << ground.pitch_rad << " roll " << ground.roll_rad;
      }
    }
  }
}

TEST(GroundModel, SignsOfPitchAndRoll) {
  const Rig rig{small_kitti_rig()};
  const RoadPlane level{road_plane(rig, {1.65, 0, 0, false})};
  EXPECT_NEAR(level.at_centre, 0, 1e-12);
  EXPECT_NEAR(level.per_u, 0, 1e-12);
  EXPECT_NEAR(level.per_v, rig.baseline_m / 1.65, 1e-12);
  // looking down, the road fills the image's middle, so the horizon has moved up
  EXPECT_GT(road_plane(rig, {1.65, 0.05, 0, false}).at_centre, 0);
  EXPECT_LT(horizon_row(rig, {1.65, 0.05, 0, false}), rig.cy_px);
  // with its right side down the camera sees the road nearer on the right
  EXPECT_GT(road_plane(rig, {1.65, 0, 0.05, false}).per_u, 0);
}

TEST(GroundModel, GroundOfUndoesRoadPlane) {
  const Rig rig{small_kitti_rig()};
  for (const Ground& ground : grounds()) {
    const Ground back{ground_of(rig, road_plane(rig, ground))};
    EXPECT_NEAR(back.height_m, ground.height_m, 1e-12);
    EXPECT_NEAR(back.pitch_rad, ground.pitch_rad, 1e-12);
    EXPECT_NEAR(back.roll_rad, ground.roll_rad, 1e-12);
    EXPECT_TRUE(back.estimated);
  }
}

TEST(GroundModel, NumbersChangeWithTheGroundAsThePlaneDoes) {
  const Rig rig{small_kitti_rig()};
  const Ground ground{1.6, 0.02, -0.01, true};
  const Matrix3 slopes{numbers_by_ground(rig, ground)};
  constexpr double step{1e-6};
  for (int k{0}; k < 3; ++k) {
    Ground moved{ground};
    (k == 0 ? moved.height_m : k == 1 ? moved.pitch_rad : moved.roll_rad) += step;
    const Vector3 change{numbers_of(road_plane(rig, moved)) - numbers_of(road_plane(rig, ground))};
    for (int i{0}; i < 3; ++i) {
      EXPECT_NEAR(slopes[i][k], change[i] / step, 1e-3 * std::max(1.0, std::abs(slopes[i][k]))) << i << " " << k;
    }
  }
}

TEST(GroundModel, HorizonIsWhereTheRoadEnds) {
  const Rig rig{small_kitti_rig()};
  for (const double pitch_rad : {-0.04, 0.0, 0.05}) {
    const Ground ground{1.65, pitch_rad, 0, false};
    EXPECT_NEAR(horizon_row(rig, ground), rig.cy_px - rig.focal_px * std::tan(pitch_rad), 1e-12);
    EXPECT_NEAR(Camera(rig, ground).see(0, 0, 1e9).v, horizon_row(rig, ground), 1e-5);
    EXPECT_NEAR(road_plane(rig, ground).disparity(10, horizon_row(rig, ground)), 0, 1e-12);
  }
}

// docs/method.md §1.3: points at a height, at any depth, below or above the camera
TEST(GroundModel, RowAtHeightIsWhereACameraSeesIt) {
  const Rig rig{small_kitti_rig()};
  for (const double pitch_rad : {-0.04, 0.0, 0.05, 0.15}) {
    const Ground ground{1.65, pitch_rad, 0, false};
    const Camera camera{rig, ground};
    for (const double above_m : {0.0, 0.3, 1.65, 1.8, 3.0}) {
      for (const double forward_m : {4.0, 10.0, 40.0}) {
        const Seen seen{camera.see(-1.5, above_m, forward_m)};
        EXPECT_NEAR(row_at_height(rig, ground, seen.disparity, above_m), seen.v, 1e-9)
            << "pitch " << pitch_rad << " height " << above_m;
      }
    }
  }
}

Ground moved(const Ground& ground, double height_m, double pitch_rad, double roll_rad) {
  return {ground.height_m + height_m, ground.pitch_rad + pitch_rad, ground.roll_rad + roll_rad, false};
}

TEST(GroundModel, PlaneSigmaIsWhatAMovedPlaneDiffers) {
  const Rig rig{small_kitti_rig()};
  constexpr double step{1e-6};
  for (Ground ground : grounds()) {
    const auto change = [&](const Ground& other) {
      return (road_plane(rig, other).disparity(100, 170) - road_plane(rig, ground).disparity(100, 170)) / step;
    };
    const double by_height{change(moved(ground, step, 0, 0))};
    const double by_pitch{change(moved(ground, 0, step, 0))};
    const double by_roll{change(moved(ground, 0, 0, step))};
    ground.height_sigma_m = 0.02;
    EXPECT_NEAR(plane_sigma_px(rig, ground, 100, 170), std::abs(0.02 * by_height), 1e-3);
    ground.pitch_sigma_rad = 0.003;
    ground.height_pitch_correlation = 1;
    EXPECT_NEAR(plane_sigma_px(rig, ground, 100, 170), std::abs(0.02 * by_height + 0.003 * by_pitch), 1e-3);
    ground.height_pitch_correlation = 0;
    ground.roll_sigma_rad = 0.004;
    EXPECT_NEAR(plane_sigma_px(rig, ground, 100, 170), std::hypot(0.02 * by_height, 0.003 * by_pitch, 0.004 * by_roll),
                1e-3);
  }
  EXPECT_EQ(plane_sigma_px(rig, grounds()[0], 100, 170), 0) << "trusted";
}

TEST(GroundModel, RoundedCovarianceRemainsPositiveDefinite) {
  for (const double correlation : {-0.4999999, 0.0, 0.3, 0.9999, 0.9999999}) {
    Ground ground{1.65, 0, 0, true, 0.01, 0.002, 0.001, correlation, correlation, correlation};
    ground = rounded(ground);
    EXPECT_TRUE(is_positive_definite(covariance_of(ground))) << correlation;
    EXPECT_NEAR(ground.height_sigma_m, 0.01, 0.5 / (1 << 20));
    EXPECT_NEAR(ground.pitch_roll_correlation, correlation, 1.5 / (1 << 12));
    EXPECT_EQ(rounded(ground).height_sigma_m, ground.height_sigma_m);
  }
}

TEST(GroundModel, CovarianceSurvivesTheWayThroughSigmasAndCorrelations) {
  const Matrix3 covariance{{{4e-4, -1e-5, 2e-6}, {-1e-5, 9e-6, 1e-6}, {2e-6, 1e-6, 2.5e-5}}};
  const Matrix3 back{covariance_of(with_covariance({1.65, 0, 0, true}, covariance))};
  const Matrix3 one{covariance * inverse(covariance)};
  for (std::size_t i{0}; i < 3; ++i) {
    for (std::size_t j{0}; j < 3; ++j) {
      EXPECT_NEAR(back[i][j], covariance[i][j], 1e-15);
      EXPECT_NEAR(one[i][j], i == j ? 1 : 0, 1e-12);
    }
  }
  EXPECT_TRUE(is_positive_definite(covariance));
  EXPECT_FALSE(is_positive_definite({{{1, 2, 0}, {2, 1, 0}, {0, 0, 1}}}));
}

}  // namespace
}  // namespace stereogrid::test

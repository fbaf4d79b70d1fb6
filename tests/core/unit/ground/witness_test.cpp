// SPDX-License-Identifier: Apache-2.0
//
// Evidence that lets a cell be free, and the speed that the terrain in view allows (docs/terrain.md).
#include "terrain_frame.hpp"

namespace stereogrid::test {
namespace {

// Rays say "free" everywhere: filtered_at() and FrameOf::result.observed are 0 before the bounds.
TEST(Witness, FreeNeedsGroundSeenNowOrBefore) {
  FrameOf frame{ramp(5, 0)};
  const Image<float> nothing{frame.vehicle.rig.width_px, frame.vehicle.rig.height_px};
  EXPECT_EQ(frame.filtered_at(1), 0.5f) << "nearer than the image shows";
  EXPECT_EQ(frame.witness_at(1), CellWitness::of(Witness::passable)) << "for rays";
  EXPECT_EQ(frame.filtered_at(6), 0);
  EXPECT_EQ(frame.witness_at(6), CellWitness::of(Witness::ground));
  frame.pose = {5, 0, 0};
  frame.see(nothing);
  EXPECT_EQ(frame.filtered_at(1), 0) << "6 m before";
  EXPECT_EQ(frame.witness_at(1), CellWitness::of(Witness::memory, 0.1f));
  EXPECT_EQ(frame.result.observed(5, frame.vehicle.grid.ny / 2), 0) << "rays decide";
  EXPECT_EQ(frame.filtered_at(1, false), 0) << "also in a rejected frame";
  frame.see(nothing, FrameOf::config().vehicle.ground_memory_s);
  EXPECT_EQ(frame.filtered_at(1), 0.5f) << "too old";
  EXPECT_EQ(frame.result.observed(5, frame.vehicle.grid.ny / 2), 0.5f);
  EXPECT_EQ(frame.witness_at(1).kind(), Witness::passable);
}

TEST(Witness, GroundOfAPlaneThatIsNotMeasuredIsNotRemembered) {
  for (const bool is_measured : {true, false}) {
    FrameOf frame{step(4, 3)};
    frame.is_ground_measured = is_measured;
    frame.see(disparity_of(frame.vehicle.rig, ramp(5, 0)));
    EXPECT_EQ(frame.filtered_at(6), 0) << "in its own frame";
    frame.pose = {5, 0, 0};
    frame.see(Image<float>{frame.vehicle.rig.width_px, frame.vehicle.rig.height_px});
    EXPECT_EQ(frame.filtered_at(1), is_measured ? 0 : 0.5f);
  }
}

TEST(Witness, GroundInARejectedFrameIsNone) {
  FrameOf frame{ramp(5, 0)};
  EXPECT_EQ(frame.filtered_at(6, false), 0.5f);
  EXPECT_FALSE(frame.witness_at(6).allows_free());
}

// From far away the ground before an edge hides it.
TEST(Witness, EndsWhereAnEdgeIsSeen) {
  FrameOf frame{ramp(5, 0)};
  EXPECT_EQ(frame.filtered_at(5), 0);
  frame.see(disparity_of(frame.vehicle.rig, step(4, -0.25f)));
  EXPECT_GE(frame.filtered_at(5), 0.5f);
  EXPECT_FALSE(frame.witness_at(5).allows_free());
  frame.see(Image<float>{frame.vehicle.rig.width_px, frame.vehicle.rig.height_px});
  EXPECT_GE(frame.filtered_at(5), 0.5f) << "not remembered";
}

// A stone that only the pixels show, in the vehicle's grid.
TEST(Witness, EndsWhereALowObstacleIsSeen) {
  FrameOf frame{ramp(5, 0)};
  EXPECT_EQ(frame.filtered_at(4.1), 0);
  frame.see(disparity_of(frame.vehicle.rig,
                         [](float x, float y) { return x > 4 && x < 4.3f && std::abs(y) < 0.15f ? 0.2f : 0.0f; }));
  ASSERT_EQ(frame.rule_at(4.1), CellRule::obstacle);
  EXPECT_GE(frame.filtered_at(4.1), 0.5f);
  frame.see(Image<float>{frame.vehicle.rig.width_px, frame.vehicle.rig.height_px});
  EXPECT_GE(frame.filtered_at(4.1), 0.5f);
  EXPECT_FALSE(frame.witness_at(4.1).allows_free());
}

// From afar the matcher's window smears ground over a pit without texture, from nearer there is none.
TEST(Witness, EndsWhereANearerFrameSeesNothing) {
  FrameOf frame{ramp(5, 0)};
  const Rig& rig{frame.vehicle.rig};
  const auto seen_without = [&rig](const HeightField& height, double begin_m, double end_m) {
    Image<float> disparity{disparity_of(rig, height)};
    const double focal_baseline{rig.focal_px * rig.baseline_m};
    for (float& d : disparity)
      if (d < focal_baseline / begin_m && d > focal_baseline / end_m) d = 0;
    return disparity;
  };
  EXPECT_EQ(frame.filtered_at(5), 0);
  frame.see(seen_without(ramp(5, 0), 4, 6));
  EXPECT_EQ(frame.filtered_at(5), 0) << "not from nearer";
  frame.pose = {1, 0, 0};
  const auto box = [](float x, float) { return x > 2.7f && x < 3 ? 1.0f : 0.0f; };
  frame.see(seen_without(box, 3, 5));
  EXPECT_EQ(frame.filtered_at(4), 0) << "behind an obstacle";
  frame.see(seen_without(ramp(5, 0), 0.1, 5));
  EXPECT_EQ(frame.filtered_at(4), 0) << "no ground before it: a mask, or glare";
  frame.see(seen_without(ramp(5, 0), 3, 5));
  EXPECT_EQ(frame.filtered_at(4), 0.5f);
  EXPECT_EQ(frame.witness_at(4), CellWitness::of(Witness::passable));
  frame.see(disparity_of(rig, ramp(5, 0)));
  EXPECT_EQ(frame.filtered_at(4), 0) << "ground after all";
}

TEST(Witness, MayBeAnotherSource) {
  FrameOf frame{ramp(5, 0)};
  const auto near = [](Point2 at) { return at.x < 2; };
  EXPECT_EQ(frame.filtered_at(1, true, near), 0);
  EXPECT_EQ(frame.witness_at(1), CellWitness::of(Witness::source));
  EXPECT_EQ(frame.filtered_at(1, false, near), 0) << "whatever becomes of the frame";
}

// Equations (4), (5) and (7) of docs/terrain.md.
TEST(SpeedLimit, StopsWithinTheRangeOfHazards) {
  FrameOf frame{ramp(5, 0)};
  const Rig& rig{frame.vehicle.rig};
  const auto expect_range = [&](bool is_usable, double range_m, SpeedReason reason) {
    frame.terrain.limit_speed(is_usable, std::numeric_limits<double>::infinity(), frame.result);
    const double speed{frame.result.speed_limit_mps};
    EXPECT_NEAR(speed * 0.3 + speed * speed / (2 * 2), range_m, 1e-3);
    EXPECT_EQ(frame.result.speed_limit_reason, reason);
  };
  const double step_m{0.15};
  expect_range(true, rig.focal_px * rig.baseline_m * step_m / (3 * rig.camera_height_m + step_m), SpeedReason::drops);
  expect_range(false, 0, SpeedReason::frame);
}

TEST(Witness, AgesInPowersOfTwo) {
  for (const auto& [age_s, up_to_s] :
       {std::pair{0.0f, 0.0f}, {0.01f, 0.125f}, {0.125f, 0.125f}, {0.13f, 0.25f}, {0.9f, 1.0f}, {9.0f, 16.0f}}) {
    const CellWitness witness{CellWitness::of(Witness::memory, age_s)};
    EXPECT_EQ(witness.age_s(), up_to_s) << age_s;
    EXPECT_EQ(CellWitness{witness.byte}, witness);
    EXPECT_EQ(witness.kind(), Witness::memory);
  }
  EXPECT_EQ((CellWitness::of(Witness::memory, 1e9f)).byte >> 4, 15);
}

}  // namespace
}  // namespace stereogrid::test

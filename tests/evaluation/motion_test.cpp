// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/evaluation/motion.hpp"
#include <gmock/gmock.h>
#include <cmath>
#include "stereogrid/evaluation/tracking.hpp"
#include "support.hpp"

namespace stereogrid::evaluation::testing {
namespace {

using ::testing::ElementsAre;

/// A street of 20 × 10 metre cells, frame after frame 0.1 s apart.
class Street {
 public:
  Street() {
    truth_.state = {20, 10, static_cast<std::uint8_t>(TruthCell::seen_free)};
    truth_.occupied = {20, 10};
    truth_.owner = {20, 10};
    truth_.velocity_x = {20, 10};
    truth_.velocity_y = {20, 10};
  }

  FrameTruth& truth() { return truth_; }
  Image<float>& occupancy() { return occupancy_; }
  std::vector<Obstacle>& obstacles() { return obstacles_; }
  void set_velocity(int ix, int iy, float x, float y) {
    vx_(ix, iy) = x;
    vy_(ix, iy) = y;
  }
  /// Object `id` stands on the cell; `seen`, or hidden behind something.
  void put(std::int32_t id, int ix, int iy, float vx, bool seen = true) {
    truth_.state(ix, iy) = static_cast<std::uint8_t>(seen ? TruthCell::seen_occupied : TruthCell::hidden);
    truth_.occupied(ix, iy) = 1;
    truth_.owner(ix, iy) = id;
    truth_.velocity_x(ix, iy) = vx;
  }
  void clear(int ix, int iy) {
    truth_.state(ix, iy) = static_cast<std::uint8_t>(TruthCell::seen_free);
    truth_.occupied(ix, iy) = 0;
    truth_.owner(ix, iy) = 0;
    truth_.velocity_x(ix, iy) = 0;
  }
  void set_objects(std::vector<TruthObject> objects) { truth_.objects = std::move(objects); }

  template <class Score>
  void show(Score& score) {
    score.add(MotionFrame{truth_, truth_grid_, rig_, truth_grid_.geometry, occupancy_.view(), vx_.view(), vy_.view(),
                          obstacles_});
    truth_.stamp_ns += 100'000'000;
  }

 private:
  FrameTruth truth_;
  TruthGrid truth_grid_{{0, -5, 1, 20, 10}, 0.15, 1.8};
  Rig rig_{small_rig()};
  Image<float> occupancy_{20, 10, 0.1F};
  Image<float> vx_{20, 10};
  Image<float> vy_{20, 10};
  std::vector<Obstacle> obstacles_;
};

TruthObject object(std::int64_t id, double x, double y, double vx, double vy, std::int64_t pixels) {
  TruthObject o;
  o.id = id;
  o.world_from_object = {x, y, 0};
  o.vx_mps = vx;
  o.vy_mps = vy;
  o.pixels = pixels;
  return o;
}

Obstacle obstacle(double x, double y, double vx, double vy, bool confirmed = true, std::int64_t id = 1) {
  Obstacle o;
  o.id = id;
  o.x_m = x;
  o.y_m = y;
  o.vx_mps = vx;
  o.vy_mps = vy;
  o.confirmed = confirmed;
  return o;
}

TEST(Motion, OfObjectsFound) {
  Street street;
  street.set_objects({object(1, 5, 1, 3, 4, 500), object(2, 15, -2, 0, 2, 500), object(3, 8, 0, 0, 0, 500)});
  street.obstacles() = {obstacle(5.5, 1, 3, 3), obstacle(15, -2, 0, 2, false)};
  MotionScores scores;
  for (int i{0}; i < 11; ++i) street.show(scores);  // the last one is a second after the first
  const MotionSummary summary(scores.summary());
  EXPECT_EQ(summary.sightings, 2U);
  EXPECT_EQ(summary.found, 1U);  // the other is not confirmed
  EXPECT_NEAR(summary.velocity_error_mps, 1, 1e-9);
  EXPECT_NEAR(summary.speed_error_mps, 5 - std::hypot(3, 3), 1e-9);
  EXPECT_NEAR(summary.direction_error_deg, (std::atan2(4, 3) - std::atan2(3, 3)) * 180 / M_PI, 1e-9);
}

TEST(Motion, TurnsVelocitiesIntoTheVehicleFrame) {
  Street street;
  street.truth().ego.world_from_vehicle = {0, 0, M_PI / 2};
  street.set_objects({object(1, 0, 5, 0, 3, 500)});  // 5 m ahead, going away
  street.obstacles() = {obstacle(5, 0, 3, 0)};
  MotionScores scores;
  for (int i{0}; i < 11; ++i) street.show(scores);
  EXPECT_NEAR(scores.summary().velocity_error_mps, 0, 1e-9);
}

TEST(Motion, OfCells) {
  Street street;
  street.put(1, 6, 5, 4);  // moves at 4 m/s
  street.occupancy()(6, 5) = 0.8F;
  street.set_velocity(6, 5, 3, 0);
  street.put(2, 8, 5, 0);  // stands, seems to move
  street.occupancy()(8, 5) = 0.8F;
  street.set_velocity(8, 5, 0, 2);
  street.put(2, 9, 5, 0);  // stands
  street.occupancy()(9, 5) = 0.8F;
  MotionScores scores;
  for (int i{0}; i < 11; ++i) street.show(scores);
  const MotionSummary summary(scores.summary());
  EXPECT_EQ(summary.moving_cells, 1U);
  EXPECT_NEAR(summary.cell_velocity_error_mps, 1, 1e-6);
  EXPECT_EQ(summary.static_cells, 22U);
  EXPECT_NEAR(summary.static_moving, 0.5, 1e-9);
}

TEST(Identities, SwitchesAreCountedOnce) {
  Street street;
  Identities identities;
  street.set_objects({object(1, 5, 1, 3, 0, 500)});
  const auto show = [&](std::vector<Obstacle> obstacles) {
    street.obstacles() = std::move(obstacles);
    street.show(identities);
    return identities.switches();
  };
  EXPECT_EQ(show({obstacle(5, 1, 3, 0, true, 7)}), 0U);
  EXPECT_EQ(show({}), 0U) << "lost";
  EXPECT_EQ(show({obstacle(5, 1, 3, 0, false, 8)}), 0U) << "not confirmed";
  EXPECT_EQ(show({obstacle(5, 1, 3, 0, true, 8), obstacle(6.5, 1, 3, 0, true, 7)}), 0U) << "7 is still there";
  EXPECT_EQ(show({obstacle(5, 1, 3, 0, true, 8), obstacle(7.5, 1, 3, 0, true, 7)}), 1U);
  EXPECT_EQ(show({obstacle(5, 1, 3, 0, true, 8)}), 1U);
  EXPECT_EQ(show({obstacle(5, 1, 3, 0, true, 7)}), 2U);
}

TEST(Identities, OfWhatStands) {
  Street street;
  Identities identities;
  street.set_objects({object(1, 5, 1, 3, 0, 500), object(2, 15, 0, 0, 0, 500)});
  street.obstacles() = {obstacle(7, 1, 3, 0), obstacle(9, 1, 0, 0.9), obstacle(15, 0, 1, 1),
                        obstacle(15, 2, 5, 0, false)};
  street.show(identities);
  EXPECT_EQ(identities.standing(), 2U) << "one is near the mover, one not confirmed";
  EXPECT_EQ(identities.standing_with_speed(), 1U);
}

TEST(Ghosts, FadeFromWhenTheirPlaceIsSeenFree) {
  Street street;
  GhostTimes ghosts;
  street.put(1, 6, 5, 4);
  street.occupancy()(6, 5) = 0.9F;
  street.put(1, 7, 5, 4);
  street.occupancy()(7, 5) = 0.2F;  // never occupied: no ghost
  street.show(ghosts);
  street.clear(6, 5);
  street.clear(7, 5);
  street.truth().state(6, 5) = static_cast<std::uint8_t>(TruthCell::hidden);
  street.show(ghosts);  // left, but not seen yet
  street.truth().state(6, 5) = static_cast<std::uint8_t>(TruthCell::seen_free);
  street.show(ghosts);  // seen free
  street.show(ghosts);
  street.occupancy()(6, 5) = 0.29F;
  street.show(ghosts);  // 0.2 s later: gone
  EXPECT_THAT(ghosts.seconds(), ElementsAre(::testing::DoubleNear(0.2, 1e-9)));
  EXPECT_EQ(ghosts.gone_within_half_second(), 1);
}

TEST(Ghosts, ThatStayCountToo) {
  Street street;
  GhostTimes ghosts;
  street.put(1, 6, 5, 4);
  street.occupancy()(6, 5) = 0.9F;
  street.show(ghosts);
  street.clear(6, 5);
  for (int i{0}; i < 4; ++i) street.show(ghosts);
  EXPECT_TRUE(std::isnan(ghosts.gone_within_half_second())) << "watched for 0.3 s only";
  for (int i{0}; i < 5; ++i) street.show(ghosts);
  EXPECT_THAT(ghosts.seconds(), ElementsAre(::testing::DoubleNear(0.8, 1e-9)));
  EXPECT_EQ(ghosts.gone_within_half_second(), 0);
}

TEST(Ghosts, AreFollowedWhileTheVehicleDrives) {
  Street street;
  GhostTimes ghosts;
  street.put(1, 6, 5, 4);
  street.occupancy()(6, 5) = 0.9F;
  street.show(ghosts);
  street.clear(6, 5);
  street.truth().ego.world_from_vehicle.x_m = 2;  // the place is now cell 4
  street.occupancy().fill(0.1F);
  street.occupancy()(4, 5) = 0.9F;
  street.show(ghosts);
  street.show(ghosts);
  EXPECT_THAT(ghosts.seconds(), ElementsAre(::testing::DoubleNear(0.1, 1e-9)));
}

TEST(Hidden, ObjectsSurviveAsLongAsTheirCells) {
  Street street;
  HiddenSurvival hidden;
  street.put(1, 6, 5, 1);
  street.set_objects({object(1, 6.5, 0.5, 1, 0, 500)});
  street.occupancy()(6, 5) = 0.9F;
  street.show(hidden);
  EXPECT_TRUE(hidden.episodes().empty());
  street.put(1, 6, 5, 1, false);
  street.set_objects({object(1, 6.5, 0.5, 1, 0, 0)});
  for (const float p : {0.8F, 0.6F, 0.5F, 0.4F, 0.6F}) {
    street.occupancy()(6, 5) = p;
    street.show(hidden);
  }
  const auto episodes(hidden.episodes());
  ASSERT_EQ(episodes.size(), 1U);
  EXPECT_NEAR(episodes[0].hidden_s, 0.4, 1e-9);
  EXPECT_NEAR(episodes[0].survived_s, 0.3, 1e-9);
  EXPECT_EQ(episodes[0].frames, 5U);
  EXPECT_EQ(episodes[0].alive, 4U);
}

TEST(Hidden, IsNotWhatWasNeverSeenOrIsBesideTheImage) {
  Street street;
  HiddenSurvival hidden;
  street.put(1, 6, 5, 1, false);
  street.put(2, 2, 9, 1, false);
  street.set_objects({object(1, 6.5, 0.5, 1, 0, 0), object(2, 2.5, 4.5, 1, 0, 500)});
  street.show(hidden);
  street.set_objects({object(1, 6.5, 0.5, 1, 0, 0), object(2, 2.5, 4.5, 1, 0, 0)});
  street.show(hidden);
  EXPECT_TRUE(hidden.episodes().empty());
}

constexpr double no{TrackingFrame::no_match};

TrackingFrame frame(std::vector<std::int64_t> objects, const std::vector<std::int64_t>& hypotheses,
                    std::vector<double> distances) {
  TrackingFrame made{std::move(objects), {}, std::move(distances)};
  for (const std::int64_t id : hypotheses) made.hypotheses.push_back({id, false});
  return made;
}

TEST(Tracking, OfAPerfectTracker) {
  TrackingScores scores;
  for (int i{0}; i < 3; ++i) scores.add(frame({1, 2}, {20, 10}, {no, 0.5, 0.25, no}));
  const TrackingSummary s(scores.summary());
  EXPECT_EQ(s.tracks, 2U);
  EXPECT_EQ(s.objects, 6U);
  EXPECT_EQ(s.matches, 6U);
  EXPECT_EQ(s.mostly_tracked, 2U);
  EXPECT_EQ(s.mostly_lost, 0U);
  EXPECT_EQ(s.mota, 1);
  EXPECT_EQ(s.motp, 0.375);
  EXPECT_EQ(s.idf1, 1);
}

TEST(Tracking, CountsWhatNothingBelongsTo) {
  TrackingScores scores;
  scores.add(frame({1, 2}, {10, 11, 12}, {0, no, no, no, no, no}));  // a miss, two false positives
  scores.add(frame({1, 2}, {}, {}));                                 // two misses
  TrackingFrame last{frame({}, {13, 14}, {})};
  last.hypotheses[1].ignored = true;
  scores.add(last);  // a false positive
  const TrackingSummary s(scores.summary());
  EXPECT_EQ(s.misses, 3U);
  EXPECT_EQ(s.false_positives, 3U);
  EXPECT_EQ(s.mota, 1 - 6.0 / 4);
  EXPECT_EQ(s.id_true_positives, 1U);
  EXPECT_EQ(s.id_false_positives, 3U);
  EXPECT_EQ(s.id_misses, 3U);
  EXPECT_EQ(s.idf1, 2.0 / (2 + 3 + 3));
  EXPECT_EQ(s.mostly_lost, 1U);
}

TEST(Tracking, CountsSwitchesAndInterruptions) {
  TrackingScores scores;
  // found as 10 10 – 10 11 – 11, then not to be found
  for (const std::int64_t id : {10, 10, 0, 10, 11, 0, 11}) {
    scores.add(id == 0 ? frame({1}, {}, {}) : frame({1}, {id}, {0}));
  }
  const TrackingSummary s(scores.summary());
  EXPECT_EQ(s.id_switches, 1U);
  EXPECT_EQ(s.fragmentations, 2U);
  EXPECT_EQ(s.matches, 5U);
  EXPECT_DOUBLE_EQ(s.mota, 1 - (2.0 + 0 + 1) / 7);
  EXPECT_EQ(s.id_true_positives, 3U);
  EXPECT_DOUBLE_EQ(s.idf1, 2.0 * 3 / (7 + 5));
  EXPECT_DOUBLE_EQ(s.id_precision, 3.0 / 5);
  EXPECT_DOUBLE_EQ(s.id_recall, 3.0 / 7);
}

TEST(Tracking, KeepsAMatchThatStillHolds) {
  TrackingScores scores;
  scores.add(frame({1}, {10}, {0.1}));
  const auto matches{scores.add(frame({1}, {11, 10}, {0.1, 0.9}))};  // 11 is nearer now
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].hypothesis, 1U);
  EXPECT_EQ(scores.summary().id_switches, 0U);
  EXPECT_EQ(scores.summary().false_positives, 1U);
  scores.add(frame({1}, {11, 10}, {0.1, no}));
  EXPECT_EQ(scores.summary().id_switches, 1U);
}

TEST(Tracking, MatchesAsManyAsCanBe) {
  TrackingScores scores;
  // the nearest pair first would leave object 2 alone
  EXPECT_EQ(scores.add(frame({1, 2}, {10, 11}, {0.1, 1, 0.2, no})).size(), 2U);
  EXPECT_DOUBLE_EQ(scores.summary().motp, 0.6);
  TrackingScores others;
  others.add(frame({1, 2, 3}, {10, 11, 12}, {4, 1, 3, 2, 0, 5, 3, 2, 2}));
  EXPECT_DOUBLE_EQ(others.summary().motp, 5.0 / 3);  // 1 + 2 + 2
}

TEST(Tracking, OneHypothesisStandsForOneObjectOfTheDrive) {
  TrackingScores scores;
  // 10 is with 1 for two frames and with 2 for three
  for (int i{0}; i < 2; ++i) scores.add(frame({1, 2}, {10}, {0, no}));
  for (int i{0}; i < 3; ++i) scores.add(frame({1, 2}, {10}, {no, 0}));
  const TrackingSummary s(scores.summary());
  EXPECT_EQ(s.id_switches, 0U);
  EXPECT_EQ(s.matches, 5U);
  EXPECT_EQ(s.id_true_positives, 3U);
  EXPECT_DOUBLE_EQ(s.idf1, 2.0 * 3 / (10 + 5));
}

TEST(Tracking, OfNothing) {
  const TrackingSummary s(TrackingScores{}.summary());
  EXPECT_TRUE(std::isnan(s.mota));
  EXPECT_TRUE(std::isnan(s.idf1));
  EXPECT_EQ(s.objects, 0U);
}

}  // namespace
}  // namespace stereogrid::evaluation::testing

// SPDX-License-Identifier: Apache-2.0
#include "matching/tops/tops.hpp"

#include "matching_run.hpp"

namespace stereogrid::test {
namespace {

constexpr int top_first_v{40};
constexpr int top_end_v{44};
constexpr int top_disparity{24};
constexpr Size topped_size{203, 81};
constexpr RoadPlane below_top{8, 0, 0.15, 100, 40};

// The road, and over it a top from column 60 to 160, and so above and below it.
Pair topped_pair() {
  const Texture ground{3};
  const Texture board{4};
  Pair pair{Image<std::uint8_t>{topped_size.width, topped_size.height},
            Image<std::uint8_t>{topped_size.width, topped_size.height}};
  for (const auto [u, v] : raster(topped_size.width, topped_size.height)) {
    const auto grey = [&, row = v](double column, int least, int end) {
      const bool is_top{row >= top_first_v && row < top_end_v && column >= least && column < end};
      return is_top ? board.at(column, row) : -1;
    };
    const double on_left{grey(u, 60, 160)};
    const double on_right{grey(u + top_disparity, 60, 160)};
    pair.left(u, v) = static_cast<std::uint8_t>(on_left < 0 ? ground.at(u, v) : on_left);
    pair.right(u, v) = static_cast<std::uint8_t>(on_right < 0 ? ground.at(u + below_top.disparity(u, v), v) : on_right);
  }
  return pair;
}

double share_of_top(bool thin_tops) {
  MatchingConfig config{permissive_config()};
  config.thin_tops = thin_tops;
  const Pair pair{topped_pair()};
  expect_equal_to_reference(pair, below_top, config, {1, 3});
  Cpu cpu{1};
  const MatchRun run{cpu, pair.left, pair.right, below_top, config};
  int right{0};
  for (const auto [u, v] : raster(70, 150, top_first_v, top_end_v)) {
    right += std::abs(run.matches.obstacle(u, v) - top_disparity) < 1 ? 1 : 0;
  }
  return right / static_cast<double>(80 * (top_end_v - top_first_v));
}

TEST(ThinTops, AreFoundWhereWindowsSeeTheGroundBehind) {
  EXPECT_LT(share_of_top(false), 0.6);
  EXPECT_GT(share_of_top(true), 0.85);
}

}  // namespace
}  // namespace stereogrid::test

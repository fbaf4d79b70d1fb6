// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <vector>

#include "matching/matching.hpp"

namespace stereogrid {
namespace {

template <class T>
T at_clamped(View<const T> image, int u, int v) {
  return image(std::clamp(u, 0, image.width - 1), std::clamp(v, 0, image.height - 1));
}

template <class Descriptor, class Describe>
Image<Descriptor> described(View<const std::uint8_t> grey, const Describe& describe) {
  Image<Descriptor> descriptors{grey.width, grey.height};
  for (int v{0}; v < grey.height; ++v) {
    for (int u{0}; u < grey.width; ++u) {
      descriptors(u, v) = describe([&](int i, int j) { return at_clamped(grey, u + i, v + j); });
    }
  }
  return descriptors;
}

int window_cost(View<const std::uint8_t> left, View<const std::uint8_t> right, int u, int v, int shift, int half) {
  int sum{0};
  for (int j{-half}; j <= half; ++j) {
    const int row{std::clamp(v + j, 0, left.height - 1)};
    for (int i{-half}; i <= half; ++i) {
      // the window's pixels outside the left image repeat the border; so do the right image's
      const int column{std::clamp(u + i, 0, left.width - 1)};
      const int right_column{std::clamp(column - shift, 0, right.width - 1)};
      sum += std::popcount(static_cast<std::uint8_t>(left(column, row) ^ right(right_column, row)));
    }
  }
  return sum;
}

Candidate best_of(View<const std::uint8_t> left, View<const std::uint8_t> right, int u, int v, Shifts shifts,
                  const MatchingConfig& config) {
  std::vector<std::uint16_t> costs;
  for (int k{0}; k < shifts.count; ++k) {
    costs.push_back(static_cast<std::uint16_t>(window_cost(left, right, u, v, shifts.first + k, config.window_px / 2)));
  }
  const auto least = std::min_element(costs.begin(), costs.end());
  const int best{static_cast<int>(least - costs.begin())};
  const int rival_cost{highest_rival(*least, uniqueness_1024(config))};
  bool has_rivals{false};
  for (int k{0}; k < shifts.count; ++k) {
    has_rivals = has_rivals || (std::abs(k - best) > 1 && costs[static_cast<std::size_t>(k)] <= rival_cost);
  }
  const bool inside{best > 0 && best < shifts.count - 1};
  return {*least, has_rivals, inside ? least[-1] : *least, inside ? least[1] : *least,
          static_cast<std::int16_t>(shifts.first + best)};
}

void correlate(View<const std::uint8_t> left, View<const std::uint8_t> right, View<const std::uint8_t> sheared,
               const MatchingConfig& config, CandidateSink& sink) {
  const unsigned compared{(1u << compared_bits(config.window_px)) - 1};
  const auto describe = [&](const auto& pixel) { return static_cast<std::uint8_t>(short_census(pixel) & compared); };
  const auto census_left = described<std::uint8_t>(left, describe);
  const auto census_right = described<std::uint8_t>(right, describe);
  const auto census_sheared = described<std::uint8_t>(sheared, describe);
  RowCandidates row{left.width};
  for (int v{0}; v < left.height; ++v) {
    for (int u{0}; u < left.width; ++u) {
      row.upright.set(u, best_of(census_left.view(), census_right.view(), u, v, upright_shifts(config), config));
      row.level.set(u, best_of(census_left.view(), census_sheared.view(), u, v, road_shifts, config));
    }
    sink.take(v, row);
  }
}

bool is_textured(View<const std::uint8_t> left, int u, int v, const MatchingConfig& config) {
  const int half{config.window_px / 2};
  int sum{0};
  for (int j{-half}; j <= half; ++j) {
    for (int i{-half}; i <= half; ++i) {
      const int column{std::clamp(u + i, 0, left.width - 1)};
      sum += std::abs(at_clamped(left, column + 1, v + j) - at_clamped(left, column - 1, v + j));
    }
  }
  return sum >= least_texture(config);
}

// classify_row, a pixel at a time.
class Decider final : public CandidateSink {
 public:
  Decider(View<const std::uint8_t> left, const RoadPlane& plane, const MatchingConfig& config, Matches& matches)
      : left_{left}, plane_{plane}, config_{config}, matches_{matches} {}

  void take(int v, RowCandidates& candidates) override {
    const RoadRow road{road_row(plane_, v)};
    std::vector<Winner> winners;
    std::vector<int> claimant(static_cast<std::size_t>(left_.width), -1);
    const auto winner = [&](int u) -> const Winner& { return winners[static_cast<std::size_t>(u)]; };
    // cost first, then the smaller disparity
    const auto rank = [&](int u) {
      return static_cast<std::uint32_t>(winner(u).cost) << 16 | static_cast<std::uint16_t>(winner(u).whole);
    };
    for (int u{0}; u < left_.width; ++u) {
      winners.push_back(winner_of(candidates.upright.at(u), candidates.level.at(u), road.at(u), config_.disparities,
                                  config_.subpixel, confidence_model(config_)));
      const int right_u{u - winner(u).whole};
      if (right_u < 0 || right_u >= left_.width) continue;
      int& first{claimant[static_cast<std::size_t>(right_u)]};
      if (first < 0 || rank(u) < rank(first)) first = u;
    }
    for (int u{0}; u < left_.width; ++u) {
      const int right_u{u - winner(u).whole};
      const bool consistent{right_u >= 0 && right_u < left_.width &&
                            std::abs(winner(claimant[static_cast<std::size_t>(right_u)]).whole - winner(u).whole) <=
                                config_.left_right_px};
      const bool textured{is_textured(left_, u, v, config_)};
      const bool accepted{consistent && winner(u).is_plausible && textured};
      const bool similar{winner(u).cost <= confidence_model(config_).ambiguous_cost_limit};
      const bool ambiguous{similar && textured && !winner(u).is_road && winner(u).whole > 0};
      const float unmatched{ambiguous ? ambiguous_px : 0};
      matches_.road(u, v) = accepted && winner(u).is_road ? winner(u).disparity : 0;
      matches_.obstacle(u, v) = accepted && !winner(u).is_road ? winner(u).disparity : unmatched;
      matches_.confidence(u, v) = accepted ? single_numbers::confidence_of(winner(u).evidence) : 0;
    }
  }

 private:
  View<const std::uint8_t> left_;
  const RoadPlane& plane_;
  const MatchingConfig& config_;
  Matches& matches_;
};

}  // namespace

void find_candidates(Reference& /*reference*/, View<const std::uint8_t> left, View<const std::uint8_t> right,
                     const RoadPlane& plane, const MatchingConfig& config, MatchingWorkspace& space,
                     CandidateSink& sink) {
  for (int v{0}; v < left.height; ++v) {
    space.right.copy_row(v, right.row(v));
    for (int u{0}; u < left.width; ++u) {
      space.sheared.row(v)[u] = sheared(space.right.row(v), left.width, u, road_row(plane, v));
    }
  }
  correlate(left, right, space.sheared.view(), config, sink);
}

void match(Reference& reference, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
           const MatchingConfig& config, MatchingWorkspace& space, Matches& matches) {
  Decider decider{left, plane, config, matches};
  find_candidates(reference, left, right, plane, config, space, decider);
  space.speckles.remove(speckle_sizes(config), matches);
  if (!has_tops(config)) return;
  const unsigned compared{(1u << compared_bits(config.window_px)) - 1};
  const auto describe = [&](const auto& pixel) { return static_cast<std::uint8_t>(short_census(pixel) & compared); };
  const auto of_left = described<std::uint8_t>(left, describe);
  const auto of_right = described<std::uint8_t>(right, describe);
  for (int v{0}; v < left.height; ++v) {
    space.short_left.copy_row(v, of_left.row(v));
    std::reverse_copy(of_right.row(v), of_right.row(v) + left.width, space.short_right_reversed.row(v));
    space.short_right_reversed.repeat_border(v);
  }
  add_tops(reference, {space.short_left, space.short_right_reversed}, plane, top_rules(config), space.tops, matches);
}

}  // namespace stereogrid

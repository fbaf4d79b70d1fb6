// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <array>
#include <cstdlib>
#include <functional>

#include "backend/reference.hpp"
#include "matching/checks/simd.hpp"
#include "matching/correlation/simd.hpp"
#include "matching/matching.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{32};

std::uint8_t* aligned(std::uint8_t* memory) {
  constexpr std::uintptr_t alignment{64};
  return memory + (alignment - reinterpret_cast<std::uintptr_t>(memory) % alignment) % alignment;
}

using CensusOfRow = void (*)(const std::uint8_t* const*, int, int, std::uint8_t*);

void short_census_rows(CensusOfRow census_of_row, const Padded<std::uint8_t>& grey, int bits,
                       Padded<std::uint8_t>& descriptors, int begin, int end) {
  for (int v{begin}; v < end; ++v) {
    std::array<const std::uint8_t*, 2 * short_census_half_v + 1> window{};
    for (int j{-short_census_half_v}; j <= short_census_half_v; ++j) {
      window[static_cast<std::size_t>(j + short_census_half_v)] = grey.clamped_row(v + j);
    }
    census_of_row(window.data(), grey.width(), bits, descriptors.row(v));
    descriptors.repeat_border(v);
  }
}

// Grey images with borders, the right one also as the road hypothesis sees it, and where there is texture.
void prepare(Cpu& cpu, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
             const MatchingConfig& config, MatchingWorkspace& space) {
  cpu.for_ranges(left.height, rows_grain, [&](int begin, int end) {
    for (int v{begin}; v < end; ++v) {
      space.left.copy_row(v, left.row(v));
      space.right.copy_row(v, right.row(v));
      shear_row(space.right.row(v), left.width, road_row(plane, v), space.sheared.row(v));
      space.sheared.repeat_border(v);
    }
  });
  const int least{least_texture(config)};
  cpu.for_parts(left.height, cpu.threads(), [&](int part, int begin, int end) {
    texture_rows(space.left, config.window_px / 2, least, begin, end, space.textures[static_cast<std::size_t>(part)],
                 space.textured);
  });
}

std::size_t band_memory(const MatchingConfig& config, const MatchingWorkspace& space) {
  return correlate_memory(space.left.width(), upright_shifts(config), config.window_px / 2);
}

void correlate(Cpu& cpu, const RoadPlane& plane, const MatchingConfig& config, MatchingWorkspace& space,
               CandidateSink& sink) {
  const int height{space.left.height()};
  const int bits{compared_bits(config.window_px)};
  cpu.for_ranges(height, rows_grain, [&](int begin, int end) {
    short_census_rows(short_census_row, space.left, bits, space.short_left, begin, end);
    short_census_rows(short_census_reversed, space.right, bits, space.short_right_reversed, begin, end);
    short_census_rows(short_census_row, space.sheared, bits, space.short_sheared, begin, end);
  });
  const Shifts upright{upright_shifts(config)};
  const int half{config.window_px / 2};
  const std::size_t memory_of_band{band_memory(config, space)};
  const ShortCensus census{space.short_left, space.short_right_reversed, space.short_sheared};
  cpu.for_parts(height, cpu.threads(), [&](int part, int begin, int end) {
    const std::size_t p{static_cast<std::size_t>(part)};
    correlate_band({census, upright, half, uniqueness_1024(config), confidence_model(config).cost_limit, plane, begin,
                    end, aligned(space.memory.data()) + p * memory_of_band, &space.rows[p], &sink});
  });
}

class Decider final : public CandidateSink {
 public:
  Decider(const RoadPlane& plane, const MatchingConfig& config, MatchingWorkspace& space, Matches& matches)
      : plane_{plane}, config_{config}, space_{space}, matches_{matches} {}

  void take(int v, RowCandidates& candidates) override {
    // the working memory of the band whose candidates these are
    const std::size_t band{static_cast<std::size_t>(&candidates - space_.rows.data())};
    classify_row({candidates, road_row(plane_, v), space_.textured.row(v), matches_.road.width(), config_.disparities,
                  config_.left_right_px, config_.subpixel, confidence_model(config_), matches_.obstacle.row(v),
                  matches_.road.row(v), matches_.confidence.row(v)},
                 space_.decisions[band]);
  }

 private:
  const RoadPlane& plane_;
  const MatchingConfig& config_;
  MatchingWorkspace& space_;
  Matches& matches_;
};

void remove_speckles(Cpu& cpu, const SpeckleSizes& smallest, Speckles& speckles, Matches& matches) {
  if (smallest.remove_nothing()) return;
  const int height{matches.road.height()};
  cpu.for_parts(height, cpu.threads(),
                [&](int band, int begin, int end) { speckles.find_patches(band, begin, end, matches); });
  speckles.join_bands(matches);
  cpu.for_parts(height, cpu.threads(), [&](int band, int, int) { speckles.remove_small(band, smallest, matches); });
}

void add_tops(Cpu& cpu, const RoadPlane& plane, const MatchingConfig& config, MatchingWorkspace& space,
              Matches& matches) {
  const TopImages images{space.short_left, space.short_right_reversed};
  const TopRules rules{top_rules(config)};
  const std::size_t memory_of_band{band_memory(config, space)};
  const int pairs{space.tops.height()};
  cpu.for_parts(pairs, cpu.threads(), [&](int part, int begin, int end) {
    std::uint8_t* memory{aligned(space.memory.data()) + static_cast<std::size_t>(part) * memory_of_band};
    const auto costs_of_row = [&](int v) { return top_costs(images, v, rules, memory); };
    find_top_rows(begin, end, plane, rules, matches, space.tops, std::cref(costs_of_row));  // allocates nothing
  });
  cpu.for_parts(pairs, cpu.threads(), [&](int, int begin, int end) { put_top_rows(begin, end, space.tops, matches); });
}

// False if Highway has no vectors and the correlation is not compiled; the slow reference is used then.
bool has_vectors() {
  return correlate_target() != "SCALAR";
}

}  // namespace

void make_room(Cpu& cpu, const MatchingConfig& config, MatchingWorkspace& space) {
  if (!has_vectors()) return;
  const std::size_t bytes{64 + static_cast<std::size_t>(cpu.threads()) * band_memory(config, space)};
  if (space.memory.size() < bytes) space.memory.resize(bytes);
}

void find_candidates(Cpu& cpu, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
                     const MatchingConfig& config, MatchingWorkspace& space, CandidateSink& sink) {
  if (!has_vectors()) {
    Reference reference;
    return find_candidates(reference, left, right, plane, config, space, sink);
  }
  make_room(cpu, config, space);
  prepare(cpu, left, right, plane, config, space);
  correlate(cpu, plane, config, space, sink);
}

void match(Cpu& cpu, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
           const MatchingConfig& config, MatchingWorkspace& space, Matches& matches) {
  if (!has_vectors()) {
    Reference reference;
    return match(reference, left, right, plane, config, space, matches);
  }
  Decider decider{plane, config, space, matches};
  find_candidates(cpu, left, right, plane, config, space, decider);
  remove_speckles(cpu, speckle_sizes(config), space.speckles, matches);
  if (has_tops(config)) add_tops(cpu, plane, config, space, matches);
}

}  // namespace stereogrid

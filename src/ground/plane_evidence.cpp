// SPDX-License-Identifier: Apache-2.0
#include "ground/plane_evidence.hpp"

#include <numeric>

namespace stereogrid {
namespace {

float sum_of(std::array<float, plane_lanes> lanes) {
  for (std::size_t half{plane_lanes / 2}; half > 0; half /= 2) {
    for (std::size_t i{0}; i < half; ++i) lanes[i] += lanes[i + half];
  }
  return lanes[0];
}

template <std::size_t count, class AddendsOf>
PlaneSums<count> summed(const PlaneSamples& samples, std::span<const float> weights, const AddendsOf& addends_of) {
  PlaneSums<count> all;
  for (std::size_t begin{0}; begin < samples.size(); begin += plane_block) {
    std::array<std::array<float, plane_lanes>, count> lanes{};
    for (std::size_t i{begin}; i < std::min(begin + plane_block, samples.size()); ++i) {
      const PlaneAddends<float, count> addends{
          addends_of(samples.x[i], samples.y[i], samples.disparity[i], weights[i])};
      for (std::size_t k{0}; k < count; ++k) lanes[k][i % plane_lanes] += addends.sums[k];
      all.bins[static_cast<std::size_t>(bin_of(addends.share))] += static_cast<std::uint64_t>(parts_of(addends.weight));
    }
    for (std::size_t k{0}; k < count; ++k) all.sums[k] += sum_of(lanes[k]);
  }
  return all;
}

// The share below which `part` of the weight lies.
double quantile(const std::array<std::uint64_t, share_bins>& bins, double part) {
  const double all{static_cast<double>(std::accumulate(bins.begin(), bins.end(), std::uint64_t{0}))};
  double below{0};
  std::size_t bin{0};
  while (bin + 1 < bins.size() && (below += static_cast<double>(bins[bin])) < part * all) ++bin;
  return (static_cast<double>(bin) + 0.5) / share_bins;
}

}  // namespace

void PlaneSamples::reserve(std::size_t count) {
  for (std::vector<float>* numbers : {&x, &y, &disparity, &weight, &fit_weight}) numbers->reserve(count);
}

void PlaneSamples::resize(std::size_t count) {
  for (std::vector<float>* numbers : {&x, &y, &disparity, &weight, &fit_weight}) numbers->resize(count);
}

void weigh(const Rig& rig, double spacing_px, std::vector<float>& blocks, PlaneSamples& samples) {
  constexpr double least_part{0.25};  // share of a full block: single matches are often wrong
  const int side{block_px(rig)};
  const float per_px{1.0F / static_cast<float>(side)};
  const float across{static_cast<float>(rig.width_px / side + 1)};
  const float first_x{
      static_cast<float>(rig.cx_px + 0.5)};  // half a pixel off the blocks' borders: no rounding matters
  const float first_y{static_cast<float>(rig.cy_px + 0.5)};
  const auto block_of = [&](float from_border) { return static_cast<float>(static_cast<int>(from_border * per_px)); };
  for (std::size_t i{0}; i < samples.size(); ++i)
    samples.weight[i] = block_of(samples.y[i] + first_y) * across + block_of(samples.x[i] + first_x);
  blocks.assign(blocks_of(rig), 0);
  for (const float block : samples.weight) ++blocks[static_cast<std::size_t>(block)];
  const float least{static_cast<float>(least_part * side * side / (spacing_px * spacing_px))};
  for (float& block : blocks) block = 1 / std::max(block, least);
  for (float& block : samples.weight) block = blocks[static_cast<std::size_t>(block)];
}

PlaneHypothesis::PlaneHypothesis(const RoadPlane& plane, const Rig& rig, const PlaneSamples& samples)
    : at_centre{static_cast<float>(plane.at_centre)},
      per_u{static_cast<float>(plane.per_u)},
      per_v{static_cast<float>(plane.per_v)},
      noise_px{samples.noise_px} {
  constexpr double path_heights{0.6};  // half the width of the vehicle's path, in heights of the camera
  const float largest{std::max(expected(samples.first_x, samples.last_y), expected(samples.last_x, samples.last_y))};
  near_px = std::clamp(largest, 1.0F, std::max(samples.disparities - 1, 1.0F));
  const double gz{plane.at_centre / rig.focal_px};
  const double baseline_of_height{std::sqrt(plane.per_u * plane.per_u + plane.per_v * plane.per_v + gz * gz)};
  per_path_px = static_cast<float>(baseline_of_height / path_heights);
}

PlaneSums<support_sums> plain::sum_support(const PlaneHypothesis& plane, const PlaneSamples& samples) {
  return summed<support_sums>(samples, samples.weight, [&](float x, float y, float d, float weight) {
    return support_addends(plane, samples.disparities, x, y, d, weight);
  });
}

PlaneSums<equation_sums> plain::sum_equations(const PlaneHypothesis& plane, const PlaneSamples& samples,
                                              std::span<const float> weights) {
  return summed<equation_sums>(samples, weights, [&](float x, float y, float d, float weight) {
    return equation_addends(plane, samples.disparities, x, y, d, weight);
  });
}

PlaneSupport support_of(const PlaneHypothesis& plane, const PlaneSamples& samples) {
  const auto [sums, bins] = sum_support(plane, samples);
  PlaneSupport support{sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums[6], sums[7]};
  if (support.on > 0) support.depth_ratio = quantile(bins, 0.9) / quantile(bins, 0.1);
  return support;
}

double ring_margin(const PlaneHypothesis& p, const PlaneHypothesis& q, const PlaneSamples& samples) {
  constexpr float ring_part{0.6F};
  const float least_px{ring_part * std::max(p.near_px, q.near_px)};
  double margin{0};
  for (std::size_t i{0}; i < samples.size(); ++i) {
    if (samples.disparity[i] < least_px) continue;
    const float x{samples.x[i]};
    const float y{samples.y[i]};
    const PlaneTerm<float> by_p{term_of(p, samples.disparities, x, y, samples.disparity[i])};
    const PlaneTerm<float> by_q{term_of(q, samples.disparities, x, y, samples.disparity[i])};
    margin += samples.weight[i] * (by_p.weight * by_p.evidence - by_q.weight * by_q.evidence);
  }
  return margin;
}

bool are_in_conflict(const PlaneHypothesis& p, const PlaneHypothesis& q, const PlaneSamples& samples) {
  constexpr float nearest_part{0.4F};
  constexpr float sigmas{3};
  double all{0};
  double apart{0};
  for (std::size_t i{0}; i < samples.size(); ++i) {
    const float e{p.expected(samples.x[i], samples.y[i])};
    if (e < nearest_part * p.near_px) continue;
    const float gap{e - q.expected(samples.x[i], samples.y[i])};
    all += samples.weight[i];
    apart += gap * gap > sigmas * sigmas * variance_of(p, e) ? samples.weight[i] : 0;
  }
  return 2 * apart > all;
}

PlaneEquations equations_of(const PlaneHypothesis& plane, const PlaneSamples& samples, std::span<const float> weights) {
  const auto [sums, bins] = sum_equations(plane, samples, weights);
  const auto [r, rx, ry, one, x, y, xx, xy, yy] = sums;
  const Matrix3 matrix{{{one, x, y}, {x, xx, xy}, {y, xy, yy}}};
  const Vector3 per_number{1, 0.01, 0.01};
  return {carried(diagonal(per_number), matrix), diagonal(per_number) * Vector3{r, rx, ry},
          static_cast<float>(quantile(bins, 0.5)) * deviation_max_px};
}

}  // namespace stereogrid

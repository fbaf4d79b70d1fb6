// SPDX-License-Identifier: Apache-2.0
#include "ground/plane_evidence.hpp"

namespace stereogrid {
namespace {

constexpr std::size_t chunk{64};  // samples whose terms are computed by one vectorised loop

// Terms of some neighbouring samples, computed by one vectorised loop.
struct Terms {
  Terms(const PlaneHypothesis& plane, const PlaneSamples& samples, std::size_t begin)
      : count{std::min(chunk, samples.size() - begin)} {
    const float* const x{samples.x.data() + begin};
    const float* const y{samples.y.data() + begin};
    const float* const d{samples.disparity.data() + begin};
    for (std::size_t i{0}; i < count; ++i) {
      const PlaneTerm term{term_of(plane, samples.disparities, x[i], y[i], d[i])};
      evidence[i] = term.evidence;
      on[i] = term.on;
      precision[i] = term.precision;
      residual[i] = term.residual;
      weight[i] = term.weight;
    }
  }
  [[nodiscard]] PlaneTerm at(std::size_t i) const { return {evidence[i], on[i], precision[i], residual[i], weight[i]}; }

  std::size_t count;
  std::array<float, chunk> evidence, on, precision, residual, weight;
};

// Calls visit(index, term) for every sample, in order.
template <class Visit>
void for_terms(const PlaneHypothesis& plane, const PlaneSamples& samples, const Visit& visit) {
  for (std::size_t begin{0}; begin < samples.size(); begin += chunk) {
    const Terms terms{plane, samples, begin};
    for (std::size_t i{0}; i < terms.count; ++i) visit(begin + i, terms.at(i));
  }
}

// Distribution of numbers in [0, 1].
class Percentiles {
 public:
  void add(float share, double weight) {
    const float bin{share * bins};
    sums_[static_cast<std::size_t>(std::clamp(bin, 0.0F, bins - 1.0F))] += weight;
    total_ += weight;
  }
  [[nodiscard]] double at(double share) const {
    double below{0};
    std::size_t bin{0};
    while (bin + 1 < sums_.size() && (below += sums_[bin]) < share * total_) ++bin;
    return (static_cast<double>(bin) + 0.5) / bins;
  }

 private:
  static constexpr int bins{256};
  std::array<double, bins> sums_{};
  double total_{0};
};

}  // namespace

void PlaneSamples::reserve(std::size_t count) {
  for (std::vector<float>* numbers : {&x, &y, &disparity, &weight, &fit_weight}) numbers->reserve(count);
}

void PlaneSamples::clear() {
  for (std::vector<float>* numbers : {&x, &y, &disparity, &weight, &fit_weight}) numbers->clear();
}

void weigh(const Rig& rig, std::span<const GroundSample> samples, double spacing_px, int last_row, int disparities,
           std::vector<int>& counts, PlaneSamples& out) {
  constexpr double least_part{0.25};  // share of a full block: single matches are often wrong
  const int side{block_px(rig)};
  const int across{rig.width_px / side + 1};
  const auto block_of = [&](const GroundSample& sample) {
    return static_cast<std::size_t>(static_cast<int>(sample.v) / side * across + static_cast<int>(sample.u) / side);
  };
  counts.assign(blocks_of(rig), 0);
  for (const GroundSample& sample : samples) ++counts[block_of(sample)];
  const double full{side * side / (spacing_px * spacing_px)};
  out.clear();
  for (const GroundSample& sample : samples) {
    out.x.push_back(static_cast<float>(sample.u - rig.cx_px));
    out.y.push_back(static_cast<float>(sample.v - rig.cy_px));
    out.disparity.push_back(sample.disparity);
    out.weight.push_back(static_cast<float>(1 / std::max<double>(counts[block_of(sample)], least_part * full)));
  }
  out.fit_weight = out.weight;
  out.first_x = static_cast<float>(-rig.cx_px);
  out.last_x = static_cast<float>(rig.width_px - rig.cx_px);
  out.last_y = static_cast<float>(last_row - rig.cy_px);
  out.disparities = static_cast<float>(disparities);
}

PlaneHypothesis::PlaneHypothesis(const RoadPlane& plane, const Rig& rig, const PlaneSamples& samples)
    : at_centre{static_cast<float>(plane.at_centre)},
      per_u{static_cast<float>(plane.per_u)},
      per_v{static_cast<float>(plane.per_v)},
      noise_px{samples.noise_px} {
  constexpr double path_heights{0.6};  // half the width of the vehicle's path, in heights of the camera
  const float largest{std::max(expected(samples.first_x, samples.last_y), expected(samples.last_x, samples.last_y))};
  near_px = std::clamp(largest, 1.0F, std::max(samples.disparities - 1, 1.0F));
  per_half_px = 2 / near_px;
  const double gz{plane.at_centre / rig.focal_px};
  const double baseline_of_height{std::sqrt(plane.per_u * plane.per_u + plane.per_v * plane.per_v + gz * gz)};
  per_path_px = static_cast<float>(baseline_of_height / path_heights);
}

PlaneEvidence evidence_of(const PlaneHypothesis& plane, const PlaneSamples& samples) {
  PlaneEvidence sum;
  std::array<float, chunk> nats;
  std::array<float, chunk> near;
  for (std::size_t begin{0}; begin < samples.size(); begin += chunk) {
    const std::size_t count{std::min(chunk, samples.size() - begin)};
    const float* const x{samples.x.data() + begin};
    const float* const y{samples.y.data() + begin};
    const float* const d{samples.disparity.data() + begin};
    const float* const w{samples.weight.data() + begin};
    for (std::size_t i{0}; i < count; ++i) {
      const PlaneTerm term{term_of(plane, samples.disparities, x[i], y[i], d[i])};
      nats[i] = w[i] * term.weight * term.evidence;
      near[i] = term.weight >= 1 ? nats[i] : 0.0F;  // weight_of_distance: the nearest half
    }
    for (std::size_t i{0}; i < count; ++i) {
      sum.all += nats[i];
      sum.near += near[i];
    }
  }
  return sum;
}

PlaneSupport support_of(const PlaneHypothesis& plane, const PlaneSamples& samples) {
  constexpr float near_part{0.5F};
  constexpr float ring_part{0.7F};
  PlaneSupport support;
  Percentiles expected;
  for_terms(plane, samples, [&](std::size_t i, const PlaneTerm& term) {
    if (!(term.weight > 0)) return;
    const double weight{samples.weight[i]};
    const float e{samples.disparity[i] - term.residual};
    const bool is_on{term.on > 0.5F};
    support.evidence += weight * term.weight * term.evidence;
    support.on += is_on ? weight * term.weight : 0;
    support.below += !is_on && term.residual < 0 ? weight * term.weight : 0;
    const bool is_near{e >= near_part * plane.near_px};
    support.near_all += is_near ? weight : 0;
    support.near_on += is_near && is_on ? weight : 0;
    const bool is_nearest{e >= ring_part * plane.near_px};
    support.ring_all += is_nearest ? weight : 0;
    support.ring_on += is_nearest && is_on ? weight : 0;
    if (is_on) expected.add(e / plane.near_px, weight);
  });
  if (support.on > 0) support.depth_ratio = expected.at(0.9) / expected.at(0.1);
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
    const PlaneTerm by_p{term_of(p, samples.disparities, x, y, samples.disparity[i])};
    const PlaneTerm by_q{term_of(q, samples.disparities, x, y, samples.disparity[i])};
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
    apart += gap * gap > sigmas * sigmas * variance_of(e, p) ? samples.weight[i] : 0;
  }
  return 2 * apart > all;
}

PlaneEquations equations_of(const PlaneHypothesis& plane, const PlaneSamples& samples, std::span<const float> weights) {
  constexpr float deviation_max_px{2};
  constexpr float nearest_far_px{4};  // farther away, the feet of obstacles have as many samples as ground
  const float least_px{std::min(nearest_far_px, plane.near_px / 4)};
  PlaneEquations sums;
  Percentiles deviations;
  for_terms(plane, samples, [&](std::size_t i, const PlaneTerm& term) {
    if (weights[i] * term.weight == 0 || samples.disparity[i] - term.residual < least_px) return;
    const float deviation{std::abs(term.residual)};
    if (deviation < deviation_max_px) deviations.add(deviation / deviation_max_px, weights[i] * term.weight);
    const double weight{weights[i] * term.weight * term.on * term.precision};
    const double x{samples.x[i] / 100};
    const double y{samples.y[i] / 100};
    const double r{weight * term.residual};
    sums.vector[0] += r;
    sums.vector[1] += r * x;
    sums.vector[2] += r * y;
    sums.matrix[0][0] += weight;
    sums.matrix[1][0] += weight * x;
    sums.matrix[1][1] += weight * x * x;
    sums.matrix[2][0] += weight * y;
    sums.matrix[2][1] += weight * y * x;
    sums.matrix[2][2] += weight * y * y;
  });
  for (int i{0}; i < 3; ++i) {
    for (int j{i + 1}; j < 3; ++j) sums.matrix[i][j] = sums.matrix[j][i];
  }
  sums.deviation_px = static_cast<float>(deviations.at(0.5)) * deviation_max_px;
  return sums;
}

}  // namespace stereogrid

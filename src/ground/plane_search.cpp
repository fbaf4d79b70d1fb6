// SPDX-License-Identifier: Apache-2.0
#include "ground/plane_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace stereogrid {
namespace {

constexpr std::size_t hypotheses_max{1500};
constexpr std::size_t draws_per_hypothesis{6};  // most draws on walls and skies are no ground
constexpr double drawn_share{0.7};              // share of the samples, from the lowest row up
constexpr std::size_t few_samples{250};
constexpr std::size_t some_samples{1000};
constexpr std::size_t rated_again{200};      // hypotheses that `few` rates best
constexpr std::size_t rated_again_near{60};  // others that explain the nearest half best
constexpr std::size_t distinct_max{10};
constexpr std::size_t tried_max{20};  // a steep plane through ground and walls leads out of the bounds
constexpr std::size_t distinct_by_all{7};
constexpr std::size_t finalists{5};  // refined on all samples
constexpr int refining_rounds{12};
constexpr int final_rounds{5};

// Generator of the same numbers on every platform.
class Generator {
 public:
  std::size_t below(std::size_t count) {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<std::size_t>((state_ >> 33) % count);
  }

 private:
  std::uint64_t state_{20120912};
};

// About `count` samples, evenly over the rows.
void thin(const PlaneSamples& from, std::size_t count, Generator& generator, PlaneSamples& to) {
  to.clear();
  to.first_x = from.first_x;
  to.last_x = from.last_x;
  to.last_y = from.last_y;
  to.disparities = from.disparities;
  to.noise_px = from.noise_px;
  const std::size_t stride{std::max<std::size_t>(from.size() / count, 1)};
  for (std::size_t begin{0}; begin + stride <= from.size(); begin += stride) {
    const std::size_t i{begin + generator.below(stride)};
    to.x.push_back(from.x[i]);
    to.y.push_back(from.y[i]);
    to.disparity.push_back(from.disparity[i]);
    to.weight.push_back(from.weight[i] * static_cast<float>(stride));
  }
}

// The line through two samples in v-disparity, or the plane through three.
bool put_through(const PlaneSamples& samples, const std::size_t (&at)[3], bool has_roll, RoadPlane& plane) {
  constexpr float rows_min{5};
  constexpr float area_min{2000};  // px²
  const float x1{samples.x[at[1]] - samples.x[at[0]]};
  const float y1{samples.y[at[1]] - samples.y[at[0]]};
  const float d1{samples.disparity[at[1]] - samples.disparity[at[0]]};
  plane.per_u = 0;
  if (has_roll) {
    const float x2{samples.x[at[2]] - samples.x[at[0]]};
    const float y2{samples.y[at[2]] - samples.y[at[0]]};
    const float d2{samples.disparity[at[2]] - samples.disparity[at[0]]};
    const float area{x1 * y2 - x2 * y1};
    if (std::abs(area) < area_min) return false;
    plane.per_u = (d1 * y2 - d2 * y1) / area;
    plane.per_v = (d2 * x1 - d1 * x2) / area;
  } else {
    if (std::abs(y1) < rows_min) return false;
    plane.per_v = d1 / y1;
  }
  plane.at_centre = samples.disparity[at[0]] - plane.per_u * samples.x[at[0]] - plane.per_v * samples.y[at[0]];
  return plane.per_v > 0;
}

void sort_by(double PlaneSearchWorkspace::Scored::*score, std::span<PlaneSearchWorkspace::Scored> scored) {
  std::ranges::stable_sort(scored, [&](const auto& a, const auto& b) { return a.*score > b.*score; });
}

void rate(const Rig& rig, const PlaneSamples& samples, const PlanePrior& prior,
          std::vector<PlaneSearchWorkspace::Scored>& scored) {
  for (PlaneSearchWorkspace::Scored& one : scored) {
    const PlaneSupport support{support_of({one.plane, rig, samples}, samples)};
    const double density{prior.log_density(ground_of(rig, one.plane))};
    one.score = support.evidence + density;
    one.near = support.near_evidence + density;
  }
}

// True: the same plane up to the errors of samples, at both lower corners and in the middle of the view's lower half.
bool are_alike(const PlaneHypothesis& p, const PlaneHypothesis& q, const PlaneSamples& samples) {
  constexpr float alike_share{0.03F};
  const float alike_px{std::min(1.0F, p.near_px / 16)};  // most disparities may be small: low resolution, far ground
  const auto differ = [&](float x, float y) {
    const float e{p.expected(x, y)};
    return std::abs(e - q.expected(x, y)) > alike_px + alike_share * std::abs(e);
  };
  const float middle{samples.last_y - (p.near_px / 2) / p.per_v};
  return !differ(samples.first_x, samples.last_y) && !differ(samples.last_x, samples.last_y) && !differ(0, middle);
}

bool is_new(const std::vector<FittedPlane>& found, const PlaneHypothesis& plane, const PlaneSamples& samples) {
  return std::ranges::none_of(found, [&](const FittedPlane& one) { return are_alike(one.hypothesis, plane, samples); });
}

// Refines the best hypotheses of distinct planes, until `most` have been found.
void refine_best(const Rig& rig, const PlaneSamples& samples, const PlanePrior& prior, const SearchBounds& bounds,
                 std::size_t most, PlaneSearchWorkspace& space) {
  for (const PlaneSearchWorkspace::Scored& one : space.scored) {
    if (space.found.size() >= most || space.tried.size() >= tried_max) return;
    const PlaneHypothesis hypothesis{one.plane, rig, samples};
    const auto is_like_it = [&](const PlaneHypothesis& other) { return are_alike(other, hypothesis, samples); };
    if (std::ranges::any_of(space.tried, is_like_it)) continue;
    space.tried.push_back(hypothesis);
    const std::optional<RefinedPlane> plane{
        refined_plane(rig, space.some, prior, {one.plane, samples.noise_px}, refining_rounds, space.some.weight)};
    if (!plane || !is_within(ground_of(rig, plane->plane), bounds)) continue;
    const FittedPlane fitted{fitted_plane(rig, space.some, prior, *plane, space.some.weight)};
    if (is_new(space.found, fitted.hypothesis, samples)) space.found.push_back(fitted);
  }
}

void draw(const Rig& rig, const PlaneSamples& samples, const SearchBounds& bounds, Generator& generator,
          std::vector<PlaneSearchWorkspace::Scored>& scored) {
  const std::size_t first{static_cast<std::size_t>((1 - drawn_share) * static_cast<double>(samples.size()))};
  const std::size_t count{samples.size() - first};
  scored.clear();
  for (std::size_t round{0}; round < draws_per_hypothesis * bounds.hypotheses && scored.size() < bounds.hypotheses;
       ++round) {
    const std::size_t at[3]{first + generator.below(count), first + generator.below(count),
                            first + generator.below(count)};
    RoadPlane plane{0, 0, 0, rig.cx_px, rig.cy_px};
    if (!put_through(samples, at, round % 2 == 1, plane) || !is_within(ground_of(rig, plane), bounds)) continue;
    scored.push_back({0, 0, plane});
  }
}

}  // namespace

double PlanePrior::log_density(const Ground& ground) const {
  const Vector3 from{ground.height_m - mean.height_m, ground.pitch_rad - mean.pitch_rad,
                     ground.roll_rad - mean.roll_rad};
  const Vector3 pull{precision * from};
  return -0.5 * (from[0] * pull[0] + from[1] * pull[1] + from[2] * pull[2]);
}

PlanePrior any_extrinsics_prior(const SearchBounds& bounds) {
  constexpr double pitch{radians(8)};
  constexpr double pitch_sigma{radians(16)};
  const double roll_sigma{bounds.roll_sigma_rad};
  return {{0, pitch - bounds.turned_rad, 0},
          diagonal({{0, 1 / (pitch_sigma * pitch_sigma), 1 / (roll_sigma * roll_sigma)}})};
}

PlanePrior prior_of(const Ground& ground) {
  return {ground, inverse(covariance_of(ground))};
}

bool is_within(const Ground& ground, const SearchBounds& bounds) {
  const double pitch{ground.pitch_rad + bounds.turned_rad};
  return ground.height_m >= 0.12 && ground.height_m <= 4.5 && pitch >= radians(-12) && pitch <= radians(45) &&
         std::abs(ground.roll_rad) < bounds.roll_max_rad;
}

void PlaneSearchWorkspace::reserve(std::size_t samples) {
  turned.reserve(samples);
  order.reserve(samples);
  few.reserve(std::min(samples, 2 * few_samples));
  some.reserve(std::min(samples, 2 * some_samples));
  scored.reserve(hypotheses_max);
  tried.reserve(tried_max);
  found.reserve(distinct_max);
}

namespace {

// A fit leaves kerbs and feet of obstacles out, which the evidence of a plane may count: its noise is that of the best
// matches, and the median of the residuals, two thirds of their σ, bounds it tightly.
constexpr float noise_min_px{0.1F};
constexpr float fit_flatness{0.005F};

PlaneHypothesis narrowed(PlaneHypothesis hypothesis, float noise_px) {
  hypothesis.noise_px = noise_px;
  hypothesis.flatness = fit_flatness;
  return hypothesis;
}

}  // namespace

std::optional<RefinedPlane> refined_plane(const Rig& rig, const PlaneSamples& samples, const PlanePrior& prior,
                                          RefinedPlane start, int rounds, std::span<const float> weights) {
  constexpr double settled_px{0.002};
  constexpr int coarse_rounds{2};  // with the start's noise: it may be off
  RefinedPlane refined{start};
  const float usual{samples.noise_px};
  RoadPlane& plane{refined.plane};
  for (int round{0}; round < rounds; ++round) {
    const Ground ground{ground_of(rig, plane)};
    const PlaneHypothesis hypothesis{narrowed({plane, rig, samples}, refined.noise_px)};
    const PlaneEquations sums{equations_of(hypothesis, samples, weights)};
    const Matrix3 by_numbers{inverse(numbers_by_ground(rig, ground))};
    const Vector3 from{ground.height_m - prior.mean.height_m, ground.pitch_rad - prior.mean.pitch_rad,
                       ground.roll_rad - prior.mean.roll_rad};
    const Matrix3 matrix{sums.matrix + carried(transposed(by_numbers), prior.precision)};
    if (!is_positive_definite(matrix)) return std::nullopt;
    const Vector3 step{inverse(matrix) * (sums.vector - transposed(by_numbers) * (prior.precision * from))};
    move(plane, step);
    if (!(plane.per_v > 0)) return std::nullopt;
    if (round + 1 >= coarse_rounds) refined.noise_px = std::clamp(sums.deviation_px, noise_min_px, usual);
    if (round > coarse_rounds && std::max({std::abs(step[0]), std::abs(step[1]), std::abs(step[2])}) < settled_px)
      break;
  }
  return refined;
}

FittedPlane fitted_plane(const Rig& rig, const PlaneSamples& samples, const PlanePrior& prior,
                         const RefinedPlane& refined, std::span<const float> weights) {
  const RoadPlane& plane{refined.plane};
  FittedPlane fitted{plane, ground_of(rig, plane), {plane, rig, samples}, refined.noise_px, {}, false, {}, 0};
  fitted.support = support_of(fitted.hypothesis, samples);
  fitted.total = fitted.support.evidence + prior.log_density(fitted.ground);
  const PlaneHypothesis hypothesis{narrowed(fitted.hypothesis, refined.noise_px)};
  const PlaneEquations sums{equations_of(hypothesis, samples, weights)};
  if (!is_positive_definite(sums.matrix)) return fitted;
  const Matrix3 by_samples{inverse(sums.matrix)};
  const Matrix3 by_numbers{inverse(numbers_by_ground(rig, fitted.ground))};
  const Matrix3 with_prior{inverse(sums.matrix + carried(transposed(by_numbers), prior.precision)) + common_errors()};
  fitted.measurement = {numbers_of(plane) + by_samples * sums.vector, by_samples + common_errors()};
  fitted.ground = with_covariance(fitted.ground, carried(by_numbers, with_prior));
  fitted.is_measured = true;
  return fitted;
}

void search_planes(const Rig& rig, const PlaneSamples& samples, const SearchBounds& bounds,
                   PlaneSearchWorkspace& space) {
  space.found.clear();
  space.tried.clear();
  if (samples.size() < static_cast<std::size_t>(ground_samples_min)) return;
  const PlanePrior prior{any_extrinsics_prior(bounds)};
  Generator generator;
  thin(samples, few_samples, generator, space.few);
  thin(samples, some_samples, generator, space.some);
  draw(rig, samples, bounds, generator, space.scored);
  using Scored = PlaneSearchWorkspace::Scored;
  rate(rig, space.few, prior, space.scored);
  sort_by(&Scored::score, space.scored);
  const std::size_t best{std::min(space.scored.size(), rated_again)};
  sort_by(&Scored::near, std::span{space.scored}.subspan(best));
  space.scored.resize(std::min(space.scored.size(), rated_again + rated_again_near));
  rate(rig, space.some, prior, space.scored);
  sort_by(&Scored::score, space.scored);
  refine_best(rig, samples, prior, bounds, distinct_by_all, space);
  sort_by(&Scored::near, space.scored);  // slopes and stairs ahead may have more of all
  refine_best(rig, samples, prior, bounds, distinct_max, space);
  const auto by_total = [](const FittedPlane& a, const FittedPlane& b) { return a.total > b.total; };
  std::ranges::stable_sort(space.found, by_total);
  space.found.resize(std::min(space.found.size(), finalists));
  for (FittedPlane& one : space.found) {
    const RefinedPlane start{one.plane, one.noise_px};
    const auto refined{refined_plane(rig, samples, prior, start, final_rounds, samples.weight)};
    one = fitted_plane(rig, samples, prior, refined.value_or(start), samples.weight);
  }
  std::erase_if(space.found, [&](const FittedPlane& one) { return !is_within(one.ground, bounds); });
  std::ranges::stable_sort(space.found, by_total);
}

namespace {

// Samples of the images turned by `quarters` of 90°, clockwise, in the order of their new rows.
void turn(const PlaneSamples& from, int quarters, float first_y, std::vector<std::size_t>& order, PlaneSamples& to) {
  const float cosine[4]{1, 0, -1, 0};
  const float sine[4]{0, 1, 0, -1};
  const float c{cosine[quarters]};
  const float s{sine[quarters]};
  const auto x_of = [&](float x, float y) { return c * x - s * y; };
  const auto y_of = [&](float x, float y) { return s * x + c * y; };
  to.clear();
  order.clear();
  for (std::size_t i{0}; i < from.size(); ++i) order.push_back(i);
  const auto row_of = [&](std::size_t i) { return y_of(from.x[i], from.y[i]); };
  std::ranges::sort(
      order, [&](std::size_t a, std::size_t b) { return row_of(a) != row_of(b) ? row_of(a) < row_of(b) : a < b; });
  for (const std::size_t i : order) {
    to.x.push_back(x_of(from.x[i], from.y[i]));
    to.y.push_back(y_of(from.x[i], from.y[i]));
    to.disparity.push_back(from.disparity[i]);
    to.weight.push_back(from.weight[i]);
  }
  to.fit_weight = to.weight;
  to.first_x = std::min(x_of(from.first_x, first_y), x_of(from.last_x, from.last_y));
  to.last_x = std::max(x_of(from.first_x, first_y), x_of(from.last_x, from.last_y));
  to.last_y = std::max(y_of(from.first_x, first_y), y_of(from.last_x, from.last_y));
  to.disparities = from.disparities;
  to.noise_px = from.noise_px;
}

}  // namespace

void search_rolled_planes(const Rig& rig, const PlaneSamples& samples, double turned_rad, int quarters,
                          PlaneSearchWorkspace& space) {
  constexpr std::size_t hypotheses{500};  // the ground of a rolled camera is reported, not used
  turn(samples, quarters, static_cast<float>(-rig.cy_px), space.order, space.turned);
  search_planes(rig, space.turned, {turned_rad, radians(30), radians(48), hypotheses}, space);
  for (FittedPlane& plane : space.found) {
    plane.ground.roll_rad = std::remainder(plane.ground.roll_rad + radians(90) * quarters, radians(360));
  }
}

}  // namespace stereogrid

// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"
#include "filter_run.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

// The equations of the method note once more, in double precision and for whole-cell velocities, straight from the
// text. 3 × 3 velocities: v = (k % 3 − 1, k / 3 − 1) cells a step. Three additions: the prior of a velocity is
// mostly static; less so where the previous frame has observed the place; static mass starts ten times less often than
// dynamic mass changes its velocity.
constexpr int cells{24};
constexpr int velocities{9};
constexpr int standstill{4};
constexpr double eps{0.00999966331328972};  // (1 − exp(−0.1/4.95))/2
constexpr double mu{0.05};
constexpr double exponent{0.7};
constexpr double static_prior{0.6};
constexpr double appearing_static{0.4};
constexpr double border{0.2};

struct Cell {
  std::array<double, velocities> of_velocity{};  // joint: P(occupied, v); tay2008: P(v)
  double occupied{0.5};
};
using Cells = std::vector<Cell>;

double prior(std::size_t k, double of_standstill = static_prior) {
  return k == standstill ? of_standstill : (1 - of_standstill) / (velocities - 1);
}

// Velocity noise: a Markov chain over the velocities.
double disturbed(const Cell& cell, std::size_t k) {
  if (k == standstill) return (1 - mu / 10) * cell.of_velocity[k];
  double sum{(1 - mu) * cell.of_velocity[k]};
  for (std::size_t j{0}; j < velocities; ++j) {
    sum += (j == standstill ? mu / 10 : mu) / (velocities - 1) * cell.of_velocity[j];
  }
  return sum;
}

// The cell that velocity k takes to (x, y); null outside the window.
const Cell* antecedent(const Cells& before, int x, int y, std::size_t k) {
  const int from_x{x - (static_cast<int>(k % 3) - 1)};
  const int from_y{y - (static_cast<int>(k / 3) - 1)};
  if (from_x < 0 || from_x >= cells || from_y < 0 || from_y >= cells) return nullptr;
  return &before[static_cast<std::size_t>(from_y * cells + from_x)];
}

// Motion of a cell's mass: mean velocity, covariance and dynamic share.
struct Motion {
  double x{0};
  double y{0};
  double xx{0};
  double xy{0};
  double yy{0};
  double moving{0};
};

// `masses`: P(occupied, v_k)
Motion motion_of(const std::array<double, velocities>& masses) {
  const auto vx = [](std::size_t k) { return 2 * (static_cast<double>(k % 3) - 1); };
  const auto vy = [](std::size_t k) { return 2 * (static_cast<double>(k / 3) - 1); };
  const double sum{std::accumulate(masses.begin(), masses.end(), 0.0)};
  Motion motion;
  motion.moving = sum - masses[standstill];
  for (std::size_t k{0}; k < velocities; ++k) {
    motion.x += masses[k] / sum * vx(k);
    motion.y += masses[k] / sum * vy(k);
  }
  for (std::size_t k{0}; k < velocities; ++k) {
    const double dx{vx(k) - motion.x};
    const double dy{vy(k) - motion.y};
    motion.xx += masses[k] / sum * dx * dx;
    motion.xy += masses[k] / sum * dx * dy;
    motion.yy += masses[k] / sum * dy * dy;
  }
  return motion;
}

double likelihood(double p) {
  return std::pow(std::clamp(p, 0.001, 0.999), exponent);
}

// docs/method.md §8.6
Cell tay(const Cells& before, int x, int y, double p, bool, Motion& motion) {
  Cell after;
  double sum{0};
  double occupied{0};
  std::array<double, velocities> beta{};
  for (std::size_t k{0}; k < velocities; ++k) {
    const Cell* a{antecedent(before, x, y, k)};
    const double pi_a{a == nullptr ? prior(k) : disturbed(*a, k)};
    const double o_a{a == nullptr ? 0.5 : a->occupied};
    const double alpha_occupied{pi_a * ((1 - eps) * o_a + eps * (1 - o_a))};
    const double alpha_empty{pi_a * (eps * o_a + (1 - eps) * (1 - o_a))};
    beta[k] = likelihood(p) * alpha_occupied;
    after.of_velocity[k] = beta[k] + likelihood(1 - p) * alpha_empty;
    sum += after.of_velocity[k];
    occupied += beta[k];
  }
  for (double& pi_k : after.of_velocity) pi_k /= sum;
  for (double& b : beta) b /= sum;
  motion = motion_of(beta);
  after.occupied = occupied / sum;
  return after;
}

// docs/method.md §8.7, for cells that have been seen before
Cell joint(const Cells& before, int x, int y, double p, bool just_seen, Motion& motion) {
  Cell after;
  double sum{0};
  for (std::size_t k{0}; k < velocities; ++k) {
    const Cell* a{antecedent(before, x, y, k)};
    after.of_velocity[k] = a == nullptr ? border * prior(k) : disturbed(*a, k);
    sum += after.of_velocity[k];
  }
  for (double& m : after.of_velocity) m /= std::max(sum, 1.0);
  sum = std::min(sum, 1.0);
  const double predicted{(1 - eps) * sum + eps * (1 - sum)};
  const double n{likelihood(p) * predicted + likelihood(1 - p) * (1 - predicted)};
  for (std::size_t k{0}; k < velocities; ++k) {
    double& m{after.of_velocity[k]};
    m = ((1 - eps) * m + eps * prior(k, just_seen ? appearing_static : static_prior) * (1 - sum)) * likelihood(p) / n;
  }
  after.occupied = likelihood(p) * predicted / n;
  motion = motion_of(after.of_velocity);
  return after;
}

Cells cells_of(const FilterState& state) {
  Cells all;
  for (int i{0}; i < cells * cells; ++i) {
    Cell cell;
    cell.occupied = state.occupancy(i % cells, i / cells);
    for (std::size_t k{0}; k < velocities; ++k) cell.of_velocity[k] = mass_of(state, k, i % cells, i / cells);
    all.push_back(cell);
  }
  return all;
}

// Free ground with one cell in four occupied; a third of the frames sees nothing.
Image<float> observation(int step, std::mt19937& generator) {
  Image<float> observed{cells, cells, 0.5f};
  if (step % 3 == 0) return observed;
  for (float& p : observed) {
    p = static_cast<float>(uniform(generator, 0.1, 0.4) + (generator() % 4 == 0 ? 0.5 : 0));
  }
  return observed;
}

void expect_motion(const GridLayers& layers, int x, int y, const Motion& expected) {
  ASSERT_NEAR(layers.velocity_x(x, y), expected.x, 1e-4);
  ASSERT_NEAR(layers.velocity_y(x, y), expected.y, 1e-4);
  ASSERT_NEAR(layers.velocity_xx(x, y), expected.xx, 1e-4);
  ASSERT_NEAR(layers.velocity_xy(x, y), expected.xy, 1e-4);
  ASSERT_NEAR(layers.velocity_yy(x, y), expected.yy, 1e-4);
  ASSERT_NEAR(layers.moving(x, y), expected.moving, 1e-5);
}

class FilterEquations : public testing::TestWithParam<FilterModel> {};

TEST_P(FilterEquations, AreThoseOfTheMethodNote) {
  FilterConfig config{method_config(GetParam())};
  config.speeds_mps = {2};
  config.velocity_noise = mu;
  config.likelihood_exponent = exponent;
  config.static_prior = static_prior;
  Reference reference;
  FilterRun run{reference, config, {0, 0, 0.2, cells, cells}};
  std::mt19937 generator{91};
  run.step(observation(1, generator));  // unobserved cells have a rule of their own
  Cells expected{cells_of(run.now)};
  for (int step{2}; step < 14; ++step) {
    const Image<float> observed{observation(step, generator)};
    run.step(observed);
    const Cells before{expected};
    for (const auto [x, y] : raster(cells, cells)) {
      Motion motion;
      const auto equations = GetParam() == FilterModel::joint ? joint : tay;
      const bool just_seen{(step - 1) % 3 != 0};
      const Cell cell{equations(before, x, y, static_cast<double>(observed(x, y)), just_seen, motion)};
      expected[static_cast<std::size_t>(y * cells + x)] = cell;
      ASSERT_NEAR(run.layers.occupancy(x, y), cell.occupied, 1e-5) << "step " << step << ": " << x << " " << y;
      ASSERT_NO_FATAL_FAILURE(expect_motion(run.layers, x, y, motion)) << "step " << step << ": " << x << " " << y;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Models, FilterEquations, testing::Values(FilterModel::tay2008, FilterModel::joint),
                         [](const auto& name) {
                           return std::string{names_of(name.param)[static_cast<std::size_t>(name.param)]};
                         });

}  // namespace
}  // namespace stereogrid::test

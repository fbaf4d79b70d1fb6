// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "backend/reference.hpp"
#include "check.hpp"
#include "filter/joint/blocks.cuh"
#include "images.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::test {
namespace {

constexpr double cell_m{0.2};

FilterConfig config_of(FilterModel model, std::vector<double> speeds_mps) {
  FilterConfig config;
  config.model = model;
  config.speeds_mps = std::move(speeds_mps);
  config.static_prior = 0.5;
  return config;
}

// Free, occupied, unknown and in-between.
Image<float> random_observation(int cells, Random& random) {
  Image<float> observed{cells, cells, 0.5f};
  for (float& p : observed) {
    const double kind{random.between(0, 1)};
    p = static_cast<float>(kind < 0.3 ? 0.5 : (kind < 0.4 ? 1.0 : (kind < 0.6 ? 0.0 : random.between(0, 1))));
  }
  return observed;
}

// A layer on both sides.
struct Layer {
  const Image<float>& host;
  const DeviceImage<float>& device;
};
std::vector<Layer> all_layers(const GridLayers& host, const LayersOnDevice& device) {
  return {{host.occupancy, device.occupancy},     {host.velocity_x, device.velocity_x},
          {host.velocity_y, device.velocity_y},   {host.age_s, device.age_s},
          {host.velocity_xx, device.velocity_xx}, {host.velocity_xy, device.velocity_xy},
          {host.velocity_yy, device.velocity_yy}, {host.moving, device.moving}};
}

// The filter on both back ends, step by step.
class Run {
 public:
  Run(const FilterConfig& parameters, const GridGeometry& start)
      : config_{parameters},
        tables_{config_},
        geometry_{start},
        now_{start.nx, config_},
        before_{now_},
        layers_{grid_layers(start)},
        filter_{cuda_, config_, tables_, start.nx},
        now_on_device_{cuda_, config_, start.nx},
        before_on_device_{cuda_, config_, start.nx},
        layers_on_device_{start.nx, start.ny} {
    reset(now_, config_, start);
    const FilterMotion motion{filter_motion({config_, tables_, start, 0.1}, start)};
    reset(cuda_, filter_, one_on_device(cuda_, motion).data(), now_on_device_);
    cuda_.synchronize();
  }

  void step(const Image<float>& observed, double dt_s, int moved_x, int moved_y) {
    const GridGeometry last{geometry_};
    geometry_.x_min_m += moved_x * cell_m;
    geometry_.y_min_m += moved_y * cell_m;
    const FilterInput input{config_, tables_, geometry_, dt_s, view_};
    std::swap(now_, before_);
    filter(reference_, input, observed.view(), before_, now_, layers_);
    std::swap(now_on_device_, before_on_device_);
    const DeviceBuffer<FilterMotion> motion{one_on_device(cuda_, filter_motion(input, last))};
    const DeviceImage<float> seen{on_device(cuda_, observed)};
    filter(cuda_, filter_, motion.data(), seen.view(), before_on_device_, now_on_device_, layers_on_device_);
    cuda_.synchronize();
  }

  void look_from(const CameraView& view) { view_ = view; }

  void weigh(const std::vector<VelocityEvidence>& evidence) {
    weigh_velocities(reference_, evidence, tables_, now_, layers_);
    PinnedBuffer<VelocityEvidence> pinned{evidence.size() + 1};
    PinnedBuffer<int> count{1};
    std::copy(evidence.begin(), evidence.end(), pinned.data());
    *count.data() = static_cast<int>(evidence.size());
    weigh_velocities(cuda_, filter_, pinned.data(), count.data(), now_on_device_, layers_on_device_);
    cuda_.synchronize();
  }

  // Maximum over all layers.
  double difference() {
    double largest{0};
    for (const Layer& layer : all_layers(layers_, layers_on_device_)) {
      largest = std::max(largest, largest_difference(on_host(cuda_, layer.device), layer.host));
    }
    return largest;
  }

  // P(occupied, v_k) as the next step reads it.
  double difference_of_masses() {
    const int cells{geometry_.nx};
    const Image<float> scale{on_host(cuda_, now_on_device_.scale)};
    const Image<float> birth_static{on_host(cuda_, now_on_device_.birth_static)};
    const Image<float> birth_moving{on_host(cuda_, now_on_device_.birth_moving)};
    std::vector<float> mass(now_on_device_.mass.size());
    std::vector<int> slots(now_on_device_.slots.size());
    download(cuda_, now_on_device_.mass.data(), mass.size(), mass.data());
    download(cuda_, now_on_device_.slots.data(), slots.size(), slots.data());
    cuda_.synchronize();
    const int velocities{static_cast<int>(tables_.lattice.size())};
    const bool is_joint{config_.model == FilterModel::joint};
    double largest{0};
    for (int y{0}; y < cells; ++y) {
      for (int x{0}; x < cells; ++x) {
        const int block{BlockLayout{cells}.block_of(x, y)};
        const int slot{is_joint ? slots[static_cast<std::size_t>(block)] : 0};
        if (is_joint && slot != now_.blocks.slot(block)) return 1;
        for (int k{0}; k < velocities && slot >= 0; ++k) {
          const std::size_t at{is_joint ? mass_index(slot, velocities, k, x, y)
                                        : static_cast<std::size_t>((k * cells + y) * cells + x)};
          const float birth{is_joint ? (k == velocities / 2 ? birth_static : birth_moving)(x, y) : 0.0f};
          const float here{scale(x, y) * mass[at] + birth};
          const float expected{mass_of(now_, static_cast<std::size_t>(k), x, y)};
          largest = std::max(largest, static_cast<double>(std::abs(here - expected)));
        }
      }
    }
    return largest;
  }

  Cuda& cuda() { return cuda_; }
  const GridLayers& layers() const { return layers_; }
  const LayersOnDevice& layers_on_device() const { return layers_on_device_; }
  const GridGeometry& geometry() const { return geometry_; }

 private:
  Cuda cuda_;
  Reference reference_;
  FilterConfig config_;
  FilterTables tables_;
  GridGeometry geometry_;
  CameraView view_{};
  FilterState now_;
  FilterState before_;
  GridLayers layers_;
  FilterOnDevice filter_;
  FilterStateOnDevice now_on_device_;
  FilterStateOnDevice before_on_device_;
  LayersOnDevice layers_on_device_;
};

struct Move {
  double dt_s;
  int x;
  int y;
};
constexpr Move moves[]{{0.1, 0, 0}, {0.033, 1, 0}, {0.25, -2, 3}, {0.1, 0, -1}, {0.1, 40, 0}, {0, 3, -3}, {0.1, 0, 0}};

// The sums are formed in the reference's order.
TEST(joint_filter_is_that_of_the_reference) {
  Random random{31};
  for (const int cells : {1, 5, 31, 34, 63}) {
    FilterConfig config{config_of(FilterModel::joint, {1.3, 2.6, 3.9})};
    config.likelihood_exponent = 0.6;
    Run run{config, {-1, 2, cell_m, cells, cells}};
    for (const Move& move : moves) {
      run.step(random_observation(cells, random), move.dt_s, move.x, move.y);
      CHECK_EQUAL(run.difference(), 0);
      CHECK_EQUAL(run.difference_of_masses(), 0);
    }
  }
}

TEST(joint_filter_with_other_lattices) {
  Random random{33};
  // 1, 3 and 15 velocities along an axis
  for (const std::vector<double>& speeds_mps :
       {std::vector<double>{}, std::vector<double>{2}, std::vector<double>{2, 4, 6, 8, 10, 12, 14}}) {
    Run run{config_of(FilterModel::joint, speeds_mps), {0, 0, cell_m, 21, 21}};
    for (int i{0}; i < 4; ++i) {
      run.step(random_observation(21, random), 0.1, i % 2, 1);
      CHECK_EQUAL(run.difference(), 0);
    }
  }
}

TEST(evidence_of_velocities_is_weighed_as_by_the_reference) {
  Random random{34};
  constexpr int cells{41};
  Run run{config_of(FilterModel::joint, {1.3, 2.6, 3.9}), {-1, 2, cell_m, cells, cells}};
  for (const int every : {1, 3, 700, 5000}) {  // all cells, a third of them, a few, none
    run.step(random_observation(cells, random), 0.1, 1, 0);
    std::vector<VelocityEvidence> evidence;
    for (int cell{every - 1}; cell < cells * cells; cell += every) {
      const auto between = [&](double low, double high) { return static_cast<float>(random.between(low, high)); };
      evidence.push_back({cell, between(-6, 6), between(-6, 6), between(0.1, 9), between(-0.1, 0.1), between(0.1, 9),
                          cell % 2, cell / 2 % 2});
    }
    run.weigh(evidence);
    CHECK_EQUAL(run.difference(), 0);
    CHECK_EQUAL(run.difference_of_masses(), 0);
  }
}

// The window lies 40 to 50 m ahead of the camera: the range of features ends in it, and that of moving new mass.
TEST(far_and_unseen_cells_are_those_of_the_reference) {
  Random random{36};
  constexpr int cells{50};
  for (const double focal_baseline_pxm : {330.0, 350.0}) {
    Run run{config_of(FilterModel::joint, {1.3, 2.6, 3.9}), {40, -5, cell_m, cells, cells}};
    run.look_from({{0, 0, 0}, 1, 1, 1e4, focal_baseline_pxm});
    for (int i{0}; i < 6; ++i) {
      Image<float> observed{random_observation(cells, random)};
      for (int y{0}; y < cells; ++y) std::fill_n(&observed(y % 20, y), 22, 0.5f);
      run.step(observed, 0.1, i % 2, 0);
      CHECK_EQUAL(run.difference(), 0);
      CHECK_EQUAL(run.difference_of_masses(), 0);
    }
  }
}

TEST(tay_filter_is_that_of_the_reference) {
  Random random{35};
  for (const int cells : {1, 5, 34}) {
    FilterConfig config{config_of(FilterModel::tay2008, {1.3, 2.6, 3.9})};
    config.static_prior = cells == 5 ? 0 : 0.5;
    Run run{config, {-1, 2, cell_m, cells, cells}};
    for (const Move& move : moves) {
      run.step(random_observation(cells, random), move.dt_s, move.x, move.y);
      CHECK_EQUAL(run.difference(), 0);
      CHECK_EQUAL(run.difference_of_masses(), 0);
    }
  }
}

TEST(window_is_seen_from_the_vehicle) {
  Random random{37};
  Run run{config_of(FilterModel::joint, {2, 4}), {-3, -4, cell_m, 44, 44}};
  for (int i{0}; i < 3; ++i) run.step(random_observation(44, random), 0.1, 1, 0);
  for (const Pose2& pose : {Pose2{0, 0, 0}, Pose2{0.31, -0.27, 0.7}, Pose2{3, 3, -2.9}}) {
    const GridGeometry grid{0, -3.1, 0.2, 37, 31};
    FrameResult result;
    result.vehicle = grid_layers(grid);
    result.world = run.layers();
    resample(pose, result);
    const GridLayers& expected{result.vehicle};
    LayersOnDevice found{grid.nx, grid.ny};
    const GridInVehicle place{grid, pose.x_m, pose.y_m, std::cos(pose.yaw_rad), std::sin(pose.yaw_rad)};
    const DeviceBuffer<GridGeometry> window{one_on_device(run.cuda(), run.geometry())};
    const DeviceBuffer<GridInVehicle> vehicle{one_on_device(run.cuda(), place)};
    resample(run.cuda(), run.layers_on_device(), window.data(), vehicle.data(), found);
    for (const Layer& layer : all_layers(expected, found)) {
      CHECK_EQUAL(differences(on_host(run.cuda(), layer.device), layer.host), 0);
    }
  }
}

}  // namespace
}  // namespace stereogrid::test

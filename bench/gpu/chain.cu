// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "chain.hpp"

#include <algorithm>
#include <memory>
#include <thread>
#include <utility>

#include "drive.hpp"
#include "samples.hpp"

namespace stereogrid::bench {
namespace {

// Of a cell that nothing moves in, the filter reads what is observed and what it remembers (4), and writes that and the
// layers (11).
constexpr double still_cell_bytes{15 * sizeof(float)};

struct Part {
  const char* name;
  StreamTimes::Mark from;
  StreamTimes::Mark to;
};
constexpr Part parts[]{{"upload", StreamTimes::start, StreamTimes::uploaded},
                       {"match", StreamTimes::uploaded, StreamTimes::matched},
                       {"ground", StreamTimes::matched, StreamTimes::ground_known},
                       {"count", StreamTimes::resumed, StreamTimes::counted},
                       {"project", StreamTimes::counted, StreamTimes::projected},
                       {"filter", StreamTimes::projected, StreamTimes::filtered},
                       {"download", StreamTimes::filtered, StreamTimes::fetched}};

constexpr int semi_global_paths{3};

// Semi-global: the volume is written once, and read and written again by every direction but the last.
double match_bytes(const Case& what) {
  const double pixels{1.0 * what.width * what.height};
  const double labels{what.disparities + 2.0 * road_margin_px + 1};
  const double images{pixels * (2 + 3 * sizeof(float))};
  if (what.method == MatchingMethod::correlation) return images;
  return images + pixels * labels * (1 + semi_global_paths + 2.0 * (semi_global_paths - 1));
}

// Correlation, per label: difference of bits, their number, in and out of the window's column and row, minimum and its
// runner-up. Semi-global, per label and direction: four candidates, their minimum, sums.
double match_operations(const Case& what) {
  const double labels{(what.disparities + 2.0 * road_margin_px + 1) * what.width * what.height};
  return labels * (what.method == MatchingMethod::correlation ? 8 : 2 + 8 * semi_global_paths);
}

void add_costs(const Case& what, int window_cells, std::vector<StageResult>& stages) {
  const double pixels{1.0 * what.width * what.height};
  const double bins{1.0 * what.width * what.disparities};
  const double cells{1.0 * window_cells * window_cells};
  for (StageResult& stage : stages) {
    if (stage.name == "upload") stage.bytes = 2 * pixels;
    if (stage.name == "match") stage.bytes = match_bytes(what);
    if (stage.name == "match") stage.operations = match_operations(what);
    if (stage.name == "count") stage.bytes = 2 * sizeof(float) * pixels + bins * (4 + 5 * sizeof(float));
    if (stage.name == "project") stage.bytes = bins * sizeof(float) + cells * sizeof(float);
    if (stage.name == "filter") stage.bytes = still_cell_bytes * cells;  // little moves
    if (stage.name == "download") stage.bytes = 8 * cells * sizeof(float);
  }
}

}  // namespace

ChainResult run_chain(const Case& what, int frames) {
  const std::vector<StereoFrame> shown{drawn(what)};
  Drive drive{what};
  for (int i{0}; i < warm_up; ++i) drive.step(shown);
  Samples total;
  Samples device;
  std::vector<Samples> of_part(std::size(parts));
  for (int i{0}; i < frames; ++i) {
    total.time([&] { drive.step(shown); });
    device.add(drive.times().between(StreamTimes::uploaded, StreamTimes::ground_known) +
               drive.times().between(StreamTimes::resumed, StreamTimes::filtered));
    for (std::size_t p{0}; p < std::size(parts); ++p) {
      of_part[p].add(drive.times().between(parts[p].from, parts[p].to));
    }
  }
  ChainResult result{what, {}, total.percentile(50), total.percentile(99), device.percentile(50)};
  for (std::size_t p{0}; p < std::size(parts); ++p) {
    result.stages.push_back({parts[p].name, of_part[p].percentile(50), of_part[p].percentile(99), 0, 0});
  }
  const Config config{config_of(what)};
  add_costs(what, Window{vehicle_grid_of(config.grid)}.cells(), result.stages);
  return result;
}

double run_batch(const Case& what, int cameras, int frames) {
  const std::vector<StereoFrame> shown{drawn(what)};
  std::vector<std::unique_ptr<Drive>> drives;
  for (int i{0}; i < cameras; ++i) {
    drives.push_back(std::make_unique<Drive>(what));
    for (int k{0}; k < warm_up; ++k) drives.back()->step(shown);
  }
  Samples samples;
  samples.time([&] {
    std::vector<std::thread> threads;
    for (const auto& drive : drives) {
      threads.emplace_back([&shown, frames, one = drive.get()] { one->go(shown, frames); });
    }
    for (std::thread& thread : threads) thread.join();
  });
  return 1e3 * cameras * frames / samples.percentile(50);
}

// After some steps on random observations as many blocks move as can.
StageResult run_filter(int cells, int repetitions) {
  Cuda cuda;
  const FilterConfig config{preset("default").filter};
  const FilterTables tables{config};
  const int velocities{static_cast<int>(tables.lattice.size())};
  const GridGeometry geometry{0, 0, 0.1, cells, cells};
  FilterOnDevice space{cuda, config, tables, cells};
  FilterStateOnDevice before{config, cells};
  FilterStateOnDevice after{config, cells};
  LayersOnDevice layers{cells, cells};
  DeviceImage<float> observed{cells, cells};
  Image<float> values{cells, cells, 0.5f};
  for (std::size_t i{0}; i < values.size(); ++i) values.data()[i] = static_cast<float>(i * 2654435761U % 1000) / 1000;
  upload(cuda, values.data(), values.size(), observed.data());
  DeviceBuffer<FilterMotion> motion{1};
  const FilterMotion still{filter_motion({config, tables, geometry, frame_s}, geometry)};
  upload(cuda, &still, 1, motion.data());
  reset(cuda, space, motion.data(), before);
  for (int i{0}; i < 4; ++i) {
    filter(cuda, space, motion.data(), std::as_const(observed).view(), before, after, layers);
    std::swap(before, after);
  }
  cuda.synchronize();
  Graph graph;
  graph.capture(cuda,
                [&] { filter(cuda, space, motion.data(), std::as_const(observed).view(), before, after, layers); });
  Samples samples;
  for (int i{0}; i < repetitions; ++i) samples.add(median_ms(cuda, 1, [&] { graph.launch(cuda); }));
  const double moving{static_cast<double>(std::min(space.capacity, BlockLayout{cells}.count()))};
  return {"filter " + std::to_string(cells) + " x " + std::to_string(cells) + " x " + std::to_string(velocities),
          samples.percentile(50), samples.percentile(99),
          still_cell_bytes * cells * cells + 2 * sizeof(float) * moving * block_cells * velocities, 0};
}

}  // namespace stereogrid::bench

// SPDX-License-Identifier: Apache-2.0
#include "chain.hpp"

#include <utility>

#include "drive.hpp"
#include "samples.hpp"

namespace stereogrid::bench {
namespace {

struct Part {
  const char* name;
  StreamTimes::Mark from;
  StreamTimes::Mark to;
};
constexpr Part parts[]{{"upload", StreamTimes::start, StreamTimes::uploaded},
                       {"match", StreamTimes::uploaded, StreamTimes::matched},
                       {"answer", StreamTimes::matched, StreamTimes::answered},
                       {"count", StreamTimes::resumed, StreamTimes::counted},
                       {"project", StreamTimes::counted, StreamTimes::projected},
                       {"filter", StreamTimes::filtering, StreamTimes::filtered},
                       {"download", StreamTimes::filtered, StreamTimes::fetched}};

}  // namespace

ChainResult run_chain(const Case& what, int frames) {
  const std::vector<StereoFrame> shown{drawn(what)};
  Drive drive{what};
  for (int i{0}; i < warm_up; ++i) drive.step(shown);
  Samples device;
  std::vector<Samples> of_part(std::size(parts));
  for (int i{0}; i < frames; ++i) {
    drive.step(shown);
    device.add(drive.times().between(StreamTimes::uploaded, StreamTimes::answered) +
               drive.times().between(StreamTimes::resumed, StreamTimes::filtered));
    for (std::size_t p{0}; p < std::size(parts); ++p) {
      of_part[p].add(drive.times().between(parts[p].from, parts[p].to));
    }
  }
  ChainResult result{what, {}, device.percentile(50), device.percentile(99)};
  for (std::size_t p{0}; p < std::size(parts); ++p) {
    result.stages.push_back({parts[p].name, of_part[p].percentile(50)});
  }
  return result;
}

// After some steps on random observations as many blocks move as can.
StageResult run_filter(int cells, int repetitions) {
  Cuda cuda;
  const FilterConfig config{preset("default").filter};
  const FilterTables tables{config};
  const GridGeometry geometry{0, 0, 0.1, cells, cells};
  FilterOnDevice space{cuda, config, tables, cells};
  FilterStateOnDevice before{cuda, config, cells};
  FilterStateOnDevice after{cuda, config, cells};
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
  return {std::to_string(cells) + " × " + std::to_string(cells) + " × " + std::to_string(tables.lattice.size()),
          samples.percentile(50)};
}

}  // namespace stereogrid::bench

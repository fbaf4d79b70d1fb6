// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures our matchers and OpenCV's against truth, on the same pixels: Velodyne sweeps, KITTI 2015, scenes. Tables on
// stdout; accuracy/ has the parts.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "accuracy/report.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"

namespace {

using namespace stereogrid;
using namespace stereogrid::bench;

struct Options {
  std::string data;
  std::string set;
  std::string json;
  std::string samples;
  std::vector<std::string> settings;
  MeasureOptions measure;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("DATA_DIR", options.data, "Folder with kitti_odo04, kitti_raw0009, kitti_pairs, synthetic.")
      ->required();
  app.add_option("--every", options.measure.every, "Takes every N-th frame with truth.")->check(CLI::Range(1, 1000));
  app.add_option("--set", options.settings, "Parameters of our matchers, group.name=value.");
  app.add_option("--only", options.measure.only, "Only matchers whose name holds this text, and their peers.");
  app.add_option("--sets", options.set, "Only sets whose group/name holds this text.");
  app.add_option("--json", options.json, "Everything as JSON, by set.");
  app.add_option("--samples", options.samples, "A row per matched point, as .npz (bench/accuracy/measure.cpp).");
}

Config config_of(const std::vector<std::string>& settings) {
  Config config;
  for (const std::string& setting : settings) {
    const std::size_t sign{std::min(setting.find('='), setting.size())};
    set(config, setting.substr(0, sign), setting.substr(std::min(sign + 1, setting.size())));
  }
  return config;
}

void run(Options options) {
  options.measure.config = config_of(options.settings);
  Samples samples;
  if (!options.samples.empty()) options.measure.samples = &samples;
  std::vector<SetResult> results;
  std::vector<SetResult> groups;
  for (const TruthSet& set : open_sets(options.data)) {
    if ((set.group + "/" + set.name).find(options.set) == std::string::npos) continue;
    options.measure.set_number = static_cast<int>(results.size());
    results.push_back(measure(set, options.measure));
    if (groups.empty() || groups.back().name != set.group) {
      groups.push_back(results.back());
      groups.back().name = set.group;
    } else {
      groups.back() += results.back();
    }
  }
  if (results.empty()) throw InputError{options.data, "holds none of the sets.", "Name the folder that they lie in."};
  for (const SetResult& group : groups) std::fputs(markdown(group).c_str(), stdout);
  if (!options.json.empty()) io::write_file(options.json, json(results));
  if (!options.samples.empty()) samples.write(options.samples);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Accuracy of matchers against truth."};
  Options options;
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_accuracy: %s\n", error.what());
    return 65;
  }
  return 0;
}

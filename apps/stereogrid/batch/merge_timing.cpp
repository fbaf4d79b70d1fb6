// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/merge_timing.hpp"

namespace stereogrid::app::batch {

void MergedTiming::add(const Json& timing, Sums& sums) {
  const double frames{timing.value("frames", 0.0)};
  ++sums.shards;
  sums.frames += frames;
  sums.seconds += timing.value("seconds", 0.0);
  if (!timing.contains("timing_ms")) return;
  for (const auto& [stage, times] : timing.at("timing_ms").items()) {
    sums.stage_ms[stage] += times.value("mean", 0.0) * frames;
  }
}

void MergedTiming::add(const Shard& shard, const Json& timing) {
  add(timing, variants_[shard.variant]);
  add(timing, hosts_[timing.value("host", "unknown")]);
}

Json MergedTiming::json_of(const Sums& sums) {
  Json stages(Json::object());
  for (const auto& [stage, ms] : sums.stage_ms) stages[stage] = sums.frames > 0 ? ms / sums.frames : 0;
  return {{"shards", sums.shards},
          {"frames", sums.frames},
          {"seconds", sums.seconds},
          {"frames_per_second", sums.seconds > 0 ? sums.frames / sums.seconds : 0},
          {"mean_ms", stages}};
}

Json MergedTiming::summary(const Plan& plan) const {
  Json variants(Json::array());
  for (const auto& [variant, sums] : variants_) {
    Json one{{"swept", plan.variants.at(variant).swept}};
    one.update(json_of(sums));
    variants.push_back(one);
  }
  Json hosts(Json::object());
  for (const auto& [host, sums] : hosts_) hosts[host] = json_of(sums);
  return {{"variants", variants}, {"hosts", hosts}};
}

}  // namespace stereogrid::app::batch

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/server/metrics.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "stereogrid/error.hpp"

namespace stereogrid::server::testing {
namespace {

TEST(MetricsTest, TextFormat) {
  Metrics metrics;
  metrics.counter("frames_total", "Frames so far.");
  metrics.sample(12);
  metrics.gauge("stage_ms", "Time of a \\ stage\nin ms.");
  metrics.sample(0.1, {{"stage", "match"}, {"note", "a \"b\" \\ c\nd"}});
  metrics.sample(1e300, {{"stage", "flow"}});
  metrics.sample(NAN);
  metrics.sample(INFINITY);
  metrics.sample(-INFINITY);
  EXPECT_EQ(metrics.text(),
            "# HELP frames_total Frames so far.\n# TYPE frames_total counter\nframes_total 12\n"
            "# HELP stage_ms Time of a \\\\ stage\\nin ms.\n# TYPE stage_ms gauge\n"
            "stage_ms{stage=\"match\",note=\"a \\\"b\\\" \\\\ c\\nd\"} 0.1\n"
            "stage_ms{stage=\"flow\"} 1e+300\nstage_ms NaN\nstage_ms +Inf\nstage_ms -Inf\n");
}

TEST(MetricsTest, NamesThatAreNone) {
  Metrics metrics;
  EXPECT_THROW(metrics.sample(1), ConfigError);
  for (const char* name : {"", "1st", "a-b", "a b", "ä"}) {
    EXPECT_THROW(metrics.counter(name, ""), ConfigError) << name;
  }
  metrics.gauge("a:b_1", "");
  EXPECT_THROW(metrics.gauge("a:b_1", ""), ConfigError);
  for (const char* label : {"", "a:b", "__a", "0", "a=\""})
    EXPECT_THROW(metrics.sample(1, {{label, "x"}}), ConfigError);
}

}  // namespace
}  // namespace stereogrid::server::testing

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/config_file.hpp"

#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

class ConfigFile : public ::testing::Test {
 protected:
  [[nodiscard]] Config load(const std::string& text) const {
    put(folder_ / "c.yaml", text);
    Config config{preset("default")};
    load_config(folder_ / "c.yaml", config);
    return config;
  }

  TemporaryFolder folder_;
};

TEST_F(ConfigFile, NestedAndDottedKeys) {
  const Config config{
      load("grid: {length_m: 30}\nmatching.disparities: 128\nground:\n  estimate: off\npaper:\n"
           "  road_rays: none\nfilter:\n")};
  EXPECT_EQ(config.grid.length_m, 30);
  EXPECT_EQ(config.matching.disparities, 128);
  EXPECT_FALSE(config.ground.estimate);
  EXPECT_EQ(config.paper.road_rays, RoadRays::none);
  EXPECT_EQ(config.grid.width_m, Config{}.grid.width_m) << "what is not named stays";
}

TEST_F(ConfigFile, ListsAreWrittenAsYamlHasThemOrAsText) {
  for (const char* text : {"filter:\n  speeds_mps: [1, 2.5]\n", "filter.speeds_mps: 1, 2.5\n"}) {
    EXPECT_EQ(load(text).filter.speeds_mps, (std::vector<double>{1, 2.5})) << text;
  }
  EXPECT_TRUE(load("filter: {speeds_mps: []}\n").filter.speeds_mps.empty());
}

TEST_F(ConfigFile, EmptyFileChangesNothing) {
  EXPECT_EQ(to_json(load("# nothing\n")), to_json(preset("default")));
}

TEST_F(ConfigFile, YamlRoundTripsBothPresets) {
  for (const std::string& name : preset_names()) {
    const Config config{preset(name)};
    EXPECT_EQ(to_json(load(to_yaml(config))), to_json(config)) << name;
  }
}

TEST_F(ConfigFile, YamlExplainsEveryParameter) {
  const Config config;
  const std::string yaml{to_yaml(config)};
  visit_parameters(config, [&](std::string_view, const Parameter& parameter, const auto&) {
    EXPECT_THAT(yaml, ::testing::HasSubstr(std::string{parameter.sentence}));
  });
}

TEST_F(ConfigFile, JsonHasTheRightTypes) {
  const std::string json{to_json(preset("default"))};
  EXPECT_THAT(json, ::testing::HasSubstr(R"("grid":{"length_m":20.0,)"));
  EXPECT_THAT(json, ::testing::HasSubstr(R"("estimate":true)"));
  EXPECT_THAT(json, ::testing::HasSubstr(R"("projection":{"model":"rays"})"));
  EXPECT_THAT(to_json(Config{}, 2), ::testing::HasSubstr("\n"));
}

TEST_F(ConfigFile, ErrorsNameFileAndLine) {
  const auto refused{[&](const std::string& text, std::initializer_list<std::string_view> parts) {
    expect_error<ConfigError>([&] { static_cast<void>(load(text)); }, parts);
  }};
  refused("grid:\n  lenght_m: 30\n", {"c.yaml", "line 2", "lenght_m"});
  refused("matching.disparities: many\n", {"c.yaml", "line 1", "many"});
  refused("grid: {length_m: [1, 2]}\n", {"line 1", "is a number, not '1,2'"});
  refused("filter: {speeds_mps: [1, [2]]}\n", {"line 1", "filter.speeds_mps is not a list of numbers"});
  refused("filter: {speeds_mps: [1, fast]}\n", {"line 1", "not 'fast'"});
  refused("grid: {length_m: 1\n", {"c.yaml", "not YAML"});
  refused("just text\n", {"c.yaml", "no settings"});
  refused("a: 1\nb: 2\n", {"line 1"});
  Config config;
  expect_error([&] { load_config(folder_ / "none.yaml", config); }, {"none.yaml", "no such file"});
}

}  // namespace
}  // namespace stereogrid::io::testing

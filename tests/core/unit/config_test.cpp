// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/config.hpp"

#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

struct Entry {
  std::string key;
  Parameter parameter;
};

std::vector<Entry> entries() {
  std::vector<Entry> all;
  const Config config;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    all.push_back({std::string{group} + "." + std::string{parameter.name}, parameter});
  });
  return all;
}

std::string message_of_set(std::string_view key, std::string_view text) {
  Config config;
  return error_text_of<ConfigError>([&] { set(config, key, text); });
}

bool mentions(const std::vector<std::string>& sentences, std::string_view words) {
  return std::any_of(sentences.begin(), sentences.end(),
                     [&](const std::string& sentence) { return sentence.find(words) != std::string::npos; });
}

TEST(Config, NamesAreUniqueAndDescribed) {
  std::set<std::string> keys;
  for (const Entry& entry : entries()) {
    EXPECT_TRUE(keys.insert(entry.key).second) << entry.key;
    EXPECT_FALSE(entry.parameter.sentence.empty()) << entry.key;
    EXPECT_EQ(entry.parameter.sentence.back(), '.') << entry.key;
    EXPECT_LT(entry.parameter.minimum, entry.parameter.maximum) << entry.key;
  }
  EXPECT_GT(keys.size(), 30u);
}

TEST(Config, DefaultsLieInTheirRanges) {
  for (const std::string& name : preset_names()) {
    const Config config{preset(name)};
    EXPECT_EQ(problems(config), std::vector<std::string>{}) << name;
    visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto& value) {
      const auto expect_within = [&](double number) {
        EXPECT_GE(number, parameter.minimum) << group << "." << parameter.name;
        EXPECT_LE(number, parameter.maximum) << group << "." << parameter.name;
      };
      if constexpr (std::is_same_v<decltype(value), const std::vector<double>&>) {
        std::ranges::for_each(value, expect_within);
      } else {
        expect_within(static_cast<double>(value));
      }
    });
  }
}

TEST(Config, PaperPresetHasThePapersValues) {
  const Config config{preset("paper")};
  EXPECT_EQ(config.grid.length_m, 20);
  EXPECT_EQ(config.grid.width_m, 20);
  EXPECT_EQ(config.grid.cell_size_m, 0.2);
  EXPECT_EQ(config.matching.window_px, 21);
  EXPECT_FALSE(config.matching.subpixel);
  EXPECT_EQ(config.u_disparity.obstacle_height_m, 1.8);
  EXPECT_EQ(config.paper.false_positive, 0.02);
  EXPECT_EQ(config.paper.false_negative, 0.02);
  EXPECT_EQ(config.paper.tau_obstacle, 0.1);
  EXPECT_EQ(config.paper.tau_road, 0.1);
  EXPECT_EQ(config.paper.sigma_disparity, 0.5);
  EXPECT_EQ(config.paper.sigma_column, 1.5);
  EXPECT_EQ(config.paper.road_rays, RoadRays::none);
  EXPECT_EQ(config.paper.small_count_guard, 0);
  EXPECT_FALSE(config.paper.left_border);
  EXPECT_EQ(config.filter.model, FilterModel::tay2008);
  EXPECT_EQ(config.filter.likelihood_exponent, 1);
  EXPECT_EQ(config.filter.static_prior, 0) << "all velocities alike";
}

TEST(Config, RobotPresetHasASmallFineGrid) {
  const GridConfig grid{preset("robot").grid};
  EXPECT_EQ(grid.length_m, 6);
  EXPECT_EQ(grid.width_m, 6);
  EXPECT_EQ(grid.cell_size_m, 0.05);
}

TEST(Config, PresetsAreFoundByName) {
  EXPECT_EQ(preset_names(), (std::vector<std::string>{"default", "robot", "paper"}));
  EXPECT_EQ(get(preset("default"), "grid.length_m"), "20");
  EXPECT_NE(error_text_of<ConfigError>([] { static_cast<void>(preset("papper")); }).find("paper"), std::string::npos);
}

// Values of one preset, written as text and read into the other preset, arrive unchanged.
TEST(Config, TextGoesThereAndBackForEveryParameter) {
  for (const auto& [from, to] : {std::pair{"paper", "default"}, std::pair{"default", "paper"}}) {
    const Config source{preset(from)};
    Config target{preset(to)};
    for (const Entry& entry : entries()) set(target, entry.key, get(source, entry.key));
    for (const Entry& entry : entries()) EXPECT_EQ(get(target, entry.key), get(source, entry.key)) << entry.key;
  }
}

TEST(Config, SetReachesOnlyTheNamedParameter) {
  for (const Entry& entry : entries()) {
    const Config untouched;
    Config config;
    const std::string before{get(config, entry.key)};
    const bool is_switch{before == "true" || before == "false"};
    std::string other{before == "true" ? "false" : "true"};
    if (!is_switch) {
      other = "7";
      if (before == "visible" || before == "none") other = before == "none" ? "visible" : "none";
      if (before == "joint" || before == "tay2008") other = before == "joint" ? "tay2008" : "joint";
      if (entry.key == "projection.model") other = before == "rays" ? "bins" : "rays";
      if (entry.key == "ground.model") other = before == "plane" ? "terrain" : "plane";
    }
    set(config, entry.key, other);
    EXPECT_EQ(get(config, entry.key), other) << entry.key;
    for (const Entry& neighbour : entries()) {
      if (neighbour.key == entry.key) continue;
      EXPECT_EQ(get(config, neighbour.key), get(untouched, neighbour.key)) << entry.key << " changed " << neighbour.key;
    }
  }
}

TEST(Config, FractionsSurviveAsText) {
  Config config;
  config.grid.cell_size_m = 0.1;
  config.filter.decay_time_s = 1.0 / 3;
  Config copy;
  set(copy, "grid.cell_size_m", get(config, "grid.cell_size_m"));
  set(copy, "filter.decay_time_s", get(config, "filter.decay_time_s"));
  EXPECT_EQ(get(config, "grid.cell_size_m"), "0.1");
  EXPECT_EQ(copy.grid.cell_size_m, 0.1);
  EXPECT_EQ(copy.filter.decay_time_s, 1.0 / 3);
}

TEST(Config, UnknownKeySuggestsTheNearest) {
  EXPECT_NE(message_of_set("grid.lenght_m", "20").find("'grid.length_m'"), std::string::npos);
  EXPECT_NE(message_of_set("matching.windowpx", "21").find("'matching.window_px'"), std::string::npos);
  EXPECT_NE(message_of_set("left_borde", "true").find("'paper.left_border'"), std::string::npos);
  EXPECT_THROW(static_cast<void>(get(Config{}, "grid.height_m")), ConfigError);
}

TEST(Config, TextThatIsNoValueIsRefused) {
  EXPECT_NE(message_of_set("matching.window_px", "21.5").find("whole number"), std::string::npos);
  EXPECT_NE(message_of_set("grid.length_m", "twenty").find("'twenty'"), std::string::npos);
  EXPECT_NE(message_of_set("grid.length_m", "20 m").find("grid.length_m"), std::string::npos);
  EXPECT_NE(message_of_set("grid.length_m", "").find("grid.length_m"), std::string::npos);
  EXPECT_NE(message_of_set("ground.estimate", "maybe").find("true or false"), std::string::npos);
  const std::string choices{message_of_set("filter.model", "tay")};
  EXPECT_NE(choices.find("tay2008"), std::string::npos);
  EXPECT_NE(choices.find("joint"), std::string::npos);
  EXPECT_NE(message_of_set("matching.disparities", "99999999999"), "");
}

TEST(Config, SwitchesAreWrittenInManyWays) {
  Config config;
  for (const char* yes : {"true", "on", "yes", "1"}) {
    config.ground.estimate = false;
    set(config, "ground.estimate", yes);
    EXPECT_TRUE(config.ground.estimate) << yes;
  }
  for (const char* no : {"false", "off", "no", "0"}) {
    config.ground.estimate = true;
    set(config, "ground.estimate", no);
    EXPECT_FALSE(config.ground.estimate) << no;
  }
}

TEST(Config, ParametersOfThePaperAreFoundUnderTheirFormerGroup) {
  Config config;
  set(config, "u_disparity.tau_obstacle", "0.3");
  EXPECT_EQ(config.paper.tau_obstacle, 0.3);
  set(config, "filter.forgetting_s", "3.5");
  EXPECT_EQ(config.filter.decay_time_s, 3.5);
  EXPECT_THROW(set(config, "u_disparity.tau", "0.3"), ConfigError);
}

TEST(Config, TheFormerChoiceOfAMethodIsRefusedButForItsDefault) {
  Config config;
  EXPECT_NO_THROW(set(config, "matching.method", "correlation"));
  EXPECT_EQ(error_text_of<ConfigError>([&] { set(config, "matching.method", "semi_global"); }),
            "matching.method: semi_global (allowed: correlation, the only method). Remove it.");
}

TEST(Config, AllProblemsAreReportedAtOnce) {
  Config config;
  config.grid.length_m = -1;
  config.matching.window_px = 12;
  config.matching.disparities = 300;
  config.paper.false_positive = 0.7;
  config.filter.speeds_mps = uniform_speeds(0.5, 120);
  const std::vector<std::string> found{problems(config)};
  EXPECT_EQ(found.size(), 5u);
  EXPECT_TRUE(mentions(found, "grid.length_m is -1"));
  EXPECT_TRUE(mentions(found, "matching.window_px is 12 and must be odd"));
  EXPECT_TRUE(mentions(found, "matching.disparities is 300"));
  EXPECT_TRUE(mentions(found, "paper.false_positive is 0.7"));
  EXPECT_TRUE(mentions(found, "velocities"));
}

TEST(Config, SizesThatTwoParametersGiveTogetherNameBoth) {
  const auto only_problem_of = [](const char* key, const char* value, const char* other, const char* other_value) {
    Config config;
    set(config, key, value);
    set(config, other, other_value);
    const std::vector<std::string> found{problems(config)};
    EXPECT_EQ(found.size(), 1u) << key;
    return found.empty() ? std::string{} : found[0];
  };
  EXPECT_EQ(only_problem_of("grid.length_m", "1", "grid.cell_size_m", "5"),
            "grid.length_m is 1, grid.cell_size_m is 5: no cell along that side (allowed 1 … 4000). Take smaller cells "
            "or a larger grid.");
  EXPECT_EQ(only_problem_of("grid.width_m", "500", "grid.cell_size_m", "0.1"),
            "grid.width_m is 500, grid.cell_size_m is 0.1: more than 4000 cells along that side (allowed 1 … 4000). "
            "Take larger cells or a smaller grid.");
  EXPECT_EQ(only_problem_of("u_disparity.obstacle_min_height_m", "2", "u_disparity.obstacle_height_m", "1.8"),
            "u_disparity.obstacle_min_height_m is 2, u_disparity.obstacle_height_m is 1.8: no height is left for "
            "obstacles. Take a minimum height below the other.");
  EXPECT_EQ(
      only_problem_of("vehicle.step_max_m", "0.5", "vehicle.height_m", "0.5"),
      "vehicle.step_max_m is 0.5, vehicle.height_m is 0.5: no height is left for obstacles. Take a step below the "
      "vehicle's height.");
  Config one_cell;
  one_cell.grid = {2.5, 2.6, 5};
  EXPECT_TRUE(problems(one_cell).empty());
}

TEST(Config, BothEndsOfARangeAreAllowedAndNothingBeyond) {
  Config config;
  config.filter.likelihood_exponent = 1;
  config.filter.velocity_noise = 0.0001;
  EXPECT_TRUE(problems(config).empty());
  config.filter.likelihood_exponent = 1.0001;
  config.filter.velocity_noise = 0.000099;
  EXPECT_EQ(problems(config).size(), 2u);
}

TEST(Config, NotANumberIsAProblem) {
  Config config;
  set(config, "grid.width_m", "nan");
  EXPECT_TRUE(mentions(problems(config), "grid.width_m"));
}

TEST(Config, TooManyCellsAreAProblem) {
  Config config;
  config.grid.length_m = 500;
  config.grid.cell_size_m = 0.1;
  EXPECT_TRUE(mentions(problems(config), "4000 cells"));
}

TEST(Config, VelocitiesAreFewAndGrow) {
  Config config;
  config.filter.speeds_mps = uniform_speeds(0.5, 25);
  EXPECT_TRUE(mentions(problems(config), "1000 velocities"));
  for (const char* text : {"2,1", "1,1", "0.01,1", "1,61", "nan", "1,nan"}) {
    set(config, "filter.speeds_mps", text);
    EXPECT_TRUE(mentions(problems(config), "filter.speeds_mps")) << text;
  }
  set(config, "filter.speeds_mps", "none");
  EXPECT_TRUE(problems(config).empty()) << "standstill alone";
}

TEST(Config, AListIsNumbersWithCommas) {
  Config config;
  set(config, "filter.speeds_mps", "1, 2.5,4");
  EXPECT_EQ(config.filter.speeds_mps, (std::vector<double>{1, 2.5, 4}));
  EXPECT_EQ(get(config, "filter.speeds_mps"), "1,2.5,4");
  for (const char* text : {"1,,2", ",1", "1,", "1;2", "fast", "1 2", "none,1"}) {
    EXPECT_THROW(set(config, "filter.speeds_mps", text), ConfigError) << text;
  }
  EXPECT_EQ(config.filter.speeds_mps.size(), 3u) << "unchanged";
}

// Texts of files, names and settings as they are.
TEST(Errors, QuotedBytesArePrintable) {
  EXPECT_STREQ(ConfigError{"a \xff\nb \x1b"}.what(), "a \\xFF\nb \\x1B") << "lines of a message stay";
  EXPECT_STREQ(InputError{"a \xff\nb \x1b"}.what(), "a \\xFF\nb \\x1B");
  EXPECT_STREQ(DeviceError{"a \xff\nb \x1b"}.what(), "a \\xFF\nb \\x1B");
  const InputError error{"fi\xffle", "has 'a\nb'.", "Put \xfe right."};
  EXPECT_STREQ(error.what(), "fi\\xFFle: has 'a\\x0Ab'. Put \\xFE right.");
}

TEST(Errors, MessagesAreOfBoundedLength) {
  const std::string lines(1'000'000, '\n');
  const std::string file(4'000, 'f');
  for (const std::string& longest : {lines, std::string(1'000'000, '\xff')}) {
    EXPECT_LT(std::string{ConfigError{longest}.what()}.size(), 17'000U);
    EXPECT_LT(std::string{InputError{longest}.what()}.size(), 17'000U);
    EXPECT_LT(std::string{DeviceError{longest}.what()}.size(), 17'000U);
    const std::string message{InputError{file, longest, longest}.what()};
    EXPECT_LT(message.size(), 9'000U);
    EXPECT_EQ(message.rfind(file + ": ", 0), 0U) << "paths are never shortened";
  }
}

TEST(Errors, SettingsAreQuotedPrintable) {
  Config config;
  for (const char* const key : {"no\xff", "grid.length_m", "ground.estimate", "ground.model"}) {
    const std::string text{error_text_of<ConfigError>([&] { set(config, key, "\xff"); })};
    EXPECT_NE(text.find("\\xFF"), std::string::npos) << key << ": " << text;
  }
}

}  // namespace
}  // namespace stereogrid::test

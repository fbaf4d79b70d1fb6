// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/text.hpp"

#include <nlohmann/json.hpp>

#include "stereogrid/io/config_file.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using Json = nlohmann::json;

struct Shown {
  std::string text;
  std::string shown;
};

TEST(Printable, KeepsUtf8AndShowsOtherBytesAsNumbers) {
  for (const Shown& one : std::vector<Shown>{{"plain text", "plain text"},
                                             {"Straße – 日本 😀", "Straße – 日本 😀"},
                                             {"", ""},
                                             {"a\nb\t\x1b[31m\x7f", "a\\x0Ab\\x09\\x1B[31m\\x7F"},
                                             {std::string{"a\0b", 3}, "a\\x00b"},
                                             {"fr\xe4me", "fr\\xE4me"},                     // Latin-1
                                             {"\xc3", "\\xC3"},                             // cut off
                                             {"\xe2\x82", "\\xE2\\x82"},                    // cut off
                                             {"\xc0\xaf", "\\xC0\\xAF"},                    // longer than needed
                                             {"\xe0\x80\xaf", "\\xE0\\x80\\xAF"},           // longer than needed
                                             {"\xed\xa0\x80", "\\xED\\xA0\\x80"},           // a surrogate
                                             {"\xf4\x90\x80\x80", "\\xF4\\x90\\x80\\x80"},  // above U+10FFFF
                                             {"\xf5\xff", "\\xF5\\xFF"},
                                             {"\xc2\x9b", "\\xC2\\x9B"}}) {  // a control character of two bytes
    EXPECT_EQ(printable(one.text), one.shown);
  }
}

TEST(Printable, IsOfBoundedLengthAndCutBetweenCharacters) {
  EXPECT_EQ(printable("abcdef", 6), "abcdef");
  EXPECT_EQ(printable("abcdefg", 6), "abcdef…");
  EXPECT_EQ(printable("abcdeß", 6), "abcde…");
  EXPECT_EQ(printable("abcd\n", 6), "abcd…");
  EXPECT_LT(printable(std::string(100'000, '\xff')).size(), 210U);
  EXPECT_EQ(frame_name(std::string(300, 'x')), std::string(300, 'x'));
  EXPECT_EQ(printable_path(fs::path{std::string(3000, 'x') + "\xff"}), std::string(3000, 'x') + "\\xFF");
}

TEST(JsonText, NeverThrows) {
  const Json json({{"na\xffme", "te\xfft"}, {"cut", "\xc3"}});
  EXPECT_THROW(static_cast<void>(json.dump()), Json::exception) << "else this test shows nothing";
  EXPECT_EQ(Json::parse(json_text(json))["cut"], "\xef\xbf\xbd");
  EXPECT_EQ(json_text(Json({{"a", 1}}), 1), "{\n \"a\": 1\n}");
}

void read(std::string_view text) {
  read_json<Json>("run.json", text, "line 3 ", "Mend it.", [](const Json& json) {
    static_cast<void>(whole_number(json, "n", 0, 10));
    static_cast<void>(number(json, "x", 5));
  });
}

TEST(ReadJson, NamesTheFileWhateverIsWrong) {
  EXPECT_NO_THROW(read(R"({"n": 10, "x": -5})"));
  for (const std::string& text : std::vector<std::string>{"",
                                                          "{",
                                                          "nonsense",
                                                          "[]",
                                                          "null",
                                                          "3",
                                                          "\"text\"",
                                                          "{}",
                                                          std::string{"\0", 1},
                                                          "{\"n\": \"\xff\"}",
                                                          R"({"n": 11, "x": 1})",
                                                          R"({"n": -1, "x": 1})",
                                                          R"({"n": 1.5, "x": 1})",
                                                          R"({"n": 1e300, "x": 1})",
                                                          R"({"n": 18446744073709551615, "x": 1})",
                                                          R"({"n": null, "x": 1})",
                                                          R"({"n": "1", "x": 1})",
                                                          R"({"n": true, "x": 1})",
                                                          R"({"n": 1, "x": 5.1})",
                                                          R"({"n": 1, "x": -1e300})",
                                                          R"({"n": 1, "x": null})",
                                                          R"({"n": 1, "x": [1]})",
                                                          R"({"n": 1, "x": "1"})"}) {
    expect_error([&] { read(text); }, {"run.json: line 3 is not understood", "Mend it."});
  }
}

TEST(ReadJson, IsNotDrivenOverTheEndOfTheStack) {
  const std::string brackets(1'000'000, '[');
  expect_error([&] { read(brackets); }, {"run.json", "nested too deeply"});
  expect_error([&] { read("{\"a\":" + brackets); }, {"nested too deeply"});
  const auto nested{[](int depth) { return std::string(depth, '[') + std::string(depth, ']'); }};
  EXPECT_FALSE(is_nested_too_deeply(nested(64)));
  EXPECT_TRUE(is_nested_too_deeply(nested(65)));
  EXPECT_FALSE(is_nested_too_deeply(R"(["\"[[)" + brackets + R"("])")) << "brackets in a text are no brackets";
}

TEST(GridGeometryOfJson, IsOneThatCanBeWorkedOn) {
  const Json good({{"x_min_m", 0}, {"y_min_m", -10}, {"cell_size_m", 0.2}, {"nx", 100}, {"ny", 100}});
  EXPECT_EQ(grid_geometry(good).nx, 100);
  for (const auto& [key, values] :
       std::map<std::string, std::vector<Json>>{{"cell_size_m", {0, -1, 1e-9, 1e9, nullptr, "1"}},
                                                {"nx", {0, -3, 1'000'000'000, 4'294'967'297, 3.5, nullptr, "3"}},
                                                {"ny", {0, -3}},
                                                {"x_min_m", {1e300, nullptr}},
                                                {"y_min_m", {-1e300}}}) {
    for (const Json& value : values) {
      Json bad(good);
      bad[key] = value;
      expect_error([&] { return grid_geometry(bad); }, {key});
    }
  }
}

struct ConfigFile : FolderTest {
  [[nodiscard]] Config load(const std::string& text) const {
    put(folder / "c.yaml", text);
    Config config{preset("default")};
    load_config(folder / "c.yaml", config);
    return config;
  }
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
    expect_error<ConfigError>([&] { return load(text); }, parts);
  }};
  refused("grid:\n  lenght_m: 30\n", {"c.yaml", "line 2", "lenght_m"});
  refused("matching.disparities: many\n", {"c.yaml", "line 1", "many"});
  refused("grid: {length_m: [1, 2]}\n", {"line 1", "is a number, not '1,2'"});
  refused("filter: {speeds_mps: [1, [2]]}\n", {"line 1", "filter.speeds_mps is not a list of numbers"});
  refused("filter: {speeds_mps: [1, fast]}\n", {"line 1", "not 'fast'"});
  refused("grid: {length_m: 1\n", {"c.yaml", "not YAML"});
  refused("just text\n", {"c.yaml", "no settings"});
  refused("a: 1\nb: 2\n", {"line 1"});
  refused("grid:\n  length_m:\n", {"line 2", "grid.length_m has no value"});
  refused("gird:\n", {"line 1", "'gird'"});
  Config config;
  expect_error([&] { load_config(folder / "none.yaml", config); }, {"none.yaml", "no such file"});
}

// RFC 4648, section 10
TEST(Base64, HasPadding) {
  for (const Shown& one : std::vector<Shown>{
           {"", ""}, {"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foobar", "Zm9vYmFy"}, {"\xfb\xff", "+/8="}}) {
    EXPECT_EQ(base64(one.text), one.shown);
  }
}

}  // namespace
}  // namespace stereogrid::io::testing

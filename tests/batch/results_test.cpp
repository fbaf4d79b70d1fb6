// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <optional>

#include "batch/merge.hpp"
#include "batch/results.hpp"
#include "batch/sha256.hpp"
#include "batch/status.hpp"
#include "locks/folder_lock.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::app::batch::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

using BatchResults = Folder;

/// A result that the runner could have left.
void finish_shard(const fs::path& plan, const Shard& shard, double missed = 0.5) {
  const ShardPlaces places{plan, shard.digest};
  const fs::path work{plan / "making"};
  io::create_folder(work / "grids");
  const Json figures{{"occupancy.3-20.missed", {missed, 10}}};
  std::ofstream{work / "figures.json"} << figures.dump();
  std::ofstream{work / "timing.json"} << Json{{"frames", 10}, {"seconds", 2.0}, {"host", "h"}}.dump();
  std::ofstream{work / "grids" / "0.npz"} << "grid of " << shard.number;
  write_done(work,
             {.digest = shard.digest, .content = "", .frames = 10, .skipped = 0, .seconds = 2, .cost = 1, .files = {}});
  ASSERT_TRUE(publish(work, places.result));
}

TEST_F(BatchResults, AreCheckedByteByByte) {
  std::ofstream{*this / "a"} << "one";
  fs::create_directory(*this / "b");
  std::ofstream{*this / "b" / "c"} << "two";
  write_done(path(), {.digest = "d", .content = "", .frames = 3, .skipped = 1, .seconds = 2, .cost = 4, .files = {}});
  const auto done{read_done(path())};
  ASSERT_TRUE(done);
  EXPECT_EQ(done->files.size(), 2U);
  EXPECT_EQ(done->files[1].sha256, sha256_of("two"));
  EXPECT_EQ(difference(path(), *done), "");
  std::ofstream{*this / "b" / "c"} << "twO";
  EXPECT_THAT(difference(path(), *done), HasSubstr("b/c has another checksum"));
  std::ofstream{*this / "b" / "c"} << "twos";
  EXPECT_THAT(difference(path(), *done), HasSubstr("4 bytes, not 3"));
  std::ofstream{*this / "b" / "more"} << "x";
  EXPECT_THAT(difference(path(), *done), HasSubstr("b/more does not belong there"));
  fs::remove_all(*this / "b");
  EXPECT_THAT(difference(path(), *done), HasSubstr("b/c is missing"));
}

TEST_F(BatchResults, ContentIsWithoutTimes) {
  std::vector<PartFile> files{{"a", 1, "x"}, {"timing.json", 1, "y"}};
  const std::string content{content_digest(files)};
  files[1].sha256 = "z";
  EXPECT_EQ(content_digest(files), content);
  files[0].sha256 = "z";
  EXPECT_NE(content_digest(files), content);
}

TEST_F(BatchResults, TheFirstOneStays) {
  fs::create_directories(*this / "one");
  std::ofstream{*this / "one" / "file"} << "1";
  fs::create_directories(*this / "two");
  std::ofstream{*this / "two" / "file"} << "2";
  EXPECT_TRUE(publish(*this / "one", *this / "results" / "r"));
  EXPECT_FALSE(publish(*this / "two", *this / "results" / "r"));
  EXPECT_EQ(io::read_file(*this / "results" / "r" / "file"), "1");
}

TEST_F(BatchResults, StatusCountsWhatThereIs) {
  const Plan plan{write_plan(*this / "plan", 8)};
  const PlanReader reader{*this / "plan"};
  for (const std::size_t number : {0, 1, 5}) finish_shard(reader.folder(), reader.shard(number));
  std::optional<FolderLock> runner{ShardPlaces{reader.folder(), reader.shard(2).digest}.work};
  io::create_folder(ShardPlaces{reader.folder(), reader.shard(3).digest}.work);
  write_failure(ShardPlaces{reader.folder(), reader.shard(6).digest}.failed, {"d", 6, 65, "bad \"input\"", "h"});
  const Status status{status_of(reader)};
  EXPECT_EQ(status.done, 3U);
  EXPECT_EQ(status.running, 1U);
  EXPECT_EQ(status.stopped, 1U);
  EXPECT_EQ(status.failed, 1U);
  EXPECT_EQ(status.missing, 2U);
  EXPECT_EQ(status.frames_done, 30U);
  EXPECT_DOUBLE_EQ(status.frames_per_second, 5);
  EXPECT_EQ(text_of(status.to_do), "3-4,7");
  ASSERT_EQ(status.failures.size(), 1U);
  EXPECT_EQ(status.failures[0].message, "bad \"input\"");
  runner.reset();
  EXPECT_EQ(status_of(reader).running, 0U);
  EXPECT_EQ(text_of(status_of(reader).to_do), "2-4,7");
}

TEST_F(BatchResults, MergeNamesWhatIsMissing) {
  write_plan(*this / "plan", 4);
  const PlanReader reader{*this / "plan"};
  finish_shard(reader.folder(), reader.shard(1));
  try {
    merge(reader, {*this / "out", false, false});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("3 of 4 shards have no result: 0,2-3"));
  }
  EXPECT_FALSE(fs::exists(*this / "out"));
  merge(reader, {*this / "out", true, false});
  EXPECT_THAT(io::read_file(*this / "out" / "summary.json"), HasSubstr("\"missing\": 3"));
  EXPECT_THROW(merge(reader, {*this / "out", true, false}), ConfigError) << "not empty";
}

TEST_F(BatchResults, MergeDoesNotDependOnTheOrder) {
  for (const char* name : {"a", "b"}) {
    write_plan(*this / name, 3);
    const PlanReader reader{*this / name};
    for (const std::size_t number : {0, 1, 2}) {
      const std::size_t shard{*name == 'a' ? number : 2 - number};
      finish_shard(reader.folder(), reader.shard(shard), 0.1 * static_cast<double>(shard));
    }
    merge(reader, {path() / (std::string{name} + "-out"), false, false});
  }
  for (const char* file : {"parts.jsonl", "drives.jsonl", "summary.json", "summary.html"}) {
    EXPECT_EQ(io::read_file(*this / "a-out" / file), io::read_file(*this / "b-out" / file)) << file;
  }
}

TEST_F(BatchResults, MergeRefusesDamage) {
  write_plan(*this / "plan", 2);
  const PlanReader reader{*this / "plan"};
  for (const std::size_t number : {0, 1}) finish_shard(reader.folder(), reader.shard(number));
  const fs::path result{ShardPlaces{reader.folder(), reader.shard(1).digest}.result};
  std::ofstream{result / "grids" / "0.npz"} << "grid of 2";
  try {
    merge(reader, {*this / "out", false, false});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("grids/0.npz has another checksum"));
    EXPECT_THAT(error.what(), HasSubstr("--shard 1"));
  }
}

TEST(BatchFigures, AreTheSingleNumbersOfAnEvaluation) {
  const Json evaluation{{"series",
                         {{"occupancy",
                           {{"bands",
                             {{"3-20",
                               {{"frames", 8},
                                {"missed", {{"value", 0.25}, {"low", nullptr}, {"high", nullptr}}},
                                {"auc", {{"value", nullptr}, {"low", nullptr}, {"high", nullptr}}},
                                {"roc", {1, 2}}}}}},
                            {"motion", {{"ghost_s", 0.5}, {"survived_s", nullptr}}}}}}},
                        {"obstacles", {{"found", 0.75}, {"by_kind", {{"car", 1}}}}}};
  const Figures figures{figures_of(evaluation, 10)};
  EXPECT_EQ(figures.size(), 3U);
  EXPECT_DOUBLE_EQ(figures.at("occupancy.3-20.missed").value, 0.25);
  EXPECT_DOUBLE_EQ(figures.at("occupancy.3-20.missed").frames, 8);
  EXPECT_DOUBLE_EQ(figures.at("occupancy.motion.ghost_s").frames, 10);
  EXPECT_DOUBLE_EQ(figures.at("obstacles.found").value, 0.75);
  EXPECT_EQ(to_json(figures_in(to_json(figures))), to_json(figures));
}

TEST(BatchFigures, PartsCountByTheirFrames) {
  Figures drive;
  add_part(drive, {{"a", {1, 10}}});
  add_part(drive, {{"a", {4, 20}}, {"b", {2, 1}}});
  EXPECT_DOUBLE_EQ(drive.at("a").value, 3);
  EXPECT_DOUBLE_EQ(drive.at("a").frames, 30);
  EXPECT_DOUBLE_EQ(drive.at("b").value, 2);
}

// intervals of both kinds hold the mean's true error for a known spread
TEST(BatchFigures, IntervalsAreOverDrives) {
  for (const int drives : {400, 4000}) {
    FiguresOverDrives all;
    for (int i{0}; i < drives; ++i) all.add({{"a", {i % 2 == 0 ? 0.0 : 1.0, 5}}});
    const FigureOverDrives figure{all.means().at("a")};
    const double half{1.96 * 0.5 / std::sqrt(drives)};
    EXPECT_DOUBLE_EQ(figure.value, 0.5);
    EXPECT_NEAR(figure.low, 0.5 - half, 0.15 * half) << drives;
    EXPECT_NEAR(figure.high, 0.5 + half, 0.15 * half) << drives;
  }
  FiguresOverDrives one;
  one.add({{"a", {1, 5}}});
  EXPECT_GT(one.means().at("a").low, one.means().at("a").high);
}

TEST(BatchSummaryPage, EscapesAndPlots) {
  const auto variant = [](const char* name, double missed, double false_alarms) {
    const auto figure = [](double v) { return Json{{"value", v}, {"low", nullptr}, {"high", nullptr}, {"drives", 1}}; };
    return Json{{"swept", {name}},
                {"drives", 1},
                {"frames", 2},
                {"figures",
                 {{"occupancy.3-20.missed", figure(missed)}, {"occupancy.3-20.false_alarms", figure(false_alarms)}}}};
  };
  Json summary{{"plan", std::string(64, 'a')},
               {"version", "1"},
               {"drives", 1},
               {"shards", 2},
               {"missing", 0},
               {"failed", 0},
               {"frames", 2},
               {"planned", 3},
               {"skipped", 0}};
  summary["variants"] = {variant("<b>", .1, .2), variant("good", .2, .1), variant("worse", .3, .3)};
  const std::string page{summary_page(summary)};
  EXPECT_THAT(page, Not(HasSubstr("<b>")));
  EXPECT_THAT(page, HasSubstr("<li>good</li>"));
  EXPECT_THAT(page, HasSubstr("<li>&lt;b&gt;</li>"));
  EXPECT_THAT(page, Not(HasSubstr("<li>worse</li>")));
}

}  // namespace
}  // namespace stereogrid::app::batch::testing

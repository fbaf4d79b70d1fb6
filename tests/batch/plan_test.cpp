// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "batch/inputs.hpp"
#include "batch/sha256.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::app::batch::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using BatchPlan = Folder;

template <class Error, class Action>
std::string complaint(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no complaint";
}

// FIPS 180-4's examples, and lengths around its blocks of 64 bytes from Python's hashlib
TEST(BatchSha256, IsThatOfTheStandard) {
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_of(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(BatchSha256, DoesNotDependOnThePieces) {
  std::string text;
  for (int i{0}; i < 200; ++i) text += static_cast<char>(i);
  for (std::size_t piece{1}; piece < 130; ++piece) {
    Sha256 sha;
    for (std::size_t at{0}; at < text.size(); at += piece) sha.add(std::string_view{text}.substr(at, piece));
    EXPECT_EQ(sha.hex(), sha256_of(text)) << piece;
  }
}

TEST(BatchNumbers, AreWrittenAsRanges) {
  EXPECT_EQ(text_of({}), "");
  const std::vector<std::uint64_t> numbers{3, 4, 5, 7, 12, 13};
  EXPECT_EQ(text_of(numbers), "3-5,7,12-13");
  EXPECT_EQ(text_of(numbers, 2), "3-5,7, and more");
  EXPECT_EQ(text_of(numbers, 3), "3-5,7,12-13");
  EXPECT_EQ(numbers_in(text_of(numbers), 14), numbers);
}

TEST(BatchNumbers, RefuseOtherText) {
  for (const char* text : {"", "a", "3-", "-3", "5-3", "3,,4", "3,", "1-2-3", "0x3", "3:7", " 3"}) {
    EXPECT_THROW(static_cast<void>(numbers_in(text, 100)), ConfigError) << text;
  }
  EXPECT_THAT(complaint<ConfigError>([] { static_cast<void>(numbers_in("3-100", 100)); }), HasSubstr("has 100"));
}

TEST(BatchSweep, MakesEveryCombination) {
  EXPECT_THAT(combinations({}), ElementsAre(IsEmpty()));
  EXPECT_THAT(combinations({"a.b=1,2", "c=x|y,z"}),
              ElementsAre(ElementsAre("a.b=1", "c=x"), ElementsAre("a.b=1", "c=y,z"), ElementsAre("a.b=2", "c=x"),
                          ElementsAre("a.b=2", "c=y,z")));
  for (const char* bad : {"a", "a=", "=1", "a=1,", "a=1,,2", "a=1,1"}) {
    EXPECT_THROW(static_cast<void>(combinations({bad})), ConfigError) << bad;
  }
  const std::string many{"a=0,1,2,3,4,5,6,7,8,9"};
  EXPECT_THROW(static_cast<void>(combinations({many, many, many, many, many})), ConfigError);
}

TEST_F(BatchPlan, IsReadAsItWasWritten) {
  const Plan plan{write_plan(*this / "plan", 5)};
  const PlanReader reader{*this / "plan"};
  EXPECT_EQ(reader.plan().digest, plan.digest);
  EXPECT_EQ(reader.plan().frames, 50U);
  EXPECT_EQ(reader.plan().variants.at(0).settings, plan.variants.at(0).settings);
  std::vector<Shard> all;
  reader.for_each([&](const Shard& shard) { all.push_back(shard); });
  ASSERT_EQ(all.size(), 5U);
  for (std::size_t i{0}; i < 5; ++i) {
    EXPECT_EQ(reader.shard(i), all[i]);
    EXPECT_EQ(all[i].number, i);
  }
  EXPECT_THROW(static_cast<void>(reader.shard(5)), InputError);
}

TEST_F(BatchPlan, SaysTheSameTwice) {
  write_plan(*this / "a", 3);
  write_plan(*this / "b", 3);
  for (const char* file : {"plan.json", "manifest.jsonl", "manifest.index"}) {
    EXPECT_EQ(io::read_file(*this / "a" / file), io::read_file(*this / "b" / file)) << file;
  }
  EXPECT_THROW(write_plan(*this / "a", 3), ConfigError);
}

// only settings that affect the result change the name of its folder
TEST_F(BatchPlan, DigestIsOfAllThatDecides) {
  const Plan plan{simple_plan()};
  const Shard shard{simple_shard(10, 20)};
  const std::string digest{digest_of(shard, plan)};
  const auto with = [&](auto change) {
    Shard changed{shard};
    Plan changed_plan{plan};
    change(changed, changed_plan);
    return digest_of(changed, changed_plan);
  };
  EXPECT_EQ(with([](Shard& s, Plan&) { s.number = 7, s.drive = "other", s.cost = 1; }), digest);
  EXPECT_EQ(with([](Shard&, Plan& p) { p.shards = 7, p.memory_mb = 1; }), digest);
  EXPECT_NE(with([](Shard& s, Plan&) { s.first = 11; }), digest);
  EXPECT_NE(with([](Shard& s, Plan&) { s.end = 11; }), digest);
  EXPECT_NE(with([](Shard& s, Plan&) { s.warm_up = 1; }), digest);
  EXPECT_NE(with([](Shard& s, Plan&) { s.input_digest = "0"; }), digest);
  EXPECT_NE(with([](Shard& s, Plan&) { s.input = {"scene:boxes"}; }), digest);
  EXPECT_NE(with([](Shard&, Plan& p) { p.version = "2"; }), digest);
  EXPECT_NE(with([](Shard&, Plan& p) { p.run["device"] = "cuda"; }), digest);
  EXPECT_NE(with([](Shard&, Plan& p) { p.variants[0].settings = {}; }), digest);
  EXPECT_NE(with([](Shard&, Plan& p) { p.variants[0].config["grid"]["length_m"] = 31; }), digest);
}

void replace(const fs::path& file, const std::string& what, const std::string& by) {
  std::string text{io::read_file(file)};
  const std::size_t at{text.find(what)};
  ASSERT_NE(at, std::string::npos);
  text.replace(at, what.size(), by);
  std::ofstream{file, std::ios::binary} << text;
}

TEST_F(BatchPlan, TellsThatItWasChanged) {
  write_plan(*this / "plan", 3);
  replace(*this / "plan" / "manifest.jsonl", "\"end\":20", "\"end\":21");
  const PlanReader reader{*this / "plan"};
  EXPECT_NO_THROW(static_cast<void>(reader.shard(0)));
  EXPECT_THAT(complaint<InputError>([&] { static_cast<void>(reader.shard(1)); }), HasSubstr("changed"));
  EXPECT_THAT(complaint<InputError>([&] { reader.for_each([](const Shard&) {}); }), HasSubstr("changed"));
}

TEST_F(BatchPlan, DamageIsToldOf) {
  EXPECT_THAT(complaint<InputError>([&] { PlanReader{path()}; }), HasSubstr("holds no plan"));
  for (const char* text : {"", "{", "[]", "{\"format\":2}", "{\"format\":1}"}) {
    std::ofstream{*this / "plan.json"} << text;
    EXPECT_THROW(PlanReader{path()}, InputError) << text;
  }
  write_plan(*this / "plan", 3);
  fs::resize_file(*this / "plan" / "manifest.index", 12);
  EXPECT_THROW(static_cast<void>(PlanReader{*this / "plan"}.shard(0)), InputError);
  fs::resize_file(*this / "plan" / "manifest.jsonl", 100);
  EXPECT_THROW(PlanReader{*this / "plan"}.for_each([](const Shard&) {}), InputError);
  fs::remove(*this / "plan" / "manifest.jsonl");
  EXPECT_THROW(PlanReader{*this / "plan"}.for_each([](const Shard&) {}), InputError);
}

using BatchInputs = Folder;

TEST_F(BatchInputs, DigestSeesWhatChanges) {
  fs::create_directories(*this / "drive" / "left");
  std::ofstream{*this / "drive" / "calibration.yaml"} << "a";
  std::ofstream{*this / "drive" / "left" / "0.png"} << "123";
  const auto digest = [&](DigestOf what) { return input_digest({(*this / "drive").string()}, what); };
  const std::string names{digest(DigestOf::names_and_sizes)};
  const std::string content{digest(DigestOf::content)};
  fs::rename(*this / "drive", *this / "moved");
  EXPECT_EQ(input_digest({(*this / "moved").string()}, DigestOf::content), content);
  fs::rename(*this / "moved", *this / "drive");
  std::ofstream{*this / "drive" / "left" / "0.png"} << "124";
  EXPECT_EQ(digest(DigestOf::names_and_sizes), names) << "of an image only the size counts";
  EXPECT_NE(digest(DigestOf::content), content);
  std::ofstream{*this / "drive" / "calibration.yaml"} << "b";
  EXPECT_NE(digest(DigestOf::names_and_sizes), names);
  EXPECT_THROW(static_cast<void>(input_digest({(*this / "none").string()}, DigestOf::content)), InputError);
}

TEST_F(BatchInputs, ListsAndPatternsAreExpanded) {
  for (const char* name : {"b", "a", "c"}) fs::create_directories(*this / name);
  std::ofstream{*this / "list.txt"} << "# drives\n\n  " << (*this / "c").string() << "  \r\nscene:street?frames=2\n";
  const std::string pattern{(*this / "[ab]").string()};
  const auto real = [&](const char* name) { return fs::canonical(*this / name).string(); };
  EXPECT_THAT(expand_inputs({pattern, '@' + (*this / "list.txt").string()}),
              ElementsAre(real("a"), real("b"), real("c"), "scene:street?frames=2"));
  EXPECT_THROW(static_cast<void>(expand_inputs({(*this / "x*").string()})), InputError);
  EXPECT_THROW(static_cast<void>(expand_inputs({"@" + (*this / "none").string()})), InputError);
  DriveNames names;
  EXPECT_EQ(names.name_of("/x/0009"), "0009");
  EXPECT_EQ(names.name_of("/y/0009"), "0009-2");
  EXPECT_EQ(names.name_of("scene:street?a/b"), "street?a_b");
}

}  // namespace
}  // namespace stereogrid::app::batch::testing

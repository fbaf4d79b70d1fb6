// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr int format{1};
constexpr std::size_t offset_bytes{8};
constexpr const char* mend{"Make the plan anew: stereogrid batch plan."};

std::array<char, offset_bytes> bytes_of(std::uint64_t offset) {
  std::array<char, offset_bytes> bytes{};
  for (std::size_t i{0}; i < offset_bytes; ++i) bytes[i] = static_cast<char>(offset >> (8 * i) & 0xff);
  return bytes;
}

std::uint64_t offset_in(const char* bytes) {
  std::uint64_t offset{0};
  for (std::size_t i{offset_bytes}; i-- > 0;) offset = offset << 8 | static_cast<unsigned char>(bytes[i]);
  return offset;
}

Json to_json(const Variant& variant) {
  return {{"swept", variant.swept}, {"settings", variant.settings}, {"config", variant.config}};
}

Json to_json(const Plan& plan) {
  Json variants(Json::array());
  for (const Variant& variant : plan.variants) variants.push_back(to_json(variant));
  return {{"format", format},      {"version", plan.version},     {"digest", plan.digest},
          {"shards", plan.shards}, {"drives", plan.drives},       {"frames", plan.frames},
          {"cost", plan.cost},     {"memory_mb", plan.memory_mb}, {"content_digests", plan.content_digests},
          {"run", plan.run},       {"variants", variants},        {"left_out", plan.left_out}};
}

Plan plan_of(const Json& json) {
  constexpr std::int64_t most{1'000'000'000'000};
  if (io::whole_number(json, "format", 0, 1000) != format) throw InputError{"its format is of another version"};
  const auto count = [&](const char* key) { return static_cast<std::uint64_t>(io::whole_number(json, key, 0, most)); };
  Plan plan{.version = json.at("version"),
            .digest = json.at("digest"),
            .shards = count("shards"),
            .drives = count("drives"),
            .frames = count("frames"),
            .cost = json.at("cost").get<double>(),
            .memory_mb = count("memory_mb"),
            .content_digests = json.at("content_digests").get<bool>(),
            .run = json.at("run"),
            .variants = {},
            .left_out = json.at("left_out")};
  for (const Json& variant : json.at("variants")) {
    plan.variants.push_back({variant.at("swept"), variant.at("settings"), variant.at("config")});
  }
  return plan;
}

std::string digest_of(Plan plan, const std::string& manifest_digest) {
  plan.digest.clear();
  return sha256_of(manifest_digest + io::json_text(to_json(plan)));
}

std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t number{0};
  const auto [end, error]{std::from_chars(text.data(), text.data() + text.size(), number)};
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

std::string text_of(const std::vector<std::uint64_t>& numbers, std::size_t most) {
  std::string text;
  for (std::size_t first{0}, ranges{0}; first < numbers.size(); ++ranges) {
    std::size_t last{first};
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    if (ranges == most) return text + ", and more";
    text += fmt::format("{}{}", ranges == 0 ? "" : ",", numbers[first]);
    if (last > first) text += fmt::format("-{}", numbers[last]);
    first = last + 1;
  }
  return text;
}

std::vector<std::uint64_t> numbers_in(const std::string& text, std::uint64_t end) {
  std::vector<std::uint64_t> numbers;
  for (std::size_t at{0}; at <= text.size();) {
    const std::size_t comma{std::min(text.find(',', at), text.size())};
    const std::string_view range{std::string_view{text}.substr(at, comma - at)};
    const std::size_t dash{range.find('-')};
    const auto first{number_in(range.substr(0, dash))};
    const auto last{dash == std::string_view::npos ? first : number_in(range.substr(dash + 1))};
    if (!first || !last || *last < *first) {
      throw ConfigError{
          fmt::format("--shard {}: not a list of shard numbers. Give one such as 3-7,12.", io::printable(text))};
    }
    if (*last >= end) {
      throw ConfigError{fmt::format("--shard {}: the plan has {} shards, numbered from 0.", *last, end)};
    }
    for (std::uint64_t number{*first}; number <= *last; ++number) numbers.push_back(number);
    at = comma + 1;
  }
  return numbers;
}

Json to_json(const Shard& shard) {
  return {{"shard", shard.number},    {"digest", shard.digest},
          {"drive", shard.drive},     {"input", shard.input},
          {"first", shard.first},     {"end", shard.end},
          {"warm_up", shard.warm_up}, {"input_digest", shard.input_digest},
          {"variant", shard.variant}, {"cost", shard.cost}};
}

Shard shard_of(const Json& line) {
  constexpr std::int64_t most{1'000'000'000'000};
  const auto count = [&](const char* key) { return static_cast<std::size_t>(io::whole_number(line, key, 0, most)); };
  Shard shard{.number = count("shard"),
              .digest = line.at("digest"),
              .drive = line.at("drive"),
              .input = line.at("input"),
              .first = count("first"),
              .end = count("end"),
              .warm_up = count("warm_up"),
              .input_digest = line.at("input_digest"),
              .variant = count("variant"),
              .cost = line.at("cost").get<double>()};
  if (shard.input.empty() || shard.input.size() > 2) throw InputError{"'input' names no input"};
  if (shard.end <= shard.first) throw InputError{"it has no frames"};
  if (shard.digest.size() != 64 || shard.digest.find_first_not_of("0123456789abcdef") != std::string::npos) {
    throw InputError{"'digest' is none"};
  }
  return shard;
}

std::string digest_of(const Shard& shard, const Plan& plan) {
  const Variant& variant{plan.variants.at(shard.variant)};
  const Json all{{"version", plan.version},  {"run", plan.run},      {"settings", variant.settings},
                 {"config", variant.config}, {"input", shard.input}, {"input_digest", shard.input_digest},
                 {"first", shard.first},     {"end", shard.end},     {"warm_up", shard.warm_up}};
  return sha256_of(io::json_text(all));
}

PlanWriter::PlanWriter(fs::path folder) : folder_{std::move(folder)} {
  if (io::is_there(folder_ / "plan.json")) {
    throw ConfigError{
        fmt::format("{} already holds a plan. Give another folder for the new one.", io::printable_path(folder_))};
  }
  io::create_folder(folder_);
  manifest_.open(folder_ / "manifest.jsonl", std::ios::binary | std::ios::trunc);
  index_.open(folder_ / "manifest.index", std::ios::binary | std::ios::trunc);
  check();
}

void PlanWriter::check() const {
  if (manifest_ && index_) return;
  throw DeviceError{
      fmt::format("{}: the manifest cannot be written. Check the folder's permissions and the space there.",
                  io::printable_path(folder_))};
}

void PlanWriter::add(Shard shard, const Plan& plan) {
  shard.number = shards_++;
  shard.digest = batch::digest_of(shard, plan);
  frames_ += shard.end - shard.first;
  cost_ += shard.cost;
  const std::string line{io::json_text(batch::to_json(shard)) + '\n'};
  index_.write(bytes_of(offset_).data(), offset_bytes);
  manifest_ << line;
  sha_.add(line);
  offset_ += line.size();
  check();
}

void PlanWriter::finish(Plan& plan) {
  index_.write(bytes_of(offset_).data(), offset_bytes);
  manifest_.close();
  index_.close();
  check();
  plan.shards = shards_;
  plan.frames = frames_;
  plan.cost = cost_;
  plan.digest = digest_of(plan, sha_.hex());
  io::write_file(folder_ / "plan.json", io::json_text(to_json(plan), 1) + '\n');
}

PlanReader::PlanReader(fs::path folder) : folder_{std::move(folder)} {
  const fs::path file{folder_ / "plan.json"};
  if (!io::is_there(file)) {
    throw InputError{io::printable_path(folder_), "holds no plan.",
                     "Give the folder that `stereogrid batch plan --out` has left."};
  }
  io::read_json<Json>(io::printable_path(file), io::read_file(file, io::largest_bytes::json), "", mend,
                      [this](const Json& json) { plan_ = plan_of(json); });
}

void PlanReader::damaged(const char* file, const std::string& what) const {
  throw InputError{io::printable_path(folder_ / file), what, mend};
}

Shard PlanReader::shard(std::uint64_t number) const {
  std::ifstream index{folder_ / "manifest.index", std::ios::binary};
  std::array<char, 2 * offset_bytes> place{};
  index.seekg(static_cast<std::streamoff>(number * offset_bytes));
  if (!index.read(place.data(), place.size())) damaged("manifest.index", "is missing or cut off.");
  const std::uint64_t begin{offset_in(place.data())};
  const std::uint64_t end{offset_in(place.data() + offset_bytes)};
  constexpr std::uint64_t longest_line{1 << 20};
  if (end <= begin || end - begin > longest_line) damaged("manifest.index", "is damaged.");
  std::string line(end - begin, '\0');
  std::ifstream manifest{folder_ / "manifest.jsonl", std::ios::binary};
  manifest.seekg(static_cast<std::streamoff>(begin));
  if (!manifest.read(line.data(), static_cast<std::streamsize>(line.size()))) {
    damaged("manifest.jsonl", "is missing or cut off.");
  }
  Shard shard;
  io::read_json<Json>(io::printable_path(folder_ / "manifest.jsonl"), line, fmt::format("line {} ", number + 1), mend,
                      [&](const Json& json) { shard = shard_of(json); });
  if (shard.number != number || shard.variant >= plan_.variants.size() ||
      shard.digest != batch::digest_of(shard, plan_)) {
    damaged("manifest.jsonl", fmt::format("line {} does not have its own digest: it has been changed.", number + 1));
  }
  return shard;
}

void PlanReader::for_each(const std::function<void(const Shard&)>& take) const {
  std::ifstream manifest{folder_ / "manifest.jsonl", std::ios::binary};
  Sha256 sha;
  std::string line;
  std::uint64_t number{0};
  while (std::getline(manifest, line)) {
    io::read_json<Json>(io::printable_path(folder_ / "manifest.jsonl"), line, fmt::format("line {} ", number + 1), mend,
                        [&](const Json& json) {
                          const Shard shard{shard_of(json)};
                          if (shard.number != number || shard.variant >= plan_.variants.size()) {
                            throw InputError{"its 'shard' or 'variant' is not in order"};
                          }
                          take(shard);
                        });
    line += '\n';
    sha.add(line);
    ++number;
  }
  if (number != plan_.shards || digest_of(plan_, sha.hex()) != plan_.digest) {
    damaged("manifest.jsonl", "does not have the digest that plan.json says: it has been changed.");
  }
}

}  // namespace stereogrid::app::batch

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/status.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <system_error>

#include "locks/folder_lock.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t most_looked_at{300};
constexpr std::size_t most_failures{100};

/// Parses the first 16 digits of a name: "0123456789abcdef", "….json", "….host-4711".
std::optional<std::uint64_t> number_in(const std::string& name) {
  constexpr std::size_t digits{16};
  std::uint64_t number{0};
  if (name.size() < digits) return std::nullopt;
  const auto [end, error]{std::from_chars(name.data(), name.data() + digits, number, 16)};
  return error == std::errc{} && end == name.data() + digits ? std::optional{number} : std::nullopt;
}

template <class Take>
void for_each_below(const fs::path& folder, Take take) {
  if (!io::is_folder(folder)) return;
  for (const fs::path& among : io::entries_of(folder)) {
    if (!io::is_folder(among)) continue;
    for (const fs::path& entry : io::entries_of(among)) {
      if (const auto number{number_in(entry.filename().string())}) take(*number, entry);
    }
  }
}

std::vector<std::uint64_t> numbers_below(const fs::path& folder) {
  std::vector<std::uint64_t> numbers;
  for_each_below(folder, [&](std::uint64_t number, const fs::path&) { numbers.push_back(number); });
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

bool contains(const std::vector<std::uint64_t>& sorted, std::uint64_t number) {
  return std::binary_search(sorted.begin(), sorted.end(), number);
}

/// Speed of runners, from some of the results.
class Speed {
 public:
  explicit Speed(const PlanReader& plan)
      : plan_{plan}, step_{std::max<std::uint64_t>(plan.plan().shards / most_looked_at, 1)} {}

  void look_at(const Shard& shard) {
    if (shard.number % step_ != 0) return;
    try {
      const auto done{read_done(ShardPlaces{plan_.folder(), shard.digest}.result)};
      if (!done) return;
      // includes frames that --every leaves unwritten
      frames_ += std::max(0.0, static_cast<double>(shard.end - shard.first) - static_cast<double>(done->skipped));
      cost_ += shard.cost;
      seconds_ += done->seconds;
    } catch (const InputError&) {
      return;  // merge reports it
    }
  }
  [[nodiscard]] double frames_per_second() const { return seconds_ > 0 ? frames_ / seconds_ : 0; }
  [[nodiscard]] double seconds_for(double cost) const { return cost_ > 0 ? cost * seconds_ / cost_ : 0; }

 private:
  const PlanReader& plan_;
  std::uint64_t step_;
  double frames_{0};
  double cost_{0};
  double seconds_{0};
};

void note_failure(const PlanReader& plan, const Shard& shard, Status& status) {
  if (status.failures.size() >= most_failures) return;
  try {
    if (auto failure{read_failure(ShardPlaces{plan.folder(), shard.digest}.failed)}) {
      status.failures.push_back(std::move(*failure));
    }
  } catch (const InputError& error) {
    status.failures.push_back({shard.digest, shard.number, 0, error.what(), ""});
  }
}

/// Moves the frames that a result lacks from those that are done to those that are skipped.
void count_skipped(const PlanReader& plan, const Shard& shard, Status& status) {
  try {
    const auto done{read_done(ShardPlaces{plan.folder(), shard.digest}.result)};
    const std::uint64_t skipped{done ? std::min<std::uint64_t>(done->skipped, shard.end - shard.first) : 0};
    status.frames_done -= skipped;
    status.frames_skipped += skipped;
  } catch (const InputError&) {
    return;  // merge reports it
  }
}

void count(const Shard& shard, ShardState state, Status& status) {
  status.frames += shard.end - shard.first;
  if (state == ShardState::done) {
    ++status.done;
    status.frames_done += shard.end - shard.first;
  } else if (state == ShardState::failed) {
    ++status.failed;
  } else {
    status.cost_left += shard.cost;
    ++(state == ShardState::running ? status.running : state == ShardState::stopped ? status.stopped : status.missing);
    if (state != ShardState::running) status.to_do.push_back(shard.number);
  }
}

}  // namespace

ShardStates::ShardStates(const fs::path& plan)
    : done_{numbers_below(plan / "results")},
      failed_{numbers_below(plan / "failed")},
      skipped_{numbers_below(plan / "skipped")} {
  for_each_below(plan / "work", [&](std::uint64_t number, const fs::path& work) {
    (is_locked(work) ? running_ : stopped_).push_back(number);
  });
  std::sort(running_.begin(), running_.end());
  std::sort(stopped_.begin(), stopped_.end());
}

ShardState ShardStates::of(const std::string& digest) const {
  const std::uint64_t number{number_in(digest).value_or(0)};
  if (contains(done_, number)) return ShardState::done;
  if (contains(failed_, number)) return ShardState::failed;
  if (contains(running_, number)) return ShardState::running;
  return contains(stopped_, number) ? ShardState::stopped : ShardState::missing;
}

bool ShardStates::has_skipped(const std::string& digest) const {
  return contains(skipped_, number_in(digest).value_or(0));
}

Status status_of(const PlanReader& plan) {
  const ShardStates states{plan.folder()};
  Status status;
  Speed speed{plan};
  status.shards = plan.plan().shards;
  plan.for_each([&](const Shard& shard) {
    const ShardState state{states.of(shard.digest)};
    count(shard, state, status);
    if (state == ShardState::done && states.has_skipped(shard.digest)) count_skipped(plan, shard, status);
    if (state == ShardState::done) speed.look_at(shard);
    if (state == ShardState::failed) note_failure(plan, shard, status);
  });
  status.frames_per_second = speed.frames_per_second();
  if (status.running > 0)
    status.seconds_left = speed.seconds_for(status.cost_left) / static_cast<double>(status.running);
  return status;
}

Json to_json(const Status& status) {
  Json failures(Json::array());
  for (const Failure& failure : status.failures) {
    failures.push_back({{"shard", failure.shard},
                        {"exit_code", failure.exit_code},
                        {"message", failure.message},
                        {"host", failure.host}});
  }
  return {{"shards", status.shards},
          {"done", status.done},
          {"running", status.running},
          {"stopped", status.stopped},
          {"missing", status.missing},
          {"failed", status.failed},
          {"frames", status.frames},
          {"frames_done", status.frames_done},
          {"frames_skipped", status.frames_skipped},
          {"frames_per_second_of_a_runner", status.frames_per_second},
          {"seconds_left", status.seconds_left},
          {"to_do", text_of(status.to_do)},
          {"failures", failures}};
}

}  // namespace stereogrid::app::batch

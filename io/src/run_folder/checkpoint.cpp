// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/run_folder/checkpoint.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <string>
#include <system_error>

#include "stereogrid/error.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/paths.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;
using Arrays = std::map<std::string, NpyArray>;

constexpr const char* file_name{"state.npz"};
constexpr std::size_t landmark_floats{7};
static_assert(sizeof(OdometryState::Landmark) == landmark_floats * sizeof(float));

// world_from_reference, world_from_last, reference_from_last, both covariances, unmeasured_s, then the speed if there
// is one.
constexpr std::size_t numbers_without_speed{3 + 3 + 12 + 2 * 9 + 1};
constexpr std::size_t speed_numbers{6};

std::vector<double> numbers_of(const OdometryState& state) {
  std::vector<double> numbers;
  for (const Pose2& pose : {state.world_from_reference, state.world_from_last}) {
    numbers.insert(numbers.end(), {pose.x_m, pose.y_m, pose.yaw_rad});
  }
  numbers.insert(numbers.end(), state.reference_from_last.begin(), state.reference_from_last.end());
  for (const auto* covariance : {&state.covariance_at_reference, &state.covariance_since_reference}) {
    numbers.insert(numbers.end(), covariance->begin(), covariance->end());
  }
  numbers.push_back(state.unmeasured_s);
  if (state.speed) numbers.insert(numbers.end(), state.speed->begin(), state.speed->end());
  return numbers;
}

void take_numbers(const std::vector<double>& numbers, OdometryState& state) {
  const double* next{numbers.data()};
  for (Pose2* pose : {&state.world_from_reference, &state.world_from_last}) {
    *pose = {next[0], next[1], next[2]};
    next += 3;
  }
  std::copy_n(next, state.reference_from_last.size(), state.reference_from_last.begin());
  next += state.reference_from_last.size();
  for (auto* covariance : {&state.covariance_at_reference, &state.covariance_since_reference}) {
    std::copy_n(next, covariance->size(), covariance->begin());
    next += covariance->size();
  }
  state.unmeasured_s = *next++;
  if (numbers.size() > numbers_without_speed) std::copy_n(next, speed_numbers, state.speed.emplace().begin());
}

class CheckpointFile {
 public:
  explicit CheckpointFile(fs::path path) : path_{std::move(path)}, arrays_{read_npz(path_)} {}

  [[nodiscard]] bool has(const char* name) const { return arrays_.contains(name); }

  template <class T>
  [[nodiscard]] std::vector<T> values(const char* name) const {
    const auto found{arrays_.find(name)};
    require(found != arrays_.end() && found->second.dtype == dtype_of<T>());
    return found->second.template to<T>();
  }

  [[nodiscard]] Image<std::uint8_t> image(const char* name) const {
    const auto found{arrays_.find(name)};
    require(found != arrays_.end() && found->second.shape.size() == 2);
    return found->second.to_image<std::uint8_t>();
  }

  void require(bool condition) const {
    if (condition) return;
    throw InputError{path_.string(), "is not a saved state of a run.", "Remove it: the run then restarts."};
  }

 private:
  fs::path path_;
  Arrays arrays_;
};

OdometryState odometry_in(const CheckpointFile& file) {
  OdometryState state;
  state.reference = file.image("odometry_reference");
  const std::vector<float> landmarks{file.values<float>("odometry_landmarks")};
  file.require(landmarks.size() % landmark_floats == 0);
  state.landmarks.resize(landmarks.size() / landmark_floats);
  std::memcpy(state.landmarks.data(), landmarks.data(), landmarks.size() * sizeof(float));
  const std::vector<double> numbers{file.values<double>("odometry_numbers")};
  file.require(numbers.size() == numbers_without_speed || numbers.size() == numbers_without_speed + speed_numbers);
  take_numbers(numbers, state);
  const std::vector<std::int64_t> stamp{file.values<std::int64_t>("odometry_stamp_ns")};
  if (!stamp.empty()) state.last_stamp_ns = stamp.front();
  return state;
}

}  // namespace

void write_checkpoint(const fs::path& run_folder, const Checkpoint& checkpoint) {
  const std::vector<std::int64_t> index{static_cast<std::int64_t>(checkpoint.index)};
  const std::span<const std::uint8_t> pipeline{reinterpret_cast<const std::uint8_t*>(checkpoint.pipeline.data()),
                                               checkpoint.pipeline.size()};
  std::vector<NpzArray> arrays{{"index", {1}, index}, {"pipeline", {pipeline.size()}, pipeline}};
  std::vector<double> numbers;
  std::vector<std::int64_t> stamp;
  if (const auto& odometry{checkpoint.odometry}) {
    numbers = numbers_of(*odometry);
    if (odometry->last_stamp_ns) stamp.push_back(*odometry->last_stamp_ns);
    const std::span<const float> landmarks{reinterpret_cast<const float*>(odometry->landmarks.data()),
                                           odometry->landmarks.size() * landmark_floats};
    arrays.emplace_back("odometry_reference", odometry->reference);
    arrays.push_back({"odometry_landmarks", {odometry->landmarks.size(), landmark_floats}, landmarks});
    arrays.push_back({"odometry_numbers", {numbers.size()}, numbers});
    arrays.push_back({"odometry_stamp_ns", {stamp.size()}, stamp});
  }
  write_npz(run_folder / file_name, arrays);
}

void remove_torn_checkpoint(const fs::path& run_folder) {
  std::error_code ignored;
  fs::remove(run_folder / (std::string{"."} + file_name + ".partial"), ignored);
}

std::optional<Checkpoint> read_checkpoint(const fs::path& run_folder) {
  if (!is_there(run_folder / file_name)) return std::nullopt;
  const CheckpointFile file{run_folder / file_name};
  const std::vector<std::int64_t> index{file.values<std::int64_t>("index")};
  file.require(index.size() == 1 && index.front() >= 0);
  const std::vector<std::uint8_t> pipeline{file.values<std::uint8_t>("pipeline")};
  Checkpoint checkpoint;
  checkpoint.index = static_cast<std::size_t>(index.front());
  checkpoint.pipeline.resize(pipeline.size());
  std::memcpy(checkpoint.pipeline.data(), pipeline.data(), pipeline.size());
  if (file.has("odometry_reference")) checkpoint.odometry = odometry_in(file);
  return checkpoint;
}

}  // namespace stereogrid::io

// SPDX-License-Identifier: Apache-2.0
#include "run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "evaluate/output.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {
namespace {

std::ptrdiff_t frames_of_stereo_alone(const io::RunRecord& record) {
  return std::ranges::count_if(record.finished(), [](const io::FrameSummary& frame) {
    return std::ranges::any_of(frame.warnings,
                               [](const Warning& warning) { return warning.text.starts_with(stereo_alone); });
  });
}

/// "match 10.7, …, other 3.1, total 47.6": stages that take time.
std::string stage_times(const io::RunRecord& record) {
  std::string text;
  double rest_ms{0};
  for (const io::StageField& stage : io::stage_fields) {
    constexpr double least_ms{0.05};
    const double median_ms{record.timing(stage.milliseconds).p50};
    if (stage.milliseconds == &StageTimes::total) {
      rest_ms += median_ms;
      if (rest_ms >= least_ms) text += fmt::format("other {:.1f}, ", rest_ms);
      return text + fmt::format("total {:.1f}", median_ms);
    }
    if (stage.milliseconds != &StageTimes::odometry) rest_ms -= median_ms;
    if (median_ms >= least_ms) text += fmt::format("{} {:.1f}, ", stage.name, median_ms);
  }
  return text;
}

/// Truth with which `evaluate` scores the run; "": none.
std::string truth_of(const Input& input) {
  if (input.scene != nullptr || input.recording->has_truth()) return "exact truth";
  if (input.recording->has_scans()) return "lidar";
  return has_object_labels(input) ? "labelled objects" : "";
}

std::string row(const std::string& what, const std::string& text) {
  return fmt::format("  {:<10} {}\n", what, text);
}

std::string rows_of_continuation(const RunOptions& options) {
  std::string left_out;
  if (!options.video.empty()) left_out += ", without --video";
  if (!options.messages.mcap.empty()) left_out += ", without --mcap";
  return row("continue", fmt::format("the same command{}{}", options.resume ? "" : " with --resume", left_out));
}

}  // namespace

std::string shell_word(const std::string& word) {
  const bool is_plain{std::ranges::all_of(word, [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter >= 0x80 ||
           std::string_view{"_-./:,=+@%"}.find(static_cast<char>(letter)) != std::string_view::npos;
  })};
  if (is_plain && !word.empty()) return word;
  std::string quoted{"'"};
  for (const char letter : word) quoted += letter == '\'' ? "'\\''" : std::string(1, letter);
  return quoted + '\'';
}

std::string summary_of(const RunOptions& options, const Input& input, const io::RunRecord& record, int frames,
                       const RunSeconds& seconds, bool is_complete) {
  const std::string folder{io::printable_path(record.folder())};
  std::string text{
      is_complete ? fmt::format("{} frames", record.finished().size())
                  : fmt::format("stopped after {} of {} frames", record.finished().size(), record.frames_to_write())};
  text += fmt::format(", {} of {} skipped, {:.2f} frames per second\n", record.skipped().size(),
                      record.range().end - record.range().first, seconds.total > 0 ? frames / seconds.total : 0);
  if (frames > 0) {
    text += fmt::format("seconds: pipeline {:.1f}, reading {:.1f}, writing {:.1f}, total {:.1f}\n",
                        std::max(0.0, seconds.total - seconds.reading - seconds.writing), seconds.reading,
                        seconds.writing, seconds.total);
  }
  text += fmt::format("median ms per frame: {}\n", stage_times(record));
  const std::ptrdiff_t alone{frames_of_stereo_alone(record)};
  if (alone > 0) text += fmt::format("{} of {} frames had no lidar\n", alone, record.finished().size());
  text += fmt::format("results in {}\n", folder);
  if (!is_complete) text += rows_of_continuation(options);
  if (record.finished().empty()) return text;
  if (!options.pictures.empty()) text += row("pictures", folder + "/pictures");
  if (!options.video.empty() && is_complete) text += row("video", io::printable_path(options.video));
  if (!options.messages.mcap.empty()) text += row("recording", io::printable_path(options.messages.mcap));
  const std::vector<std::string> layers{layers_of(options)};
  const auto has{[&](const char* layer) { return layers.empty() || std::ranges::count(layers, layer) > 0; }};
  if (has("occupancy")) text += row("view", "stereogrid view " + shell_word(folder));
  const std::string truth{has("observed") && has("occupancy") && has("velocity") ? truth_of(input) : ""};
  if (!truth.empty()) text += row("evaluate", fmt::format("stereogrid evaluate {}  ({})", shell_word(folder), truth));
  return text;
}

}  // namespace stereogrid::app

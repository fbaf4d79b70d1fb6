// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/scores.hpp"

#include <utility>

#include "batch/attempts.hpp"
#include "batch/figures.hpp"
#include "batch/quiet_log.hpp"
#include "evaluate/evaluate.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/run_folder/description.hpp"

namespace stereogrid::app::batch {

std::string without_place(std::string text, const std::filesystem::path& work,
                          const std::map<std::string, std::string>& copies) {
  return io::without_copies(std::move(text), [&] {
    std::map<std::string, std::string> places{copies};
    places["work"] = work.string();
    return places;
  }());
}

Json scores_of(const RunOptions& run, const std::filesystem::path& work) {
  try {
    if (!can_be_scored(open_input(run.input))) return {};
    const QuietLog quiet;
    EvaluateOptions options;
    options.run = run.folder;
    options.copies = run.copies;
    return to_json(figures_of(json_of(evaluate(options)), static_cast<double>(finished_frames(run.folder))));
  } catch (const InputError& error) {
    return {{"not scored", without_place(error.what(), work, run.copies)}};
  }
}

}  // namespace stereogrid::app::batch

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <exception>
#include <stdexcept>
#include <vector>

#include "backend/cpu.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid {

void process_together(std::span<Pipeline* const> pipelines, std::span<const StereoFrame> frames,
                      std::span<FrameResult> results) {
  if (pipelines.size() != frames.size() || frames.size() != results.size()) {
    throw std::invalid_argument{"process_together: each pipeline needs a frame and a result."};
  }
  std::vector<Pipeline*> sorted(pipelines.begin(), pipelines.end());
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
    throw std::invalid_argument{"process_together: a pipeline takes one frame at a time, this one is given two."};
  }
  std::vector<std::exception_ptr> errors(frames.size());
  Cpu{0}.for_ranges(static_cast<int>(frames.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      try {
        pipelines[i]->process(frames[i], results[i]);
      } catch (...) {
        errors[i] = std::current_exception();
      }
    }
  });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace stereogrid

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/damaged_frames.hpp"

#include <fmt/format.h>

#include <string>

#include "stereogrid/error.hpp"

namespace stereogrid::app {
namespace {

std::string why_skipped(const FrameSource& source, std::size_t index) {
  try {
    static_cast<void>(source.load(index));
  } catch (const InputError& error) {
    return error.what();
  }
  return "it could not be used then; the run was stopped before it had noted why.";
}

}  // namespace

StereoFrame first_usable_frame(const FrameSource& source, io::FrameRange range) {
  std::string first_error;
  for (std::size_t index{range.first}; index < range.end; ++index) {
    try {
      return source.load(index);
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  throw InputError{
      fmt::format("None of the {} frames can be used. The first one: {}", range.end - range.first, first_error)};
}

void recall_skipped(const FrameSource& source, io::RunRecord& record) {
  for (const std::size_t index : record.unaccounted()) {
    record.add_skipped({index, source.name(index), why_skipped(source, index)});
  }
}

}  // namespace stereogrid::app

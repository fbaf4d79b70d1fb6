// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/speckles.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "matching/surfaces_simd.hpp"

namespace stereogrid {
namespace {

constexpr std::size_t padding{64};

// Are these bits so in all eight flags from here on?
bool all_are(const std::uint8_t* flags, std::uint8_t mask, std::uint8_t wanted) {
  std::uint64_t eight{0};
  std::memcpy(&eight, flags, sizeof eight);
  constexpr std::uint64_t each{0x0101010101010101u};
  return (eight & mask * each) == wanted * each;
}

}  // namespace

Speckles::Speckles(int width, int height)
    : width_{width},
      labelled_(static_cast<std::size_t>(width) + 1 + padding),
      labelled_above_(static_cast<std::size_t>(width) + 1 + padding),
      flags_(static_cast<std::size_t>(width) + padding) {
  runs_.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) / 4 + 1);
}

int Speckles::find(int run) {
  Run* runs{runs_.data()};
  while (runs[run].parent >= 0) {
    const int next{runs[run].parent};
    if (runs[next].parent >= 0) runs[run].parent = runs[next].parent;
    run = next;
  }
  return run;
}

void Speckles::join(int a, int b) {
  a = find(a);
  b = find(b);
  if (a == b) return;
  Run* runs{runs_.data()};
  if (runs[a].parent > runs[b].parent) std::swap(a, b);
  runs[a].parent += runs[b].parent;
  runs[b].parent = a;
}

void Speckles::find_runs(int v) {
  constexpr std::uint8_t in_run{is_measured | continues_left};
  const std::uint8_t* flags{flags_.data()};
  int u{0};
  while (u < width_) {
    while (u + 8 <= width_ && all_are(flags + u, is_measured, 0)) u += 8;
    while (u < width_ && (flags[u] & is_measured) == 0) ++u;
    if (u >= width_) return;
    const int begin{u++};
    while (u + 8 <= width_ && all_are(flags + u, in_run, in_run)) u += 8;
    while (u < width_ && (flags[u] & continues_left) != 0) ++u;
    runs_.push_back({v, begin, u, begin - u});
  }
}

// Runs that overlap belong together if a pixel of the overlap continues the one above.
void Speckles::join_rows(std::size_t first_above, std::size_t first) {
  std::size_t above{first_above};
  std::size_t here{first};
  while (above < first && here < runs_.size()) {
    const int begin{std::max(runs_[above].begin, runs_[here].begin)};
    const int end{std::min(runs_[above].end, runs_[here].end)};
    const auto continues = [](std::uint8_t flags) { return (flags & continues_above) != 0; };
    if (begin < end && std::any_of(flags_.begin() + begin, flags_.begin() + end, continues)) {
      join(static_cast<int>(here), static_cast<int>(above));
    }
    if (runs_[above].end <= runs_[here].end) {
      ++above;
    } else {
      ++here;
    }
  }
}

void Speckles::remove(int speckle_px, Matches& matches) {
  if (speckle_px <= 1) return;
  runs_.clear();
  std::fill(labelled_.begin(), labelled_.end(), 0.0f);
  std::size_t first_above{0};
  for (int v{0}; v < matches.road.height(); ++v) {
    std::swap(labelled_, labelled_above_);
    labelled_[0] = 0;
    flag_surfaces(matches.obstacle.row(v), matches.road.row(v), labelled_above_.data() + 1, width_,
                  labelled_.data() + 1, flags_.data());
    const std::size_t first{runs_.size()};
    find_runs(v);
    join_rows(first_above, first);
    first_above = first;
  }
  for (int run{0}; run < static_cast<int>(runs_.size()); ++run) {
    if (-runs_[static_cast<std::size_t>(find(run))].parent >= speckle_px) continue;
    const Run& small{runs_[static_cast<std::size_t>(run)]};
    for (auto* image : {&matches.road, &matches.obstacle, &matches.confidence}) {
      std::fill(image->row(small.row) + small.begin, image->row(small.row) + small.end, 0.0f);
    }
  }
}

}  // namespace stereogrid

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/checks/speckles.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "matching/surfaces_simd.hpp"

namespace stereogrid {
namespace {

constexpr std::size_t padding{64};

// True if these bits are set in all eight flags from here on.
bool all_are(const std::uint8_t* flags, std::uint8_t mask, std::uint8_t wanted) {
  std::uint64_t eight{0};
  std::memcpy(&eight, flags, sizeof eight);
  constexpr std::uint64_t each{0x0101010101010101u};
  return (eight & mask * each) == wanted * each;
}

}  // namespace

Speckles::Speckles(int width, int height, int bands)
    : width_{width},
      pixels_{static_cast<std::size_t>(width) * static_cast<std::size_t>(height)},
      bands_(static_cast<std::size_t>(bands)),
      // not touched before it is needed, which most of it never is
      runs_{std::make_unique_for_overwrite<Run[]>(pixels_)} {
  for (Band& band : bands_) {
    band.labelled.resize(static_cast<std::size_t>(width) + 1 + padding);
    band.labelled_above = band.labelled;
    band.flags.resize(static_cast<std::size_t>(width) + padding);
  }
}

int Speckles::find(int run) {
  Run* runs{runs_.get()};
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
  Run* runs{runs_.get()};
  if (runs[a].parent > runs[b].parent) std::swap(a, b);
  runs[a].parent += runs[b].parent;
  runs[b].parent = a;
}

void Speckles::flag_row(int v, const Matches& matches, Band& band) const {
  std::swap(band.labelled, band.labelled_above);
  flag_surfaces(matches.obstacle.row(v), matches.road.row(v), band.labelled_above.data() + 1, width_,
                band.labelled.data() + 1, band.flags.data());
}

void Speckles::find_runs(int v, Band& band) {
  constexpr std::uint8_t in_run{is_measured | continues_left};
  const std::uint8_t* flags{band.flags.data()};
  Run* runs{runs_.get()};
  band.last_row.first = band.all.end;
  int u{0};
  while (u < width_) {
    while (u + 8 <= width_ && all_are(flags + u, is_measured, 0)) u += 8;
    while (u < width_ && (flags[u] & is_measured) == 0) ++u;
    if (u >= width_) break;
    const int begin{u++};
    while (u + 8 <= width_ && all_are(flags + u, in_run, in_run)) u += 8;
    while (u < width_ && (flags[u] & continues_left) != 0) ++u;
    runs[band.all.end++] = {v, begin, u, begin - u};
  }
  band.last_row.end = band.all.end;
}

// Runs that overlap belong together if a pixel of the overlap continues the one above.
void Speckles::join_rows(Runs above, Runs here, const std::vector<std::uint8_t>& flags) {
  const Run* runs{runs_.get()};
  int a{above.first};
  int h{here.first};
  while (a < above.end && h < here.end) {
    const int begin{std::max(runs[a].begin, runs[h].begin)};
    const int end{std::min(runs[a].end, runs[h].end)};
    const auto continues = [](std::uint8_t flag) { return (flag & continues_above) != 0; };
    if (begin < end && std::any_of(flags.begin() + begin, flags.begin() + end, continues)) join(h, a);
    if (runs[a].end <= runs[h].end) {
      ++a;
    } else {
      ++h;
    }
  }
}

void Speckles::find_patches(int band, int begin, int end, const Matches& matches) {
  Band& here{bands_[static_cast<std::size_t>(band)]};
  here.begin_row = begin;
  here.end_row = end;
  here.all = here.first_row = here.last_row = {begin * width_, begin * width_};
  std::fill(here.labelled.begin(), here.labelled.end(), 0.0f);
  for (int v{begin}; v < end; ++v) {
    const Runs above{here.last_row};
    flag_row(v, matches, here);
    find_runs(v, here);
    if (v == begin) here.first_row = here.last_row;
    join_rows(v == begin ? Runs{} : above, here.last_row, here.flags);
  }
}

void Speckles::join_bands(const Matches& matches) {
  const Band* above{nullptr};
  for (Band& band : bands_) {
    if (band.begin_row == band.end_row) continue;
    if (above != nullptr) {
      flag_row(band.begin_row - 1, matches, band);
      flag_row(band.begin_row, matches, band);
      join_rows(above->last_row, band.first_row, band.flags);
    }
    above = &band;
  }
}

void Speckles::remove_small(int band, const SpeckleSizes& smallest, Matches& matches) const {
  const Runs all{bands_[static_cast<std::size_t>(band)].all};
  for (int run{all.first}; run < all.end; ++run) {
    int patch{run};
    while (runs_[patch].parent >= 0) patch = runs_[patch].parent;
    const Run& small{runs_[run]};
    const bool is_obstacle{matches.obstacle(small.begin, small.row) > 0};
    if (-runs_[patch].parent >= (is_obstacle ? smallest.obstacle_px : smallest.road_px)) continue;
    for (auto* image : {&matches.road, &matches.obstacle, &matches.confidence}) {
      std::fill(image->row(small.row) + small.begin, image->row(small.row) + small.end, 0.0f);
    }
  }
}

void Speckles::remove(const SpeckleSizes& smallest, Matches& matches) {
  if (smallest.remove_nothing()) return;
  find_patches(0, 0, matches.road.height(), matches);
  remove_small(0, smallest, matches);
}

}  // namespace stereogrid

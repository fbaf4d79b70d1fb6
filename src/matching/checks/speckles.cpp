// SPDX-License-Identifier: Apache-2.0
#include "matching/checks/speckles.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace stereogrid {
namespace {

constexpr int word{64};
constexpr std::size_t padding{word};

// Calls work(u) for each bit of a row's word `w`.
template <class Work>
void for_bits(std::uint64_t bits, std::size_t w, const Work& work) {
  for (; bits != 0; bits &= bits - 1) work(static_cast<int>(w) * word + std::countr_zero(bits));
}

// Bits of a row's word `w`, each one pixel to the right.
std::uint64_t moved_right(const std::vector<std::uint64_t>& bits, std::size_t w) {
  return bits[w] << 1 | (w == 0 ? 0 : bits[w - 1] >> (word - 1));
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
    band.continues_left_above.resize(static_cast<std::size_t>(width / word + 1));
    band.bits = {band.continues_left_above, band.continues_left_above, band.continues_left_above};
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
  std::swap(band.bits.continues_left, band.continues_left_above);
  flag_surfaces(matches.obstacle.row(v), matches.road.row(v), band.labelled_above.data() + 1, width_,
                band.labelled.data() + 1, band.bits);
}

void Speckles::find_runs(int v, Band& band) {
  const SurfaceBits& bits{band.bits};
  Run* const runs{runs_.get()};
  int begun{band.all.end};
  int ended{begun};
  for (std::size_t w{0}; w < bits.is_measured.size(); ++w) {
    const std::uint64_t alone{~bits.continues_left[w]};
    for_bits(bits.is_measured[w] & alone, w, [&](int u) { runs[begun++] = {v, u, u, 0}; });
    for_bits(moved_right(bits.is_measured, w) & alone, w, [&](int u) {
      Run& run{runs[ended++]};
      run.end = u;
      run.parent = run.begin - u;
    });
  }
  band.last_row = {band.all.end, ended};
  band.all.end = ended;
}

// Runs belong together if a pixel of one continues that of the other above it. Of such pixels of a pair, which often
// follow each other, the first one is enough.
void Speckles::join_rows(Runs above, Runs here, const Band& band) {
  const SurfaceBits& bits{band.bits};
  const Run* const runs{runs_.get()};
  int a{above.first};
  int h{here.first};
  for (std::size_t w{0}; w < bits.continues_above.size(); ++w) {
    const std::uint64_t later{moved_right(bits.continues_above, w) & bits.continues_left[w] &
                              band.continues_left_above[w]};
    for_bits(bits.continues_above[w] & ~later, w, [&](int u) {
      while (runs[a].end <= u) ++a;
      while (runs[h].end <= u) ++h;
      join(h, a);
    });
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
    if (v > begin) join_rows(above, here.last_row, here);
  }
}

void Speckles::join_bands(const Matches& matches) {
  const Band* above{nullptr};
  for (Band& band : bands_) {
    if (band.begin_row == band.end_row) continue;
    if (above != nullptr) {
      flag_row(band.begin_row - 1, matches, band);
      flag_row(band.begin_row, matches, band);
      join_rows(above->last_row, band.first_row, band);
    }
    above = &band;
  }
}

void Speckles::remove_small(int band, const SpeckleSizes& smallest, Matches& matches) const {
  const int largest{std::max(smallest.obstacle_px, smallest.road_px)};
  const Runs all{bands_[static_cast<std::size_t>(band)].all};
  for (int run{all.first}; run < all.end; ++run) {
    int patch{run};
    while (runs_[patch].parent >= 0) patch = runs_[patch].parent;
    const int pixels{-runs_[patch].parent};
    if (pixels >= largest) continue;
    const Run& small{runs_[run]};
    const bool is_obstacle{matches.obstacle(small.begin, small.row) > 0};
    if (pixels >= (is_obstacle ? smallest.obstacle_px : smallest.road_px)) continue;
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

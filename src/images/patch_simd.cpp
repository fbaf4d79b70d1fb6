// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the rows of a patch; what is
// summed is summed by columns first, so results do not depend on how long vectors are: they are those of patch.cpp.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "images/patch_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                     // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "images/patch_formulas.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Columns = hn::CappedTag<float, patch_columns>;
using V = hn::Vec<Columns>;
constexpr std::size_t lanes{hn::MaxLanes(Columns{})};
constexpr std::size_t parts{patch_columns / lanes};

/// A row of a patch.
struct Row {
  V part[parts];

  // one that the compiler writes is compiled for no instruction set, which ARM's vectors do not let pass
  HWY_INLINE Row() {}
  HWY_INLINE static Row load(const float* values) {
    return of([values](std::size_t p) HWY_ATTR { return hn::LoadU(Columns{}, values + p * lanes); });
  }
  HWY_INLINE static Row load(const std::uint8_t* bytes) {
    return of([bytes](std::size_t p) HWY_ATTR {
      const hn::Rebind<std::int32_t, Columns> d32;
      const hn::Rebind<std::uint8_t, Columns> d8;
      return hn::ConvertTo(Columns{}, hn::PromoteTo(d32, hn::LoadU(d8, bytes + p * lanes)));
    });
  }
  HWY_INLINE static Row all(float value) {
    return of([value](std::size_t) HWY_ATTR { return hn::Set(Columns{}, value); });
  }
  HWY_INLINE void store(float* values) const {
    for (std::size_t p{0}; p < parts; ++p) hn::StoreU(part[p], Columns{}, values + p * lanes);
  }

  friend HWY_INLINE Row operator+(const Row& a, const Row& b) {
    return of([&](std::size_t p) HWY_ATTR { return hn::Add(a.part[p], b.part[p]); });
  }
  friend HWY_INLINE Row operator-(const Row& a, const Row& b) {
    return of([&](std::size_t p) HWY_ATTR { return hn::Sub(a.part[p], b.part[p]); });
  }
  friend HWY_INLINE Row operator*(const Row& a, const Row& b) {
    return of([&](std::size_t p) HWY_ATTR { return hn::Mul(a.part[p], b.part[p]); });
  }

 private:
  template <class Make>
  HWY_INLINE static Row of(const Make& make) {
    Row row;
    for (std::size_t p{0}; p < parts; ++p) row.part[p] = make(p);
    return row;
  }
};

// The second half is added to the first one, again and again.
#if HWY_TARGET == HWY_SCALAR
HWY_INLINE float sum_of_lanes(Columns, V value) {
  return hn::GetLane(value);
}
#else
template <class D>
HWY_INLINE float sum_of_lanes(D d, hn::Vec<D> values) {
  if constexpr (hn::MaxLanes(d) == 1) {
    return hn::GetLane(values);
  } else {
    const hn::Half<D> half;
    return sum_of_lanes(half, hn::Add(hn::LowerHalf(half, values), hn::UpperHalf(half, values)));
  }
}
#endif
HWY_INLINE float sum_of(Row row) {
  for (std::size_t half{parts / 2}; half > 0; half /= 2) {
    for (std::size_t p{0}; p < half; ++p) row.part[p] = hn::Add(row.part[p], row.part[p + half]);
  }
  return sum_of_lanes(Columns{}, row.part[0]);
}

// Grey levels between the pixels of a row, from `first` on, and the next ones.
HWY_INLINE Row between_columns(const std::uint8_t* first, float share_next) {
  const Row grey{Row::load(first)};
  return grey + Row::all(share_next) * (Row::load(first + (share_next > 0 ? 1 : 0)) - grey);
}

// Grey levels under a patch with `border` more pixels around it, between the pixels: take(row, column, values) of each
// row, of a border twice, as a row then has more columns than a patch. False where it is not inside.
template <int border, class Take>
HWY_INLINE bool sample(View<const std::uint8_t> image, Place place, float shear, const Take& take) {
  using Rows = PatchRows<border>;
  const Rows rows{image, place, shear};
  if (!rows.are_inside()) return false;
  const std::ptrdiff_t next_row{rows.next_row()};
  Row above[border + 1];
  for (Row& one : above) one = Row::all(0);
  auto row = rows.row(-Rows::reach_v);
  for (int j{-Rows::reach_v}; j <= Rows::reach_v; ++j) {
    const bool is_below{j > -Rows::reach_v && shear == 0};  // it begins at the same column as the row before
    if (is_below) {
      row.first += image.pitch;
    } else {
      row = rows.row(j);
      if (row.first == nullptr) return false;
    }
    const bool is_known{is_below && next_row != 0};  // the row above: the row below of the step before
    for (int side{0}; side <= border; ++side) {
      const std::uint8_t* first{row.first + 2 * border * side};
      if (!is_known) above[side] = between_columns(first, row.share_next);
      const Row below{next_row != 0 ? between_columns(first + next_row, row.share_next) : above[side]};
      take(static_cast<std::size_t>(j + Rows::reach_v), static_cast<std::size_t>(2 * border * side),
           above[side] + Row::all(rows.share_below()) * (below - above[side]));
      above[side] = below;
    }
  }
  return true;
}

/// Greys with a pixel around them, by rows.
constexpr std::size_t wide{patch_columns + 2};
using WidePatch = std::array<float, wide*(patch_rows + 2)>;

// Gradients along the columns of the other image; the sums of each.
void take_gradients(const WidePatch& grey, float shear, Template& patch, Row (&sums)[3]) {
  for (std::size_t j{0}; j < patch_rows; ++j) {
    const float* row{&grey[(j + 1) * wide + 1]};
    const Row here{Row::load(row)};
    const Row along_u{Row::all(0.5f) * (Row::load(row + 1) - Row::load(row - 1))};
    const Row along_v{Row::all(0.5f) * (Row::load(row + wide) - Row::load(row - wide)) + Row::all(shear) * along_u};
    here.store(&patch.grey[j * patch_columns]);
    along_u.store(&patch.gradient_u[j * patch_columns]);
    along_v.store(&patch.gradient_v[j * patch_columns]);
    sums[0] = sums[0] + here;
    sums[1] = sums[1] + along_u;
    sums[2] = sums[2] + along_v;
  }
}

bool Cut(View<const std::uint8_t> image, Place place, float shear, Template& patch) {
  WidePatch grey;
  const auto keep = [&grey](std::size_t row, std::size_t column, const Row& values)
                        HWY_ATTR { values.store(&grey[row * wide + column]); };
  if (!sample<1>(image, place, 0, keep)) return false;
  Row sums[3]{Row::all(0), Row::all(0), Row::all(0)};
  take_gradients(grey, shear, patch, sums);
  const Row mean{Row::all(sum_of(sums[0]) / patch_pixels)};
  const Row mean_u{Row::all(sum_of(sums[1]) / patch_pixels)};
  const Row mean_v{Row::all(sum_of(sums[2]) / patch_pixels)};
  Row uu{Row::all(0)};
  Row uv{uu};
  Row vv{uu};
  Row squares{uu};
  for (std::size_t k{0}; k < patch_pixels; k += patch_columns) {
    const Row here{Row::load(&patch.grey[k]) - mean};
    const Row along_u{Row::load(&patch.gradient_u[k]) - mean_u};
    const Row along_v{Row::load(&patch.gradient_v[k]) - mean_v};
    here.store(&patch.grey[k]);
    along_u.store(&patch.gradient_u[k]);
    along_v.store(&patch.gradient_v[k]);
    uu = uu + along_u * along_u;
    uv = uv + along_u * along_v;
    vv = vv + along_v * along_v;
    squares = squares + here * here;
  }
  patch.uu = sum_of(uu);
  patch.uv = sum_of(uv);
  patch.vv = sum_of(vv);
  patch.variance = sum_of(squares);
  return true;
}

/// Residual of a patch at a place, without its mean.
struct Misfit {
  Patch difference;
  float mean;

  HWY_INLINE bool look(View<const std::uint8_t> image, const Template& patch, float shear, Place place) {
    Row sums{Row::all(0)};
    const auto subtract = [&](std::size_t row, std::size_t, const Row& values) HWY_ATTR {
      const Row here{Row::load(&patch.grey[row * patch_columns]) - values};
      here.store(&difference[row * patch_columns]);
      sums = sums + here;
    };
    if (!sample<0>(image, place, shear, subtract)) return false;
    mean = sum_of(sums) / patch_pixels;
    return true;
  }
  HWY_INLINE Row row(std::size_t k) const { return Row::load(&difference[k]) - Row::all(mean); }
  HWY_INLINE float squares() const {
    Row sums{Row::all(0)};
    for (std::size_t k{0}; k < patch_pixels; k += patch_columns) sums = sums + row(k) * row(k);
    return sum_of(sums);
  }
};

bool Find(View<const std::uint8_t> image, const Template& patch, float shear, const FindLimits& limits, Place& place) {
  Misfit misfit;
  for (int step{0};; ++step) {
    if (!misfit.look(image, patch, shear, place)) return false;
    if (step == limits.steps) break;
    Row along_u{Row::all(0)};
    Row along_v{along_u};
    for (std::size_t k{0}; k < patch_pixels; k += patch_columns) {
      const Row here{misfit.row(k)};
      along_u = along_u + Row::load(&patch.gradient_u[k]) * here;
      along_v = along_v + Row::load(&patch.gradient_v[k]) * here;
    }
    const Place move{step_of(patch, sum_of(along_u), sum_of(along_v))};
    place = {place.u + move.u, place.v + move.v};
    if (is_short(move)) break;
  }
  return fits(patch, misfit.squares(), limits);
}

// The compiler's vectors.
void SmoothRows(View<const std::uint8_t> image, int begin, int end, View<std::uint8_t> smoothed) {
  constexpr int chunk{256};
  std::uint16_t sums[chunk + 2];  // along the columns, from the column before the chunk on
  for (int v{begin}; v < end; ++v) {
    const std::uint8_t* const above{image.row(std::max(v - 1, 0))};
    const std::uint8_t* const row{image.row(v)};
    const std::uint8_t* const below{image.row(std::min(v + 1, image.height - 1))};
    for (int first{0}; first < image.width; first += chunk) {
      const int count{std::min(chunk, image.width - first)};
      const auto sum_at = [&](int u) HWY_ATTR { return static_cast<std::uint16_t>(above[u] + 2 * row[u] + below[u]); };
      for (int i{0}; i < count; ++i) sums[i + 1] = sum_at(first + i);
      sums[0] = sum_at(std::max(first - 1, 0));
      sums[count + 1] = sum_at(std::min(first + count, image.width - 1));
      std::uint8_t* const out{smoothed.row(v) + first};
      for (int i{0}; i < count; ++i) {
        out[i] =
            static_cast<std::uint8_t>(static_cast<std::uint16_t>(sums[i] + 2 * sums[i + 1] + sums[i + 2] + 8) >> 4);
      }
    }
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(Cut);
HWY_EXPORT(Find);
HWY_EXPORT(SmoothRows);

bool cut(View<const std::uint8_t> image, Place place, float shear, Template& patch) {
  return HWY_DYNAMIC_DISPATCH(Cut)(image, place, shear, patch);
}

std::optional<Place> find(View<const std::uint8_t> image, const Template& patch, float shear, Place start,
                          FindLimits limits) {
  Place place{start};
  if (!HWY_DYNAMIC_DISPATCH(Find)(image, patch, shear, limits, place)) return std::nullopt;
  return place;
}

void smooth_rows(View<const std::uint8_t> image, int begin, int end, View<std::uint8_t> smoothed) {
  HWY_DYNAMIC_DISPATCH(SmoothRows)(image, begin, end, smoothed);
}

}  // namespace stereogrid
#endif

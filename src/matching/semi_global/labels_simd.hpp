// SPDX-License-Identifier: Apache-2.0
//
// All labels of a pixel in vectors, and one step of a path. Included once per instruction set; the guard works per
// target.
#if defined(STEREOGRID_SEMI_GLOBAL_LABELS_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_SEMI_GLOBAL_LABELS_SIMD
#undef STEREOGRID_SEMI_GLOBAL_LABELS_SIMD
#else
#define STEREOGRID_SEMI_GLOBAL_LABELS_SIMD
#endif

#include <cstdint>

#include "hwy/highway.h"
#include "matching/minima_simd.hpp"
#include "matching/semi_global/paths_simd.hpp"

#if HWY_TARGET != HWY_SCALAR
HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
constexpr int lanes{64};
#elif HWY_TARGET == HWY_AVX2
constexpr int lanes{32};
#else
constexpr int lanes{16};
#endif
using D8 = hn::FixedTag<std::uint8_t, lanes>;
using V8 = hn::Vec<D8>;

template <int n>
struct Labels {
  HWY_INLINE Labels() {}  // the compiler's own would not be compiled for the instruction set
  V8 part[n];
};

template <int n>
HWY_INLINE Labels<n> load(const std::uint8_t* costs) {
  Labels<n> labels;
  for (int i{0}; i < n; ++i) labels.part[i] = hn::Load(D8{}, costs + i * lanes);
  return labels;
}
template <int n>
HWY_INLINE void store(const Labels<n>& labels, std::uint8_t* costs) {
  for (int i{0}; i < n; ++i) hn::Store(labels.part[i], D8{}, costs + i * lanes);
}
template <int n>
HWY_INLINE Labels<n> sum(const Labels<n>& a, const Labels<n>& b) {
  Labels<n> labels;
  for (int i{0}; i < n; ++i) labels.part[i] = hn::SaturatedAdd(a.part[i], b.part[i]);
  return labels;
}

// `low` and `high` as neighbours, seen 16 lanes further down or up.
HWY_INLINE V8 last_block_before(V8 low, V8 high) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return V8{_mm512_alignr_epi64(high.raw, low.raw, 6)};
#elif HWY_TARGET == HWY_AVX2
  return hn::ConcatLowerUpper(D8{}, high, low);
#else
  (void)high;
  return low;
#endif
}
HWY_INLINE V8 first_block_behind(V8 low, V8 high) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return V8{_mm512_alignr_epi64(high.raw, low.raw, 2)};
#elif HWY_TARGET == HWY_AVX2
  return hn::ConcatLowerUpper(D8{}, high, low);
#else
  (void)low;
  return high;
#endif
}

// The smallest byte, in the first lane; the other lanes are not said.
template <class D>
HWY_INLINE hn::Vec<Block16> smallest_byte(D d, hn::Vec<D> values) {
  const auto block = hn::BitCast(Block16{}, folded(d, values));
  const hn::FixedTag<std::uint8_t, 16> bytes;
  // the smaller byte of a pair in its lower half, 0 in the upper one
  const auto pairs = hn::Min(hn::BitCast(bytes, block), hn::BitCast(bytes, hn::ShiftRight<8>(block)));
  return minimum16(hn::BitCast(Block16{}, pairs));
}
HWY_INLINE V8 first_byte_everywhere(hn::Vec<Block16> value) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return V8{_mm512_broadcastb_epi8(value.raw)};
#elif HWY_TARGET == HWY_AVX2
  return V8{_mm256_broadcastb_epi8(value.raw)};
#else
  const D8 d8;
  return hn::TableLookupBytes(hn::BitCast(d8, value), hn::Zero(d8));
#endif
}

// Step of a path (reference: advance). Costs of the pixel before come less their smallest one, and so do the costs for
// the next pixel.
class PathStep {
 public:
  PathStep()
      : step_{hn::Set(D8{}, std::uint8_t{path_penalties.step})},
        road_step_{hn::Set(D8{}, std::uint8_t{path_penalties.road_step})},
        jump_{hn::Set(D8{}, std::uint8_t{path_penalties.jump})},
        change_{hn::Set(D8{}, std::uint8_t{path_penalties.change})} {}

  // Cheapest way into each label, from costs in registers …
  template <int uprights, int n>
  HWY_INLINE Labels<n> way(const Labels<n>& before) const {
    const V8 border{hn::Set(D8{}, cost_max)};
    Labels<n> labels;
    for (int i{0}; i < n; ++i) {
      const V8 here{before.part[i]};
      const V8 low{last_block_before(i > 0 ? before.part[i - 1] : border, here)};
      const V8 high{first_block_behind(here, i < n - 1 ? before.part[i + 1] : border)};
      labels.part[i] =
          cheapest(here, shifted_up(low, here), shifted_down(here, high), i < uprights ? step_ : road_step_);
    }
    return labels;
  }

  // … or in memory.
  template <int uprights, int n>
  HWY_INLINE Labels<n> way(const std::uint8_t* before) const {
    const D8 d8;
    Labels<n> labels;
    for (int i{0}; i < n; ++i) {
      const std::uint8_t* here{before + i * lanes};
      labels.part[i] = cheapest(hn::Load(d8, here), hn::LoadU(d8, here - 1), hn::LoadU(d8, here + 1),
                                i < uprights ? step_ : road_step_);
    }
    return labels;
  }

  // Less the smallest one.
  template <int n>
  HWY_INLINE static Labels<n> passed_on(const Labels<n>& path) {
    V8 low{path.part[0]};
    for (int i{1}; i < n; ++i) low = hn::Min(low, path.part[i]);
    const V8 least{first_byte_everywhere(smallest_byte(D8{}, low))};
    Labels<n> labels;
    for (int i{0}; i < n; ++i) labels.part[i] = hn::Sub(path.part[i], least);
    return labels;
  }

  // Ways of the first `n` vectors, all upright, from the road labels of the pixel before, the first of which meets the
  // upright label at `meeting`.
  template <int n, int all>
  HWY_INLINE void from_road(const std::uint8_t* road_before, int count, int meeting, Labels<all>& ways) const {
    const D8 d8;
    // every label reaches three; 16 at a time are spread over the vectors by their place, upside down since lanes
    // without any become 0
    for (int k{-1}; k < count + 1; k += 16) {
      const V8 offer{hn::Not(hn::SaturatedAdd(cheapest_of_three(road_before + k), change_))};
      const V8 first{hn::Set(d8, static_cast<std::uint8_t>(meeting + k))};
      for (int i{0}; i < n; ++i) {
        const V8 place{hn::Sub(hn::Iota(d8, static_cast<std::uint8_t>(i * lanes)), first)};
        V8 index{hn::SaturatedAdd(place, hn::Set(d8, 0x70))};
#if !HWY_ARCH_X86 || HWY_TARGET == HWY_EMU128  // x86 tests the last four bits and the first one only
        index = hn::And(index, hn::Set(d8, 0x8f));
#endif
        ways.part[i] = hn::Min(ways.part[i], hn::Not(hn::TableLookupBytesOr0(offer, index)));
      }
    }
  }

 private:
  HWY_INLINE V8 cheapest(V8 here, V8 below, V8 above, V8 step) const {
    return hn::Min(hn::Min(here, hn::SaturatedAdd(hn::Min(below, above), step)), jump_);
  }
  HWY_INLINE static V8 shifted_up(V8 low, V8 here) {
    return hn::CombineShiftRightBytes<15>(D8{}, here, low);
  }
  HWY_INLINE static V8 shifted_down(V8 here, V8 high) {
    return hn::CombineShiftRightBytes<1>(D8{}, high, here);
  }

  // 16 labels, in every block
  HWY_INLINE static V8 cheapest_of_three(const std::uint8_t* middle) {
    const hn::FixedTag<std::uint8_t, 16> block;
    const auto beside = hn::Min(hn::LoadU(block, middle - 1), hn::LoadU(block, middle + 1));
    return in_every_block(hn::Min(hn::LoadU(block, middle), beside));
  }
  HWY_INLINE static V8 in_every_block(hn::Vec<hn::FixedTag<std::uint8_t, 16>> block) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
    return V8{_mm512_broadcast_i32x4(block.raw)};
#elif HWY_TARGET == HWY_AVX2
    return V8{_mm256_broadcastsi128_si256(block.raw)};
#else
    return block;
#endif
  }

  V8 step_;
  V8 road_step_;
  V8 jump_;
  V8 change_;
};

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif  // HWY_TARGET

#endif  // per-target guard

// SPDX-License-Identifier: Apache-2.0
#include "compression.hpp"

#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <new>

namespace stereogrid::mcap {
namespace {

constexpr std::array<std::string_view, 3> names{"", "lz4", "zstd"};
constexpr int zstd_level{1};  // a recording must keep up with its camera

struct Step {
  std::size_t consumed, produced;
  bool is_frame_whole;
};

class ZstdUnpacker {
 public:
  ZstdUnpacker() : context_{ZSTD_createDCtx()} {
    if (!context_) throw std::bad_alloc{};
  }

  Step step(View packed, std::span<std::byte> out) {
    ZSTD_inBuffer input{packed.data(), packed.size(), 0};
    ZSTD_outBuffer output{out.data(), out.size(), 0};
    const std::size_t result{ZSTD_decompressStream(context_.get(), &output, &input)};
    if (ZSTD_isError(result) != 0) throw Malformed{"its compressed data is not zstd"};
    return {input.pos, output.pos, result == 0};
  }

 private:
  struct Free {
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
  };
  std::unique_ptr<ZSTD_DCtx, Free> context_;
};

class Lz4Unpacker {
 public:
  Lz4Unpacker() {
    LZ4F_dctx* context{nullptr};
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) throw std::bad_alloc{};
    context_.reset(context);
  }

  Step step(View packed, std::span<std::byte> out) {
    std::size_t consumed{packed.size()};
    std::size_t produced{out.size()};
    const std::size_t result{LZ4F_decompress(context_.get(), out.data(), &produced, packed.data(), &consumed, nullptr)};
    if (LZ4F_isError(result) != 0) throw Malformed{"its compressed data is not lz4"};
    return {consumed, produced, result == 0};
  }

 private:
  struct Free {
    void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
  };
  std::unique_ptr<LZ4F_dctx, Free> context_;
};

template <class Unpacker>
void unpack(View packed, std::uint64_t most, Bytes& out) {
  constexpr std::uint64_t least_step{std::uint64_t{1} << 16};
  Unpacker unpacker;
  out.resize(std::min(most, std::max<std::uint64_t>(least_step, 4 * packed.size())));
  std::size_t size{0};
  for (bool whole{false}; !whole || !packed.empty();) {
    if (size == out.size()) out.resize(std::min<std::uint64_t>(most, 2 * size + least_step));
    const Step step{unpacker.step(packed, std::span{out}.subspan(size))};
    if (step.consumed == 0 && step.produced == 0) {
      throw Malformed{packed.empty() ? "its compressed data ends too early" : "it unpacks to more bytes than it says"};
    }
    packed = packed.subspan(step.consumed);
    size += step.produced;
    whole = step.is_frame_whole;
  }
  out.resize(size);
}

}  // namespace

std::string_view name_of(Compression compression) {
  return names[static_cast<std::size_t>(compression)];
}

std::optional<Compression> compression_of(std::string_view name) {
  const auto* const found{std::ranges::find(names, name)};
  if (found == names.end()) return std::nullopt;
  return static_cast<Compression>(found - names.begin());
}

struct Compressor::Zstd {
  struct Free {
    void operator()(ZSTD_CCtx* used) const { ZSTD_freeCCtx(used); }
  };
  std::unique_ptr<ZSTD_CCtx, Free> context{ZSTD_createCCtx()};
};

Compressor::Compressor(Compression compression) : compression_{compression} {
  if (compression != Compression::zstd) return;
  zstd_ = std::make_unique<Zstd>();
  if (!zstd_->context) throw std::bad_alloc{};
}

Compressor::~Compressor() = default;

View Compressor::compress(View bytes) {
  if (compression_ == Compression::none) return bytes;
  std::size_t size{0};
  if (compression_ == Compression::zstd) {
    buffer_.resize(std::max(buffer_.size(), ZSTD_compressBound(bytes.size())));
    size =
        ZSTD_compressCCtx(zstd_->context.get(), buffer_.data(), buffer_.size(), bytes.data(), bytes.size(), zstd_level);
    if (ZSTD_isError(size) != 0) throw std::bad_alloc{};  // with room enough nothing else can fail
  } else {
    LZ4F_preferences_t preferences{};
    preferences.frameInfo.contentSize = bytes.size();
    buffer_.resize(std::max(buffer_.size(), LZ4F_compressFrameBound(bytes.size(), &preferences)));
    size = LZ4F_compressFrame(buffer_.data(), buffer_.size(), bytes.data(), bytes.size(), &preferences);
    if (LZ4F_isError(size) != 0) throw std::bad_alloc{};
  }
  return View{buffer_}.first(size);
}

void decompress(Compression compression, View packed, std::uint64_t most, Bytes& out) {
  if (compression == Compression::lz4) {
    unpack<Lz4Unpacker>(packed, most, out);
  } else {
    unpack<ZstdUnpacker>(packed, most, out);
  }
}

std::optional<std::uint64_t> zstd_content_size(View packed) {
  const unsigned long long size{ZSTD_getFrameContentSize(packed.data(), packed.size())};
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) return std::nullopt;
  return size;
}

}  // namespace stereogrid::mcap

// SPDX-License-Identifier: Apache-2.0
#include "files/formats.hpp"

#include <isa-l.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <stdexcept>

namespace stereogrid::io {
namespace {

std::uint8_t* start_of(std::string_view bytes) {  // ISA-L does not write there
  return reinterpret_cast<std::uint8_t*>(const_cast<char*>(bytes.data()));
}

}  // namespace

// Level 1: higher ones hardly reduce the size. The first bytes are a block of their own: where ISA-L 2.30 begins with
// more than a few hundred, the result depends on the address of the stream (it hashes the pointer).
std::string deflate(std::string_view bytes, DeflateForm form) {
  const std::size_t most{bytes.size() + bytes.size() / 1024 + 1024};
  if (most > std::numeric_limits<std::uint32_t>::max()) throw std::length_error{"more than 4 GiB to compress"};
  const auto packed{std::make_unique_for_overwrite<std::uint8_t[]>(most)};
  struct State {
    isal_zstream stream;
    std::uint8_t level[ISAL_DEF_LVL1_DEFAULT];
  };
  const auto state{std::make_unique_for_overwrite<State>()};
  isal_zstream& stream{state->stream};
  isal_deflate_init(&stream);
  stream.hist_bits = 0;  // ISA-L does not set it
  stream.level = 1;
  stream.level_buf = state->level;
  stream.level_buf_size = sizeof state->level;
  stream.gzip_flag = form == DeflateForm::zlib ? IGZIP_ZLIB : IGZIP_DEFLATE;
  stream.next_in = start_of(bytes);
  stream.next_out = packed.get();
  stream.avail_out = static_cast<std::uint32_t>(most);
  const auto add{[&stream](std::size_t size, bool last) {
    stream.avail_in = static_cast<std::uint32_t>(size);
    stream.end_of_stream = last;
    stream.flush = last ? NO_FLUSH : SYNC_FLUSH;
    if (isal_deflate(&stream) != COMP_OK) throw std::logic_error{"deflate: ISA-L rejects its options"};
  }};
  const std::size_t first{std::min<std::size_t>(bytes.size(), 16)};
  add(first, false);
  add(bytes.size() - first, true);
  if (stream.internal_state.state != ZSTATE_END) throw std::logic_error{"deflate: the buffer is too small"};
  return {reinterpret_cast<const char*>(packed.get()), stream.total_out};
}

bool inflate_zlib(std::string_view packed, std::span<std::uint8_t> bytes) {
  constexpr std::size_t most{std::numeric_limits<std::uint32_t>::max()};
  if (packed.size() > most || bytes.size() > most) return false;
  const auto state{std::make_unique<inflate_state>()};
  isal_inflate_init(state.get());
  state->crc_flag = ISAL_ZLIB;
  state->next_in = start_of(packed);
  state->avail_in = static_cast<std::uint32_t>(packed.size());
  state->next_out = bytes.data();
  state->avail_out = static_cast<std::uint32_t>(bytes.size());
  return isal_inflate_stateless(state.get()) == ISAL_DECOMP_OK && state->total_out == bytes.size();
}

std::uint32_t crc32_of(std::string_view bytes) {
  return crc32_gzip_refl(0, start_of(bytes), bytes.size());
}

}  // namespace stereogrid::io

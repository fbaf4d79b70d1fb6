// SPDX-License-Identifier: Apache-2.0
//
// malloc and its relatives as this program defines them come before those of the C library, also for the shared
// libraries; the work is still done there.
#include "allocations.hpp"

#include <dlfcn.h>
#include <execinfo.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string_view>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define STEREOGRID_COUNTS_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define STEREOGRID_COUNTS_ALLOCATIONS 0
#endif
#endif
#if !defined(STEREOGRID_COUNTS_ALLOCATIONS)
#if defined(__GLIBC__)
#define STEREOGRID_COUNTS_ALLOCATIONS 1
#else
#define STEREOGRID_COUNTS_ALLOCATIONS 0
#endif
#endif

namespace stereogrid::test {
namespace {

constexpr int depth_max{16};
constexpr int kept_max{4096};
constexpr std::size_t listed_max{12};

struct Allocation {
  std::size_t bytes;
  std::array<void*, depth_max> callers;  // from malloc's own caller up
  int depth;
};

std::atomic<std::ptrdiff_t> live{0};
std::atomic<bool> counts{false};
std::atomic<int> seen{0};
std::array<Allocation, kept_max> kept;
thread_local bool is_looking{false};  // true during the search for callers, which may allocate

// `caller`: the place behind the call of malloc.
[[maybe_unused]] void note(std::size_t bytes, const void* caller) {
  if (!counts.load(std::memory_order_relaxed) || is_looking) return;
  const int i{seen.fetch_add(1)};
  if (i >= kept_max) return;
  is_looking = true;
  std::array<void*, depth_max + 4> stack{};
  const int depth{backtrace(stack.data(), static_cast<int>(stack.size()))};
  is_looking = false;
  auto* const end = stack.begin() + depth;
  auto* const first = std::find(stack.begin(), end, caller);
  Allocation& allocation{kept[static_cast<std::size_t>(i)]};
  allocation.bytes = bytes;
  allocation.depth = static_cast<int>(std::min<std::ptrdiff_t>(end - first, depth_max));
  std::copy_n(first, allocation.depth, allocation.callers.begin());
}

struct Place {
  std::string file;
  std::uintptr_t offset{0};

  [[nodiscard]] bool is_in(std::string_view library) const { return file.starts_with(library); }
  // The loader is in it, as it allocates for a new thread.
  [[nodiscard]] bool is_of_the_system() const {
    return is_in("libstdc++") || is_in("libc++") || is_in("libc.so") || is_in("libpthread") || is_in("ld-");
  }
};

Place place_of(void* address) {
  Dl_info info{};
  if (dladdr(address, &info) == 0 || info.dli_fname == nullptr) return {"?", 0};
  return {std::filesystem::path{info.dli_fname}.filename().string(),
          reinterpret_cast<std::uintptr_t>(address) - reinterpret_cast<std::uintptr_t>(info.dli_fbase)};
}

void add(const Allocation& allocation, Allocations& found) {
  std::string way;
  for (int i{0}; i < allocation.depth; ++i) {
    const Place place{place_of(allocation.callers[static_cast<std::size_t>(i)])};
    if (place.is_of_the_system()) continue;
    if (way.empty() && place.is_in("libtbb")) {
      ++found.of_tbb;
      return;
    }
    std::array<char, 32> offset{};
    std::snprintf(offset.data(), offset.size(), "+0x%zx ", static_cast<std::size_t>(place.offset));
    way += place.file + offset.data();
  }
  ++found.count;
  found.bytes += allocation.bytes;
  const bool is_listed{std::find(found.where.begin(), found.where.end(), way) != found.where.end()};
  if (!is_listed && found.where.size() < listed_max) found.where.push_back(way);
}

}  // namespace

bool can_count_allocations() {
  return STEREOGRID_COUNTS_ALLOCATIONS == 1;
}

std::ptrdiff_t live_bytes() {
  return live.load();
}

void start_counting() {
  std::array<void*, 2> stack{};
  backtrace(stack.data(), 2);  // loads a library the first time
  seen = 0;
  counts = true;
}

Allocations stop_counting() {
  counts = false;
  const int all{seen.load()};
  Allocations found;
  for (int i{0}; i < std::min(all, kept_max); ++i) add(kept[static_cast<std::size_t>(i)], found);
  found.count += std::max(all - kept_max, 0);  // from any module: the total is too large
  return found;
}

}  // namespace stereogrid::test

#if STEREOGRID_COUNTS_ALLOCATIONS

// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-inconsistent-declaration-parameter-name)
extern "C" {

void* __libc_malloc(std::size_t bytes) noexcept;
void* __libc_calloc(std::size_t count, std::size_t bytes) noexcept;
void* __libc_realloc(void* memory, std::size_t bytes) noexcept;
void* __libc_memalign(std::size_t alignment, std::size_t bytes) noexcept;
void __libc_free(void* memory) noexcept;

namespace {

void* taken(void* memory, std::size_t bytes, const void* caller) {
  if (memory == nullptr) return nullptr;
  stereogrid::test::live += static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  stereogrid::test::note(bytes, caller);
  return memory;
}

void given_back(void* memory) {
  if (memory != nullptr) stereogrid::test::live -= static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
}

}  // namespace

void* malloc(std::size_t bytes) noexcept {
  return taken(__libc_malloc(bytes), bytes, __builtin_return_address(0));
}

void* calloc(std::size_t count, std::size_t bytes) noexcept {
  return taken(__libc_calloc(count, bytes), count * bytes, __builtin_return_address(0));
}

void* realloc(void* memory, std::size_t bytes) noexcept {
  const std::ptrdiff_t before{memory == nullptr ? 0 : static_cast<std::ptrdiff_t>(malloc_usable_size(memory))};
  void* const moved{__libc_realloc(memory, bytes)};
  if (moved != nullptr || bytes == 0) stereogrid::test::live -= before;
  return taken(moved, bytes, __builtin_return_address(0));
}

void free(void* memory) noexcept {
  given_back(memory);
  __libc_free(memory);
}

void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  return taken(__libc_memalign(alignment, bytes), bytes, __builtin_return_address(0));
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  return taken(__libc_memalign(alignment, bytes), bytes, __builtin_return_address(0));
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) noexcept {
  *memory = taken(__libc_memalign(alignment, bytes), bytes, __builtin_return_address(0));
  return *memory == nullptr ? ENOMEM : 0;
}

}  // extern "C"
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-inconsistent-declaration-parameter-name)

#endif

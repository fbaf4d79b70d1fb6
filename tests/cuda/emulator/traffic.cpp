// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "traffic.hpp"

#include <sys/mman.h>
#include <ucontext.h>
#include <csignal>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <iterator>

namespace emulator {
namespace {

constexpr std::size_t page_bytes{4096};

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  std::abort();
}

void protect(std::uintptr_t address, std::size_t bytes, int allowed) {
  if (mprotect(reinterpret_cast<void*>(address), bytes, allowed) != 0) fail("emulator: mprotect");
}

#if defined(__x86_64__)

/// Whether an instruction that writes to memory leaves unread what was there. Additions to memory and the like do not,
/// but the processor calls their access a write.
bool only_writes(const unsigned char* code) {
  constexpr std::array<unsigned char, 11> prefixes{0x26, 0x2e, 0x36, 0x3e, 0x64, 0x65, 0x66, 0x67, 0xf0, 0xf2, 0xf3};
  // mov, movs, stos, and all that begin with a VEX or EVEX prefix
  constexpr std::array<unsigned char, 11> stores{0x88, 0x89, 0xa4, 0xa5, 0xaa, 0xab, 0xc6, 0xc7, 0xc4, 0xc5, 0x62};
  while (std::ranges::find(prefixes, *code) != prefixes.end() || (*code & 0xf0U) == 0x40) ++code;
  // of two bytes: these shift, exchange or set bits
  if (*code == 0x0f) return code[1] < 0xa0 || (code[1] > 0xc1 && code[1] != 0xc7);
  return std::ranges::find(stores, *code) != stores.end();
}

void note(Traffic& traffic, const siginfo_t& fault, const ucontext_t& context) {
  constexpr greg_t is_write{2};
  const greg_t* const registers{context.uc_mcontext.gregs};
  const bool writes{(registers[REG_ERR] & is_write) != 0};
  const bool reads{!writes || !only_writes(reinterpret_cast<const unsigned char*>(registers[REG_RIP]))};
  // the access is made again; a wrong one then ends the program
  if (!traffic.unlock(fault.si_addr, reads, writes)) std::signal(SIGSEGV, SIG_DFL);
}

#else

void note(Traffic& /*traffic*/, const siginfo_t& /*fault*/, const ucontext_t& /*context*/) {
  fail("emulator: STEREOGRID_EMULATOR_TRAFFIC needs an x86-64 processor");
}

#endif

Traffic* of_launch{nullptr};

void on_fault(int /*signal*/, siginfo_t* fault, void* context) {
  note(*of_launch, *fault, *static_cast<const ucontext_t*>(context));
}

// A kernel's threads have too little stack for a signal.
alignas(16) std::array<std::byte, std::size_t{64} << 10> stack_of_faults;
stack_t stack_before;
struct sigaction action_before;

}  // namespace

std::unique_ptr<Traffic> Traffic::wanted() {
  const char* const file{std::getenv("STEREOGRID_EMULATOR_TRAFFIC")};
  return file == nullptr ? nullptr : std::make_unique<Traffic>(file);
}

Traffic::Traffic(const char* file) : file_{file} {
  if (!file_) fail(file);
}

void* Traffic::allocate(std::size_t bytes) {
  const std::size_t pages{std::max<std::size_t>((bytes + page_bytes - 1) / page_bytes, 1)};
  void* const memory{mmap(nullptr, pages * page_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)};
  if (memory == MAP_FAILED) fail("emulator: mmap");
  allocations_[reinterpret_cast<std::uintptr_t>(memory)] = {bytes, std::vector<Page>(pages)};
  return memory;
}

void Traffic::release(void* memory) {
  const auto found{allocations_.find(reinterpret_cast<std::uintptr_t>(memory))};
  munmap(memory, found->second.pages.size() * page_bytes);
  allocations_.erase(found);
}

void Traffic::begin() {
  for (auto& [address, allocation] : allocations_) {
    std::ranges::fill(allocation.pages, Page{});
    protect(address, allocation.pages.size() * page_bytes, PROT_NONE);
  }
  of_launch = this;
  stack_t stack{};
  stack.ss_sp = stack_of_faults.data();
  stack.ss_size = stack_of_faults.size();
  struct sigaction action {};
  action.sa_sigaction = on_fault;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  if (sigaltstack(&stack, &stack_before) != 0) fail("emulator: sigaltstack");
  if (sigaction(SIGSEGV, &action, &action_before) != 0) fail("emulator: sigaction");
}

void Traffic::end(unsigned blocks, unsigned threads) {
  sigaction(SIGSEGV, &action_before, nullptr);
  sigaltstack(&stack_before, nullptr);
  std::size_t read{0};
  std::size_t written{0};
  for (const auto& [address, allocation] : allocations_) {
    protect(address, allocation.pages.size() * page_bytes, PROT_READ | PROT_WRITE);
    for (std::size_t i{0}; i < allocation.pages.size(); ++i) {
      const std::size_t bytes{std::min(page_bytes, allocation.bytes - i * page_bytes)};
      if (allocation.pages[i].is_read) read += bytes;
      if (allocation.pages[i].is_written) written += bytes;
    }
  }
  file_ << blocks << ' ' << threads << ' ' << read << ' ' << written << std::endl;
}

bool Traffic::unlock(const void* address, bool reads, bool writes) {
  const auto at{reinterpret_cast<std::uintptr_t>(address)};
  const auto next{allocations_.upper_bound(at)};
  if (next == allocations_.begin()) return false;
  auto& [start, allocation]{*std::prev(next)};
  const std::size_t page{(at - start) / page_bytes};
  if (page >= allocation.pages.size()) return false;
  allocation.pages[page].is_read |= reads;
  allocation.pages[page].is_written |= writes;
  protect(start + page * page_bytes, page_bytes, writes ? PROT_READ | PROT_WRITE : PROT_READ);
  return true;
}

}  // namespace emulator

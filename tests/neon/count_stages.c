// SPDX-License-Identifier: Apache-2.0
//
// Plugin of qemu's user emulation: instructions of functions, with those of the functions that they call. Debian
// packages neither qemu-plugin.h nor qemu's own plugins; the declarations here are those of version 1 of that
// interface. Arguments NAME=ADDRESS, at most 64; writes "NAME COUNT" lines to stderr at exit.
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t plugin_id;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
enum { no_registers = 0 };
void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id id, void (*callback)(plugin_id, struct qemu_plugin_tb*));
void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb* block, void (*callback)(unsigned, void*), int flags,
                                          void* data);
void qemu_plugin_register_atexit_cb(plugin_id id, void (*callback)(plugin_id, void*), void* data);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb* block, size_t i);
const void* qemu_plugin_insn_data(const struct qemu_plugin_insn* instruction);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);
uint64_t qemu_plugin_tb_vaddr(const struct qemu_plugin_tb* block);

__attribute__((visibility("default"))) int qemu_plugin_version = 1;

struct Count {
  uint64_t all;
  uint64_t vector;
};
struct Function {
  char name[64];
  uint64_t address;
  struct Count count;
};
struct Call {
  struct Function* function;
  int depth;           // of return_addresses at the call
  struct Count begin;  // before the call
};
enum End { other, call, ret };
struct Block {
  uint64_t address;
  struct Count count;
  enum End end;
  struct Function* entered;
};

enum { calls_max = 65536 };
static struct Function functions[64];
static int function_count;
static struct Call calls[calls_max];
static int call_count;
static uint64_t return_addresses[calls_max];
static int depth;
static struct Count executed;
static enum End last_end = other;

static void leave(uint64_t address) {
  int found = depth;
  while (found > 0 && return_addresses[found - 1] != address) --found;
  if (found == 0) return;
  depth = found - 1;
  for (; call_count > 0 && calls[call_count - 1].depth > depth; --call_count) {
    const struct Call* left = &calls[call_count - 1];
    left->function->count.all += executed.all - left->begin.all;
    left->function->count.vector += executed.vector - left->begin.vector;
  }
}

static void execute(unsigned cpu, void* data) {
  (void)cpu;
  const struct Block* block = data;
  if (last_end == ret) leave(block->address);
  if (block->entered != NULL && call_count < calls_max) {
    calls[call_count++] = (struct Call){block->entered, depth, executed};
  }
  executed.all += block->count.all;
  executed.vector += block->count.vector;
  last_end = block->end;
  if (block->end == call && depth < calls_max) {
    return_addresses[depth++] = block->address + 4 * block->count.all;
  }
}

static enum End end_of(uint32_t instruction) {
  if ((instruction & 0xfc000000) == 0x94000000 || (instruction & 0xfffffc1f) == 0xd63f0000) return call;  // bl, blr
  return (instruction & 0xfffffc1f) == 0xd65f0000 ? ret : other;
}

static void translate(plugin_id id, struct qemu_plugin_tb* translated) {
  (void)id;
  struct Block* block = malloc(sizeof *block);
  *block =
      (struct Block){.address = qemu_plugin_tb_vaddr(translated), .count = {qemu_plugin_tb_n_insns(translated), 0}};
  uint32_t instruction = 0;
  for (size_t i = 0; i < block->count.all; ++i) {
    memcpy(&instruction, qemu_plugin_insn_data(qemu_plugin_tb_get_insn(translated, i)), sizeof instruction);
    block->count.vector += (instruction >> 25 & 7) == 7;
  }
  block->end = end_of(instruction);
  for (int i = 0; i < function_count; ++i) {
    if (functions[i].address == block->address) block->entered = &functions[i];
  }
  qemu_plugin_register_vcpu_tb_exec_cb(translated, execute, no_registers, block);
}

static void report(plugin_id id, void* data) {
  (void)id;
  (void)data;
  for (int i = 0; i < function_count; ++i) {
    fprintf(stderr, "%s %" PRIu64 " %" PRIu64 "\n", functions[i].name, functions[i].count.all,
            functions[i].count.vector);
  }
}

__attribute__((visibility("default"))) int qemu_plugin_install(plugin_id id, const void* info, int count,
                                                               char** arguments) {
  (void)info;
  for (int i = 0; i < count && i < 64; ++i) {
    char* equals = strchr(arguments[i], '=');
    if (equals == NULL) return 1;
    snprintf(functions[i].name, sizeof functions[i].name, "%.*s", (int)(equals - arguments[i]), arguments[i]);
    functions[i].address = strtoull(equals + 1, NULL, 0);
    function_count = i + 1;
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, translate);
  qemu_plugin_register_atexit_cb(id, report, NULL);
  return 0;
}

# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""The instructions of a library's kernels, read from their machine code without a disassembler. For gpu_report.py.

Since Volta an instruction has 16 bytes. Its opcode is in the lowest 9 bits; the next 3 are the form of its operands.
Which opcode is which is seen by compiling known instructions of PTX with ptxas.
"""
import shutil
import struct
import subprocess
import tempfile
from collections import Counter
from pathlib import Path

INSTRUCTION_BYTES = 16
OPCODE = 0x1FF
COPIES = 13  # of a known instruction, to tell it from what else a kernel has
EM_CUDA = 190
SHT_NOBITS = 8
# What each kind is made of; {k} is another address for each copy. An address that may be in any memory counts as
# global. With doubles come conversions of integers of 64 bits, which have the same opcodes; not their first guesses of
# reciprocals and roots, which have that of floats.
KINDS = {
    "global accesses": ("ld.volatile.global.u64 %a, [%a];", "st.volatile.global.u32 [%a+{k}], %r1;",
                        "ld.volatile.u64 %a, [%a];", "st.volatile.u32 [%a+{k}], %r1;"),
    "shared accesses": ("ld.volatile.shared.u32 %s, [%s];", "st.volatile.shared.u32 [%s+{k}], %r1;"),
    "shuffles": ("shfl.sync.idx.b32 %r1, %r1, %r2, 31, 0xffffffff;",
                 "shfl.sync.bfly.b32 %r1, %r1, 1, 31, 0xffffffff;"),
    "atomics": ("atom.global.add.u32 %r1, [%a+{k}], %r1;", "atom.global.cas.b32 %r1, [%a+{k}], %r1, %r2;",
                "atom.add.u32 %r1, [%a+{k}], %r1;", "red.global.add.u32 [%a+{k}], %r1;",
                "atom.shared.add.u32 %r1, [%s+{k}], %r1;", "atom.shared.cas.b32 %r1, [%s+{k}], %r1, %r2;"),
    "on doubles": (
        "add.f64 %d1, %d1, %d2;", "mul.f64 %d1, %d1, %d2;", "fma.rn.f64 %d1, %d1, %d2, %d3;",
        "ld.volatile.global.f64 %d2, [%a+{k}]; setp.lt.and.f64 %p, %d1, %d2, %p;",
        "ld.volatile.global.f32 %f1, [%a+{k}]; cvt.f64.f32 %d1, %f1; st.volatile.global.f64 [%a], %d1;",
        "ld.volatile.global.f64 %d1, [%a+{k}]; cvt.rn.f32.f64 %f1, %d1; st.volatile.global.f32 [%a], %f1;",
        "ld.volatile.global.u32 %r1, [%a+{k}]; cvt.rn.f64.s32 %d1, %r1; st.volatile.global.f64 [%a], %d1;",
        "ld.volatile.global.f64 %d1, [%a+{k}]; cvt.rzi.s32.f64 %r1, %d1; st.volatile.global.u32 [%a], %r1;",
        "ld.volatile.global.f64 %d2, [%a+{k}]; cvt.rni.f64.f64 %d1, %d2; st.volatile.global.f64 [%a], %d1;"),
}
# of no kind
ORDINARY = """add.f32 %f1, %f1, %f2; mul.f32 %f1, %f1, %f2; fma.rn.f32 %f1, %f1, %f2, %f2; rcp.approx.f32 %f1, %f1;
cvt.rzi.s32.f32 %r1, %f1; mad.lo.u32 %r1, %r1, %r2, %r1; cvt.rn.f32.s32 %f1, %r1; setp.lt.and.f32 %p, %f1, %f2, %p;"""
MODULE = ".version 8.0\n.target {}\n.address_size 64\n.visible .entry bare() {{ ret; }}\n"
KERNEL = """.visible .entry {name}(.param .u64 memory) {{
  .reg .u64 %a, %t; .reg .u32 %r<3>, %s; .reg .f32 %f<3>; .reg .f64 %d<4>; .reg .pred %p; .shared .f64 own[2048];
  ld.param.u64 %a, [memory]; mov.u32 %r0, %tid.x; mul.wide.u32 %t, %r0, 8; add.u64 %a, %a, %t;
  mov.u32 %s, own; mad.lo.u32 %s, %r0, 8, %s;
  ld.volatile.global.v2.u32 {{%r1, %r2}}, [%a]; ld.volatile.global.v2.f32 {{%f1, %f2}}, [%a];
  ld.volatile.global.v2.f64 {{%d1, %d2}}, [%a]; ld.volatile.global.f64 %d3, [%a]; setp.lt.u32 %p, %r1, %r2;
  {code}
  st.volatile.global.u32 [%a], %r1; st.volatile.global.f32 [%a], %f1; st.volatile.global.f64 [%a], %d1;
  st.volatile.global.u32 [%a], %s; @%p st.volatile.global.u32 [%a], %r2;
  ret;
}}
"""


def sections(image: bytes) -> dict:
    """Of a 64-bit ELF file, which `image` begins with."""
    table, = struct.unpack_from("<Q", image, 0x28)
    size, count, of_names = struct.unpack_from("<HHH", image, 0x3A)
    headers = [struct.unpack_from("<IIQQQQ", image, table + i * size) for i in range(count)]
    names = headers[of_names][4]
    found = {}
    for name, kind, _, _, offset, length in headers:
        end = image.index(b"\0", names + name)
        found[image[names + name:end].decode()] = b"" if kind == SHT_NOBITS else image[offset:offset + length]
    return found


def architecture_of(image: bytes) -> str:
    flags, = struct.unpack_from("<I", image, 0x30)
    return f"sm_{flags >> 8 & 0xFF if image[8] >= 8 else flags & 0xFF}"  # CUDA 13 has moved it


def kernels_of(image: bytes) -> dict:
    """The opcodes of each, and of what fills it up to a multiple of some bytes."""
    prefix, instruction = ".text.", f"<Q{INSTRUCTION_BYTES - 8}x"
    return {name.removeprefix(prefix): [word & OPCODE for word, in struct.iter_unpack(instruction, code)]
            for name, code in sections(image).items() if name.startswith(prefix)}


def without_filling(opcodes: list, filling: int) -> list:
    end = len(opcodes)
    while end > 0 and opcodes[end - 1] == filling:
        end -= 1
    return opcodes[:end]


def images_in(library: bytes):
    """Of devices' code, as far as it is not compressed."""
    start = library.find(b"\x7fELF")
    while start >= 0:
        if int.from_bytes(library[start + 0x12:start + 0x14], "little") == EM_CUDA:
            yield library[start:]
        start = library.find(b"\x7fELF", start + 1)


def ptxas() -> str:
    return shutil.which("ptxas") or "/usr/local/cuda/bin/ptxas"


def assembled(ptx: str, architecture: str) -> bytes:
    with tempfile.TemporaryDirectory() as name:
        source, cubin = Path(name) / "code.ptx", Path(name) / "code.cubin"
        source.write_text(ptx)
        subprocess.run([ptxas(), f"-arch={architecture}", "-o", cubin, source], check=True)
        return cubin.read_bytes()


def known_kernels() -> dict:
    codes = {"empty": "", "ordinary": ORDINARY}
    for instructions in KINDS.values():
        for code in instructions:
            codes[f"known_{len(codes)}"] = "\n".join(code.format(k=64 * k) for k in range(COPIES))
    return codes


def learned(architecture: str) -> dict:
    """Each kind's opcodes: of COPIES copies of an instruction, the new one that is there as often. And "filling"."""
    codes = known_kernels()
    module = MODULE.format(architecture) + "".join(KERNEL.format(name=name, code=code) for name, code in codes.items())
    kernels = kernels_of(assembled(module, architecture))
    filling = kernels["bare"][-1]
    counts = {name: Counter(without_filling(kernels[name], filling)) for name in codes}
    known = set(counts["ordinary"]) - set(counts["empty"])
    of_kind = {"filling": filling}
    names = iter(list(codes)[2:])
    for kind, instructions in KINDS.items():
        of_kind[kind] = set()
        for code in instructions:
            more = counts[next(names)] - counts["empty"]
            new = {opcode for opcode, times in more.items() if times == COPIES} - known
            if len(new) != 1:
                raise RuntimeError(f"{architecture}: '{code}' becomes {len(new)} opcodes, not one")
            of_kind[kind] |= new
        known |= of_kind[kind]
    return of_kind


def counts_of(library: Path) -> dict:
    """Of each kernel, by its mangled name and architecture: how many instructions, and how many of each kind."""
    of_architecture, counts = {}, {}
    for image in images_in(library.read_bytes()):
        architecture = architecture_of(image)
        if architecture not in of_architecture:
            of_architecture[architecture] = learned(architecture)
        of_kind = of_architecture[architecture]
        for kernel, opcodes in kernels_of(image).items():
            found = without_filling(opcodes, of_kind["filling"])
            counts[kernel, architecture] = {"instructions": len(found)} | {
                kind: sum(opcode in of_kind[kind] for opcode in found) for kind in KINDS}
    if not counts:
        raise RuntimeError(f"{library} has no machine code that is not compressed: build it with nvcc -no-compress")
    return counts

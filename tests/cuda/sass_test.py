#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""scripts/gpu_sass.py on kernels whose instructions are known. Exit status 77, skipped: there is no ptxas."""
import shutil
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
import gpu_report  # noqa: E402
import gpu_sass  # noqa: E402

NAME = "_ZN10stereogrid12filter_cellsILi1EEEvPf"
SOURCE = """.version 8.0
.target {architecture}
.address_size 64
.visible .entry {name}(.param .u64 memory) {{
  .reg .u64 %a, %t; .reg .u32 %r<4>, %s; .reg .f64 %d<3>; .shared .u32 own[64];
  ld.param.u64 %a, [memory]; cvta.to.global.u64 %a, %a; mov.u32 %r0, %tid.x; mul.wide.u32 %t, %r0, 8;
  add.u64 %a, %a, %t; mov.u32 %s, own; mad.lo.u32 %s, %r0, 4, %s;
  ld.global.nc.v2.u32 {{%r1, %r2}}, [%a];
  ld.global.f64 %d1, [%a+1024];
  shfl.sync.down.b32 %r3, %r1, 1, 31, 0xffffffff;
  st.shared.u32 [%s], %r3;
  bar.sync 0;
  ld.shared.u32 %r3, [%s+4];
  atom.shared.min.u32 %r1, [%s+8], %r3;
  red.global.max.u32 [%a+2048], %r1;
  cvt.rn.f64.u32 %d2, %r2;
  mul.rn.f64 %d1, %d1, %d2;
  add.rn.f64 %d1, %d1, %d2;
  st.global.f64 [%a+4096], %d1;
  ret;
}}
.visible .entry of_no_log() {{ ret; }}
"""
EXPECTED = {"global accesses": 3, "shared accesses": 2, "shuffles": 1, "atomics": 2, "on doubles": 3}


def library(folder: Path, architectures: list) -> Path:
    """Several images among other bytes."""
    file = folder / "library.so"
    images = [gpu_sass.assembled(SOURCE.format(architecture=one, name=NAME), one) for one in architectures]
    file.write_bytes(Path(sys.executable).read_bytes()[:4096] + b"\x7fELF" + b"\0".join(images) + b"\x7fELF" )
    return file


def main() -> int:
    if shutil.which(gpu_sass.ptxas()) is None:
        print("SKIPPED, nothing was tested: ptxas is missing.")
        return 77
    architectures = ["sm_75", "sm_80", "sm_90"]
    with tempfile.TemporaryDirectory() as name:
        counts = gpu_sass.counts_of(library(Path(name), architectures))
    for one in architectures:
        # MOV or LDC, EXIT, and a jump to itself behind it
        assert counts["of_no_log", one] == {"instructions": 3} | dict.fromkeys(gpu_sass.KINDS, 0), counts
        assert counts[NAME, one].items() >= EXPECTED.items(), counts
        assert 15 <= counts[NAME, one]["instructions"] <= 40, counts
    log = f"ptxas info    : Compiling entry function '{NAME}' for 'sm_80'\nptxas info    : Used 12 registers\n"
    rows = gpu_report.table(gpu_report.resources(log, counts)).splitlines()
    assert len(rows) == 3 and rows[2].endswith(f"| {counts[NAME, 'sm_80']['instructions']} | 3 | 2 | 1 | 2 | 3 |"), rows
    return 0


if __name__ == "__main__":
    sys.exit(main())

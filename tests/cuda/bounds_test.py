#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""scripts/gpu_bounds.py on what callgrind and the emulator say of launches."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
import gpu_bounds  # noqa: E402

COUNTS = """desc: Trigger: Client Request: launch of 264 x 128
events: Ir
fl=(1) cuda.cu
fn=(1) std::_Function_handler<void (), call>::_M_invoke(std::_Any_data const&)
12 900
calls=128 40
+3 70000
fn=(2) void stereogrid::(anonymous namespace)::filter_cells<1>(float*)
* 30000
cfn=(3) emulator::warp_exchange(unsigned int)
calls=2 9
-1 5000
+1 3000
fn=(4) stereogrid::updated(float)
7 792
fn=(3)
7 100000
totals: 1
"""


def near(value: float, expected: float) -> bool:
    return abs(value - expected) < 1e-9 * expected


def main() -> None:
    launch = gpu_bounds.counted(COUNTS, {"filter_cells"})
    assert launch == {"kernel": "filter_cells<1>", "blocks": 264, "threads": 128, "instructions": 33792}, launch
    other = dict(launch, blocks=1)
    gpu_bounds.add_traffic([launch, other], "264 128 3000000 2000000\n1 128 0 4096\n")
    assert (launch["bytes"], other["bytes"]) == (5000000, 4096)
    try:
        gpu_bounds.add_traffic([launch], "264 64 0 0\n")
        raise AssertionError("launches of other threads are matched")
    except RuntimeError:
        pass
    # one instruction for each thread: 264 · 4 of warps
    issue, thread, memory = gpu_bounds.bounds_us(launch, 132, 2.0, 1000.0)
    assert near(issue, 264 * 4 / 4 / 132 / 2000), issue
    assert near(thread, 4 / 2000), thread
    assert near(memory, 5), memory
    # one block keeps one multiprocessor busy
    assert near(gpu_bounds.bounds_us(other, 132, 2.0, 1000.0)[0], 33792 / 32 / 4 / 2000)
    rows = gpu_bounds.table(dict.fromkeys(gpu_bounds.DEVICES, [launch, launch])).splitlines()
    assert rows[2].startswith("| `filter_cells<1>` | 2 | 67584 | 1 | 10000 | 3.0 |"), rows[2]
    assert rows[3].startswith("| all, with 1 µs for each launch | 2 | | | 10000 | 5 |"), rows[3]
    kernels = gpu_bounds.kernel_names(Path(__file__).parents[2] / "src")
    assert {"filter_cells", "fit_block", "walk_paths"} <= kernels, kernels


if __name__ == "__main__":
    main()

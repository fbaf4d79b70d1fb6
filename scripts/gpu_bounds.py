#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""What a frame should take on a GPU: computed, not measured, for machines without one.

gpu_bounds.py TOOL LIBRARY INPUT    the table, as Markdown

LIBRARY is libstereogrid_cuda_emulated_library.so of a build with -fno-tree-vectorize -g, so that an instruction of the
host is one of a thread. valgrind counts them for each launch of the last of four frames, once for each of the GPUs, as
kernels are launched by how many multiprocessors there are; a run without valgrind counts the bytes of device memory.
docs/gpu.md says what a bound is made of and leaves out.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

FRAMES = 4
FIRST_KERNEL = "align"  # of a frame
LANES = 32
ISSUED_PER_CYCLE = 4  # instructions of warps, by a multiprocessor
CYCLES_PER_INSTRUCTION = 4  # of a thread, each of which needs the one before it
NODE_US = 1.0  # from one launch of a graph to the next: assumed
# As NVIDIA's data sheets say: multiprocessors, GHz, GB/s of its memory.
DEVICES = {"H100 SXM": (132, 1.98, 3350), "RTX 4090": (128, 2.52, 1008), "AGX Orin": (16, 1.3, 204.8)}
EMULATORS = re.compile(r"emulator::|boost::|std::|\w+_fcontext|operator |_dl_|__tls_get_addr|mem(cpy|move|set)|0x|\(")


def short(name: str) -> str:
    name = re.sub(r"\(anonymous namespace\)::|stereogrid::| \[clone [^]]*\]|'\d+$", "", name)
    return re.sub(r"^void ", "", re.sub(r"\(.*", "", name) or name)


def counted(text: str, kernels: set) -> dict:
    """A launch: its kernel, blocks, threads of each, and the instructions of all; the emulator's are left out."""
    shape = re.search(r"launch of (\d+) x (\d+)", text)
    launch = {"kernel": None, "blocks": int(shape[1]), "threads": int(shape[2]), "instructions": 0}
    names, counts, skips = {}, False, False
    for line in text.splitlines():
        if match := re.match(r"c?fn=(\(\d+\))\s?(.*)", line):
            name = names.setdefault(match[1], match[2])
            if short(name).split("<")[0] in kernels:
                launch["kernel"] = short(name)
            if line.startswith("fn="):
                counts = not EMULATORS.match(name)
        elif line.startswith("calls="):
            skips = True  # the next line is the callee's
        elif re.match(r"[+\-*\d]", line):
            if counts and not skips:
                launch["instructions"] += int(line.split()[1])
            skips = False
    return launch


def add_traffic(launches: list, lines: str) -> None:
    """To launches, in their order, the bytes that the emulator says each of them reads and writes."""
    traffic = [tuple(map(int, line.split())) for line in lines.splitlines()]
    if [line[:2] for line in traffic] != [(launch["blocks"], launch["threads"]) for launch in launches]:
        raise RuntimeError("with and without valgrind other kernels were launched: measure again")
    for launch, (_, _, read, written) in zip(launches, traffic):
        launch["bytes"] = read + written


def kernel_names(folder: Path) -> set:
    pattern = re.compile(r"__global__\s+void\s+(?:__launch_bounds__\([^)]*\)\s*)?(\w+)\(")
    return {name for source in folder.rglob("*.cu") for name in pattern.findall(source.read_text())}


def bounds_us(launch: dict, multiprocessors: int, ghz: float, gb_per_s: float) -> tuple:
    """What the instructions of the multiprocessors take, those of a thread one after the other, and the memory."""
    at_work = min(multiprocessors, launch["blocks"])
    cycles_per_us = 1e3 * ghz
    issue = launch["instructions"] / LANES / ISSUED_PER_CYCLE / at_work / cycles_per_us
    of_thread = launch["instructions"] / (launch["blocks"] * launch["threads"])
    return issue, of_thread * CYCLES_PER_INSTRUCTION / cycles_per_us, launch["bytes"] / (1e3 * gb_per_s)


def table(frames: dict) -> str:
    """Of each device's launches."""
    names = " | ".join(f"{name}, µs" for name in frames)
    first = next(iter(frames))
    lines = [f"| kernel | launches | threads, on an {first} | instructions of each | memory, kB | {names} |",
             "| --- |" + " ---: |" * (4 + len(frames))]
    least = {name: bounds_by_kernel(launches, *DEVICES[name]) for name, launches in frames.items()}
    for kernel in sorted(least[first], key=least[first].get, reverse=True):
        launches = [launch for launch in frames[first] if launch["kernel"] == kernel]
        threads = sum(launch["blocks"] * launch["threads"] for launch in launches)
        instructions = sum(launch["instructions"] for launch in launches) / threads
        kilobytes = sum(launch["bytes"] for launch in launches) / 1e3
        lines.append(f"| `{kernel}` | {len(launches)} | {threads} | {instructions:.0f} | {kilobytes:.0f} | "
                     + " | ".join(f"{of_device[kernel]:.1f}" for of_device in least.values()) + " |")
    launches = len(frames[first])
    kilobytes = sum(launch["bytes"] for launch in frames[first]) / 1e3
    totals = (sum(of_device.values()) + launches * NODE_US for of_device in least.values())
    lines.append(f"| all, with {NODE_US:g} µs for each launch | {launches} | | | {kilobytes:.0f} | "
                 + " | ".join(f"{total:.0f}" for total in totals) + " |")
    return "\n".join(lines)


def bounds_by_kernel(launches: list, *device: float) -> dict:
    least = dict.fromkeys((launch["kernel"] for launch in launches), 0.0)
    for launch in launches:
        least[launch["kernel"]] += max(bounds_us(launch, *device))
    return least


def last_frame(tool: str, library: str, source: str, kernels: set, multiprocessors: int) -> list:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def run(out: str, wanted: dict, *under: str) -> None:
            environment = {**os.environ, "STEREOGRID_CUDA_LIBRARY": library,
                           "STEREOGRID_EMULATOR_MULTIPROCESSORS": str(multiprocessors), **wanted}
            subprocess.run([*under, tool, "run", source, "--device", "cuda", "--threads", "1", "--frames",
                            f"0:{FRAMES - 1}", "--out", str(folder / out)], env=environment, check=True,
                           stdout=sys.stderr)

        run("counted", {"STEREOGRID_EMULATOR_COUNTS": "1"}, "valgrind", "--tool=callgrind",
            f"--callgrind-out-file={folder}/counts")
        dumps = sorted(folder.glob("counts.*"), key=lambda path: int(path.suffix[1:]))
        texts = (path.read_text() for path in dumps)
        launches = [counted(text, kernels) for text in texts if "launch of" in text]
        run("traced", {"STEREOGRID_EMULATOR_TRAFFIC": str(folder / "traffic")})
        add_traffic(launches, (folder / "traffic").read_text())
    return launches[max(i for i, launch in enumerate(launches) if launch["kernel"] == FIRST_KERNEL):]


def main() -> int:
    if len(sys.argv) != 4:
        print(__doc__, file=sys.stderr)
        return 64
    if shutil.which("valgrind") is None:
        print("valgrind is missing. Debian and Ubuntu: apt-get install valgrind", file=sys.stderr)
        return 75
    kernels = kernel_names(Path(__file__).parents[1] / "src")
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        frames = pool.map(lambda device: last_frame(*sys.argv[1:], kernels, device[0]), DEVICES.values())
    print(table(dict(zip(DEVICES, frames))))
    return 0


if __name__ == "__main__":
    sys.exit(main())

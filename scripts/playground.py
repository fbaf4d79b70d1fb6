#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the playground: the viewer's page with the pipeline as WebAssembly and a sample pair in it, one file."""
import argparse
import base64
import json
import re
import subprocess
import zlib
from pathlib import Path
from tempfile import TemporaryDirectory

import gallery

ROOT = gallery.ROOT
SOURCES = ROOT / "viewer" / "playground"
WASM = ROOT / "build" / "playground" / "stereogrid.wasm"
SCENE, FRAME = "scene:street?width=512&height=320&frames=12", "000008"


def deflated(data: bytes) -> bytes:
    packer = zlib.compressobj(9, wbits=-15)
    return packer.compress(data) + packer.flush()


def embedded(name: str, value: "dict[str, str]") -> str:
    text = json.dumps(value).replace("</", "<\\/")
    return f'<script type="application/json" id="{name}">{text}</script>'


def make(program: str, wasm: Path, folder: Path) -> None:
    """Writes index.html into `folder`. It shows the tool's result of the sample pair first."""
    with TemporaryDirectory() as work:
        def tool(*words: "str | Path") -> None:
            subprocess.run([program, *words, "--quiet"], check=True)

        tool("simulate", SCENE, "--out", f"{work}/scene", "--no-truth")
        left, right = (Path(work) / "scene" / side / f"{FRAME}.png" for side in ("left", "right"))
        calibration = Path(work) / "scene" / "calibration.yaml"
        tool("run", left, right, "--calibration", calibration, "--poses", "none", "--set", "tracking.confirm_frames=1",
             "--out", f"{work}/sample", "--mcap")
        tool("export", f"{work}/sample", "--web", folder)
        data = {name: base64.b64encode(path.read_bytes()).decode() for name, path in (("left", left), ("right", right))}
        data["calibration"] = calibration.read_text()
    data["wasm"] = base64.b64encode(deflated(wasm.read_bytes())).decode()

    page = (folder / "index.html").read_text()
    modules = re.search(r'<script type="application/json" id="modules">(.*?)</script>', page, re.DOTALL)
    with_ours = json.loads(modules[1]) | {"playground.js": (SOURCES / "playground.js").read_text()}
    page = page.replace(modules[0], embedded("modules", with_ours) + embedded("playground", data))
    page = page.replace("addressOf('main.js')", "addressOf('playground.js')")
    page = page.replace("<main>", (SOURCES / "panel.html").read_text() + "<main>")
    (folder / "index.html").write_text(page)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--wasm", type=Path, default=WASM, help="default: that of build/playground")
    parser.add_argument("folder", type=Path, help="gets index.html")
    options = parser.parse_args()
    if not (tool := gallery.tool()):
        parser.error("The tool is missing. Build it, or name it in STEREOGRID.")
    if not options.wasm.is_file():
        parser.error(f"{options.wasm} is missing. Build it (viewer/playground/CMakeLists.txt).")
    make(tool, options.wasm, options.folder)

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the fuzz targets' seeds, which are kept in seeds.txt.

seeds.py FOLDER                   writes FOLDER/TARGET/NAME for every seed; other files there are deleted
seeds.py --add TARGET NAME FILE   keeps FILE as a seed, such as an input that a fuzzer found

A seed begins with a line "==== TARGET/NAME". Text follows with \\xNN for bytes that are no printable UTF-8 and \\\\ for a
backslash; "open" in the first line: without the last end of line. "packed": base64 of zlib's bytes follows, in
one line. So are seeds of more than a few lines.
"""
import base64
import re
import shutil
import sys
import zlib
from pathlib import Path

SEEDS = Path(__file__).resolve().parent / "seeds.txt"
HEAD = "==== "
LINES_MAX = 8


def escaped(data: bytes) -> str:
    text = data.decode("utf-8", errors="surrogateescape").replace("\\", r"\\")
    return "".join(character if character.isprintable() or character == "\n" else
                   "".join(f"\\x{byte:02x}" for byte in character.encode("utf-8", errors="surrogateescape")) for character in text)


def unescaped(text: str) -> bytes:
    return re.sub(rb"\\(?:x([0-9a-f]{2})|(\\))", lambda match: match[2] or bytes.fromhex(match[1].decode()), text.encode("utf-8"))


def encode(name: str, data: bytes) -> str:
    text = escaped(data)
    if len(text) > 1.5 * len(data) or text.count("\n") > LINES_MAX:
        return f"{HEAD}{name} packed\n{base64.b64encode(zlib.compress(data, 9)).decode('ascii')}\n"
    return f"{HEAD}{name}\n{text}" if text.endswith("\n") else f"{HEAD}{name} open\n{text}\n"


def seeds(text: str) -> "dict[str, bytes]":
    found = {}
    for part in re.split(rf"^{HEAD}", text, flags=re.MULTILINE)[1:]:
        head, _, body = part.partition("\n")
        name, *kinds = head.split()
        if "packed" in kinds:
            found[name] = zlib.decompress(base64.b64decode(body))
        else:
            found[name] = unescaped(body[:-1] if "open" in kinds else body)
    return found


def write(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    for name, data in seeds(SEEDS.read_text(encoding="utf-8")).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)


def add(target: str, name: str, data: bytes) -> None:
    with SEEDS.open("a", encoding="utf-8") as file:
        file.write(encode(f"{target}/{name}", data))


def main() -> int:
    if len(sys.argv) == 5 and sys.argv[1] == "--add":
        add(sys.argv[2], sys.argv[3], Path(sys.argv[4]).read_bytes())
    elif len(sys.argv) == 2 and not sys.argv[1].startswith("-"):
        write(Path(sys.argv[1]))
    else:
        print(__doc__, file=sys.stderr)
        return 64
    return 0


if __name__ == "__main__":
    sys.exit(main())

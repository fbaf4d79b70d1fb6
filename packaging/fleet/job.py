# SPDX-License-Identifier: Apache-2.0
"""The files of a drive, and a range of its frames: jobs of the Snakefile beside this file (docs/fleet.md).

job.py files OUT [--content] -- INPUT...        writes names and sizes of the files of a drive to OUT
job.py range DONE FILES [--pause S] [--options TEXT] -- COMMAND
                                                runs `stereogrid run ... --out PART --resume`

range writes the exit codes 0, 64 and 65 to DONE, with the options and the message, and ends with 0. All others are its own: try
again.
"""
import argparse
import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

TRY_AGAIN = 75
IMPOSSIBLE = (64, 65)  # wrong usage, unusable input


def write(path: Path, text: str) -> None:
    """Writes a whole file or none."""
    new = path.with_name(path.name + ".new")
    new.write_text(text, encoding="utf-8", errors="surrogateescape")
    new.rename(path)


def files_of(paths: "list[str]", content: bool) -> str:
    """A line for each file: size or digest, and name. Exits with 75 for a missing input or an empty folder."""
    lines = ["content" if content else "size"]
    for path in paths:
        if path.startswith("scene:"):
            lines.append(path)
            continue
        files = sorted(filter(os.path.isfile, Path(path).rglob("*"))) if os.path.isdir(path) else [Path(path)]
        if not files or not os.path.exists(path):
            sys.exit(try_again(f"{path} is missing or empty. Mount its file system on this machine, or take it out of fleet.yaml."))
        for file in files:
            what = hashlib.sha256(file.read_bytes()).hexdigest() if content else file.stat().st_size
            lines.append(f"{what} {file!s}")
    return "\n".join(["\0".join(paths), *lines]) + "\n"


def try_again(why: str) -> int:
    print(why, file=sys.stderr)
    return TRY_AGAIN


class Range:
    """A range of frames. `command` has the folder of the part behind --out."""

    def __init__(self, options: argparse.Namespace):
        self.options = options
        self.files = Path(options.files)
        self.part = Path(options.command[options.command.index("--out") + 1])

    def has_all_files(self) -> bool:
        known = self.files.read_text(encoding="utf-8", errors="surrogateescape")
        paths, kind, _ = known.split("\n", 2)
        return files_of(paths.split("\0"), kind == "content") == known

    def run(self) -> "tuple[int, str]":
        """Exit code and message of the command; SIGTERM is passed on to it, so that it saves its state."""
        with subprocess.Popen(self.options.command, stderr=subprocess.PIPE, text=True, errors="replace") as process:
            signal.signal(signal.SIGTERM, lambda *_: process.terminate())
            message = process.stderr.read()
        print(message, end="", file=sys.stderr)
        return process.returncode, message

    def is_damaged(self) -> bool:
        """Whether the machine has lost parts of files, which are written before a checkpoint without being synchronised."""
        try:
            return any(zipfile.ZipFile(file).testzip() for file in self.part.rglob("*.npz"))
        except zipfile.BadZipFile:
            return True

    def attempt(self) -> "tuple[int, str]":
        if not self.has_all_files():
            return try_again(f"the input differs from {self.files}. Restore it, or remove that file."), ""
        code, message = self.run()
        if code in (0, *IMPOSSIBLE) and not self.has_all_files():
            if code == 0:
                shutil.rmtree(self.part)
            return try_again("the input was away for a moment: the range is processed again."), ""
        return code, message

    def process(self) -> int:
        is_continued = self.part.exists()
        code, message = self.attempt()
        if code in IMPOSSIBLE:
            time.sleep(self.options.pause)
            if is_continued:
                shutil.rmtree(self.part)
            code, message = self.attempt()
        if code == 0 and is_continued and self.is_damaged():
            shutil.rmtree(self.part)
            code = try_again(f"{self.part} was damaged: the range starts again.")
        if code == 0 or code in IMPOSSIBLE:
            write(Path(self.options.done), f"{code}\n{self.options.options}\n{message if code else ''}")
            return 0
        time.sleep(self.options.pause)
        return code if code > 0 else 128 - code


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    jobs = parser.add_subparsers(dest="job", required=True)
    files = jobs.add_parser("files")
    files.add_argument("out")
    files.add_argument("--content", action="store_true")
    files.add_argument("input", nargs="+")
    one = jobs.add_parser("range")
    one.add_argument("done")
    one.add_argument("files")
    one.add_argument("--pause", type=float, default=10)
    one.add_argument("--options", default="")
    one.add_argument("command", nargs="+")
    options = parser.parse_args()
    if options.job == "files":
        write(Path(options.out), files_of(options.input, options.content))
        return 0
    return Range(options).process()


if __name__ == "__main__":
    sys.exit(main())

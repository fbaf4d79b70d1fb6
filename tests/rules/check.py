#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the rules that a compiler does not: permitted includes, licence lines, paths, links, and the language of comments and pages.

Usage: check.py [ROOT]. Prints every violation as file:line: message. Exit status 1 if there are any.
"""
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import language  # noqa: E402
import links  # noqa: E402

CODE = {".hpp", ".cpp", ".cu", ".cuh", ".h"}
WITH_LICENCE = CODE | {".cmake", ".sh", ".py", ".yaml", ".yml"}
LICENCE, COPYRIGHT = "SPDX-License-Identifier: Apache-2.0", "SPDX-FileCopyrightText: 2026 The stereogrid authors"
WITH_COPYRIGHT = re.compile(r"(\w+/)?include/stereogrid/.*|ros2/.*")  # copied without REUSE.toml, which has the copyright of the rest
LINES_TO_REPORT = 350
TBB = r"(oneapi/)?tbb/.*"
STANDARD = re.compile(r"[a-z_0-9]+")  # <vector>; C++'s own headers have neither dot nor folder
# folders of one machine; written so that this file does not match itself
MACHINE_PATH = re.compile(r"(?<![\w.$}~*/-])/(?:wor[k]|hom[e]/\w+|roo[t]|User[s]/\w+|tmp/brie[f])(?:/|\b)")

# of the libraries that may be shared; what their headers declare has to be seen from outside
PUBLIC_HEADER = re.compile(r"((io|odometry|messages|mcap|server|capture|scenes|evaluation)/)?include/stereogrid/.*\.hpp")
NO_SYMBOL = re.compile(r"[\s#}/)]|(inline|constexpr|template|namespace|using|enum|struct|public|private)\b")

# they report a file system that is away as they report a missing file
PATH_QUERY = re.compile(r"\b(fs|filesystem)::(exists|is_[a-z_]+|directory_iterator)\b")
PATH_QUERIES = "io/src/files/paths.cpp"

DIRECT_OUTPUT = re.compile(r"\bfmt::print\b|\bstd::(cout|cerr|clog|printf|puts)\b")


@dataclass(frozen=True)
class Room:
    """A part of the tree and what its files may include."""

    folder: str
    include_roots: tuple[str, ...]  # quoted includes and <stereogrid/…> must be found in one of them
    others: str  # regular expression of what else it may include; None of it: the standard library only
    only_in: str = ".*"  # files within the folder that this room is about


APP = ("include", "odometry/include", "io/include", "messages/include", "mcap/include", "server/include", "capture/include",
       "rosbag/include", "dds/include", "scenes/include", "evaluation/include", "apps/stereogrid")

# the first that fits
ROOMS = (
    Room("include", ("include",), r"opencv2/core/mat\.hpp", r"include/stereogrid/opencv\.hpp"),
    Room("include", ("include",), "(?!)"),
    Room("odometry/include", ("include", "odometry/include"), "(?!)"),
    Room("io/include", ("include", "odometry/include", "io/include"), "(?!)"),
    Room("messages/include", ("include", "messages/include"), "(?!)"),
    Room("mcap/include", ("include", "mcap/include"), "(?!)"),
    Room("capture/include", ("include", "io/include", "capture/include"), "(?!)"),
    Room("rosbag/include", ("include", "io/include", "mcap/include", "messages/include", "rosbag/include"),
         r"opencv2/core/(affine|quaternion)\.hpp"),
    Room("dds/include", ("include", "messages/include", "dds/include"), "(?!)"),
    Room("scenes/include", ("include", "scenes/include"), "(?!)"),
    Room("evaluation/include", ("include", "evaluation/include"), "(?!)"),
    Room("src", ("include", "src"), TBB, r"src/backend/cpu\.hpp"),
    Room("src", ("include", "src"), r"hwy/.*", r".*_simd\.(cpp|hpp)"),
    Room("src", ("include", "src"), r"cuda.*|cub/.*|cooperative_groups.*", r"src/backend/cuda\.hpp|.*\.cu"),
    Room("src", ("include", "src"), r"(dlfcn|sys/auxv)\.h", r"src/pipeline/cuda_library\.cpp"),
    Room("src", ("include", "src"), "(?!)"),
    Room("odometry", ("include", "odometry/include", "odometry/src"), r"(opencv2|fmt)/.*"),
    Room("io", ("include", "odometry/include", "io/include", "io/src"), r"(opencv2|webp|yaml-cpp|nlohmann|fmt)/.*|isa-l\.h|(sys/)?\w+\.h"),
    Room("messages", ("include", "messages/include", "messages/src"), "(?!)"),
    Room("mcap", ("include", "io/include", "mcap/include", "mcap/src"),
         r"(yaml-cpp|fmt)/.*|(sys/)?\w+\.h"),
    Room("capture", ("include", "io/include", "capture/include", "capture/src"), r"(fmt|gst)/.*|(sys/)?\w+\.h"),
    Room("rosbag", ("include", "io/include", "mcap/include", "messages/include", "rosbag/include", "rosbag/src"),
         r"(opencv2|fmt)/.*"),
    Room("dds", ("include", "messages/include", "dds/include", "dds/src"), r"dds/.*|openssl/evp\.h"),
    Room("ros2", ("include", "odometry/include", "io/include", "messages/include", "capture/include", "ros2/stereogrid_nav2/src", "ros2/stereogrid_ros/src"),
         r"opencv2/.*|(geometry_msgs|nav2_costmap_2d|nav_msgs|pluginlib|rclcpp|rclcpp_components|rclcpp_lifecycle|sensor_msgs|stereo_msgs"
         r"|tf2_ros)/.*"),
    Room("viewer/playground", ("include", "messages/include", "src"), "(?!)"),  # replaces files of the core
    Room("scenes", ("include", "scenes/include", "scenes"), TBB),
    Room("evaluation", ("include", "evaluation/include", "evaluation/src"), TBB),
    Room("research", ("include", "odometry/include", "io/include", "evaluation/include", "research"), r"nlohmann/.*"),
    Room("python", ("include", "odometry/include", "io/include", "rosbag/include", "scenes/include", "evaluation/include", "apps/stereogrid",
                    "python/src"),
         r"(nanobind|nlohmann|fmt)/.*"),
    Room("apps", APP, r"(CLI|fmt|spdlog)/.*|(sys/)?\w+\.h", r"apps/stereogrid/cli/program\.cpp"),
    Room("apps", APP, r"(opencv2|nlohmann|fmt|spdlog)/.*|(sys/)?\w+\.h"),
)

# rooms in their order: a file includes those of its own room and of the rooms before it, never of a later one
ORDERS = {
    "src": ("backend", "geometry", "images", "matching", "ground", "terrain", "observation", "fusion", "filter", "motion",
            "obstacles/segmentation", "obstacles/tracking", "pipeline"),
    "io/src": ("files", "input", "vision", "run_folder"),
    "mcap/src": ("read", "write", "bag"),
    "server/src": ("foxglove", "http", "net"),
    "scenes": ("world", "layouts", "render", "truth"),
    "apps/stereogrid": ("pictures", "locks", "cli", "diagnostics", "connect", "live", "ros2"),
}


def files_of(root: Path) -> list[str]:
    """Files that belong to the project: what git would track, or all where this is no git checkout."""
    git = subprocess.run(["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                         capture_output=True, check=False)
    if git.returncode == 0:
        names = git.stdout.decode().split("\0")
        return sorted(name for name in set(names) if name and (root / name).is_file())
    walked = (path.relative_to(root) for path in root.rglob("*") if path.is_file())
    return sorted(str(path) for path in walked if path.parts[0] not in {".git", "build", "out"})


def room_of(name: str) -> "Room | None":
    return next((room for room in ROOMS if name.startswith(room.folder + "/") and re.fullmatch(room.only_in, name)), None)


def include_violation(root: Path, name: str, included: str) -> "str | None":
    room = room_of(name)
    if room is None or STANDARD.fullmatch(included) or re.fullmatch(room.others, included):
        return None
    # from one of the room's roots, or beside the file itself; "../" must not lead out
    starts = [(folder, folder) for folder in room.include_roots] + [(room.folder, str(Path(name).parent))]
    for allowed, start in starts:
        path = (root / start / included).resolve()
        if path.is_file() and path.is_relative_to((root / allowed).resolve()):
            return None
    return f"{room.folder}/ must not include {included}: dependencies point inwards (ARCHITECTURE.md)"


def order_violation(name: str, included: str) -> "str | None":
    """An include of a room that comes later in the order of its part of the tree."""
    for part, rooms in ORDERS.items():
        if not name.startswith(part + "/"):
            continue
        at, wanted = ([i for i, room in enumerate(rooms) if path.startswith(room + "/")] for path in (name[len(part) + 1:], included))
        if at and wanted and wanted[0] > at[0]:
            return f"{rooms[at[0]]}/ comes before {rooms[wanted[0]]}/ and must not include it: {included} (ORDERS in tests/rules/check.py)"
    return None


def not_exported(lines: list[str]) -> list[int]:
    """Numbers of the lines that declare a class or a function outside of classes, to be linked, without export."""
    found = []
    for number, line in enumerate(lines, start=1):
        if not line or NO_SYMBOL.match(line) or "STEREOGRID_EXPORT" in line or lines[number - 2].startswith("template"):
            continue
        ending = next((later for later in lines[number - 1:] if later.endswith((";", "{", "}"))), "")
        if re.match(r"class\b.*\{$", line) or ("(" in line and ending.endswith(";")):
            found.append(number)
    return found


def uncommented(lines: list[str]) -> list[int]:
    """Numbers of the lines that export a name without a comment above; overloads on successive lines share one."""
    numbers = []
    for number, line in enumerate(lines, start=1):
        name = re.match(r"(?:\[\[nodiscard\]\] |class |struct )*STEREOGRID_EXPORT (?:.*?(\w+)\(|\w+)", line)
        above = number - 2
        while name and above >= 0 and (re.match(r"(template|requires)\b", lines[above]) or f" {name[1] or '?'}(" in lines[above]):
            above -= 1
        if name and (above < 0 or not lines[above].startswith("///")):
            numbers.append(number)
    return numbers


FRAME = "src/pipeline/frame_pipeline.cpp"
CAMERA = "src/pipeline/camera_pipeline.cpp"
# they have no box in the figure
NO_STAGE = {"process", "at", "of", "grids_of", "place_of", "has_one_camera", "read", "matched", "both", "held", "vectors", "clear",
            "reset", "for_cameras"}


def picture_violations(root: Path) -> list[str]:
    """Stages that process() calls and the figure of ARCHITECTURE.md lacks, and the other way round."""
    files = [root / name for name in (FRAME, CAMERA) if (root / name).exists()]
    text = "".join(file.read_text(encoding="utf-8") for file in files)
    bodies = r" (?:FramePipeline::process|CameraPipeline::(?:begin|look|observe|check|settle))\(.*?\n}\n"
    body = "".join(re.findall(bodies, text, re.DOTALL))
    headers = "".join(file.with_suffix(".hpp").read_text(encoding="utf-8") for file in files)
    helpers = set(re.findall(r" (\w+)\(", headers))
    called = set(re.findall(r"(?:stages_->|estimator_\.|state_\.\w+\.|of\(now\)\.|camera\.)(\w+)\(", body))
    called |= helpers & set(re.findall(r"(?<![\w.>:])(\w+)\(", body))
    picture = (root / "ARCHITECTURE.md").read_text(encoding="utf-8").split("```")[1]
    lacking = called - NO_STAGE - set(re.findall(r"\w+", picture))
    gone = set(re.findall(r"(\w+) +──►", picture)) - called
    return [f"ARCHITECTURE.md:1: the picture of a frame {what} {name}: see {FRAME}"
            for what, names in (("lacks", lacking), ("has no longer", gone)) for name in sorted(names)]


def violations(root: Path, names: list[str]) -> list[str]:
    found = []
    for name in names:
        path = root / name
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:  # a picture
            continue
        lines = text.splitlines()
        found += links.violations(root, name, text)
        if path.suffix in WITH_LICENCE or path.name == "CMakeLists.txt" or "".join(lines[:1]).startswith("#!"):
            head = "\n".join(lines[:4])
            required = (LICENCE, COPYRIGHT) if WITH_COPYRIGHT.fullmatch(name) else (LICENCE,)
            found += [f"{name}:1: missing line: {line}" for line in required if line not in head]
            if COPYRIGHT in head and COPYRIGHT not in required:
                found.append(f"{name}:1: the copyright is in REUSE.toml; delete the line")
        if PUBLIC_HEADER.fullmatch(name):
            found += [f"{name}:{number}: a shared library hides it; STEREOGRID_EXPORT is missing (export.hpp)"
                      for number in not_exported(lines)]
            found += [f"{name}:{number}: an exported name without a comment" for number in uncommented(lines)]
        for number, line in enumerate(lines, start=1):
            if MACHINE_PATH.search(line):
                found.append(f"{name}:{number}: a path of somebody's machine: {line.strip()}")
            if name.startswith("apps/stereogrid/") and DIRECT_OUTPUT.search(line):
                found.append(f"{name}:{number}: throws or is silent where the stream is full; take console.hpp")
            if name.startswith(("io/", "mcap/", "rosbag/", "apps/stereogrid/")) and name != PATH_QUERIES and PATH_QUERY.search(line):
                found.append(f"{name}:{number}: takes a file system that is away for a missing file; take io/paths.hpp")
            include = re.match(r'\s*#\s*include\s*[<"]([^>"]+)[>"]', line) if path.suffix in CODE else None
            if include and (sentence := include_violation(root, name, include[1]) or order_violation(name, include[1])):
                found.append(f"{name}:{number}: {sentence}")
    return found


def long_files(root: Path, names: list[str]) -> list[str]:
    lengths = ((name, (root / name).read_bytes().count(b"\n")) for name in names if Path(name).suffix in CODE | {".py"})
    return [f"{name}: {lines} lines; is there a missing concept?" for name, lines in lengths if lines > LINES_TO_REPORT]


def main() -> int:
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2]).resolve()
    names = files_of(root)
    found = violations(root, names) + language.violations(root, names) + picture_violations(root)
    for note in long_files(root, names):
        print("note:", note)
    for violation in found:
        print(violation)
    print(f"{len(names)} files, {len(found)} violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks what a shared object shows of the library.

symbols.py library NM LIBRARY INCLUDE_FOLDER   shows what public headers declare, and the types that cross its border
symbols.py plugin NM PLUGIN                    shows its own function; of the library nothing but exceptions' types
"""
import re
import subprocess
import sys
from pathlib import Path

EXCEPTION_TYPE = re.compile(r"(typeinfo|typeinfo name|vtable) for stereogrid::(ConfigError|InputError|DeviceError)")
NEEDED = ("stereogrid::Pipeline::process(", "stereogrid::preset(", "stereogrid::version(",
          "typeinfo for stereogrid::ConfigError", "typeinfo for stereogrid::InputError",
          "typeinfo for stereogrid::DeviceError")


def shown(nm: str, file: str) -> list[str]:
    """Demangled names that others can link to."""
    lines = subprocess.run([nm, "--dynamic", "--defined-only", "--demangle", file], check=True, capture_output=True,
                           text=True).stdout.splitlines()
    return [line.split(maxsplit=2)[2] for line in lines]


def is_of_standard_library(name: str) -> bool:
    """Templates of the standard library for types of its own: every library has some."""
    what = r"(guard variable for |typeinfo (name )?for |vtable for |[\w:<>,*& ]+ )?"
    return re.match(what + r"(std|__gnu_cxx)::", name) is not None


def is_public(name: str, headers: str) -> bool:
    """True for an exported function, a member function of an exported class, or a symbol of such a type."""
    if (kind := re.match(r"(typeinfo|typeinfo name|vtable) for stereogrid::(\w+)$", name)) is not None:
        return re.search(rf"\bclass STEREOGRID_EXPORT {kind[2]}\b", headers) is not None
    parts = re.sub(r"\[abi:\w+\]", "", name).split("(")[0].split("::")
    if parts[0] != "stereogrid" or len(parts) not in (2, 3):
        return False
    function = rf"[^;{{}}()]*(?<![\w~]){re.escape(parts[-1])}\("
    if re.search("STEREOGRID_HIDDEN" + function, headers) is not None:
        return False
    before = "STEREOGRID_EXPORT" if len(parts) == 2 else rf"class STEREOGRID_EXPORT {parts[1]}\b.*[;{{}}()]"
    return re.search(before + function, headers, re.DOTALL) is not None


def library_problems(names: list[str], headers: str) -> list[str]:
    found = [f"shows what no public header declares: {name}" for name in names
             if not is_of_standard_library(name) and not is_public(name, headers)]
    return found + [f"does not show {needed}" for needed in NEEDED if not any(name.startswith(needed) for name in names)]


def plugin_problems(names: list[str]) -> list[str]:
    found = [] if "plugin_works" in names else ["does not show its own function"]
    return found + [f"shows {name}" for name in names
                    if name != "plugin_works" and not is_of_standard_library(name) and not EXCEPTION_TYPE.fullmatch(name)]


def main() -> int:
    kind, nm, file = sys.argv[1:4]
    names = shown(nm, file)
    if kind == "library":
        headers = "\n".join(path.read_text(encoding="utf-8") for path in sorted(Path(sys.argv[4]).rglob("*.hpp")))
        found = library_problems(names, headers)
    else:
        found = plugin_problems(names)
    for problem in found:
        print(f"{file} {problem}")
    print(f"{file}: {len(names)} symbols, {len(found)} problems")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks what a shared object shows of the library.

symbols.py library NM LIBRARY INCLUDE_FOLDER   shows what public headers declare, and the types that cross its border
symbols.py plugin NM PLUGIN                    shows its own function; of the library nothing but exceptions' types
symbols.py                                     tests these checks
"""
import re
import subprocess
import sys
import unittest
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


HEADERS = """
[[nodiscard]] STEREOGRID_EXPORT Config preset(std::string_view name);
STEREOGRID_EXPORT std::string_view version();
[[nodiscard]] inline Pose2 inverse(const Pose2& a_from_b) {}
class STEREOGRID_EXPORT ConfigError : public std::runtime_error {};
class STEREOGRID_EXPORT InputError : public std::runtime_error {};
class STEREOGRID_EXPORT DeviceError : public std::runtime_error {};
class STEREOGRID_EXPORT Pipeline {
 public:
  Pipeline(Pipeline&&) noexcept;
  ~Pipeline();
  const FrameResult& process(const StereoFrame& frame);
  struct STEREOGRID_HIDDEN Implementation;
  [[nodiscard]] STEREOGRID_HIDDEN Implementation& implementation() const;
};
"""
PUBLIC = ["stereogrid::Pipeline::process(stereogrid::StereoFrame const&)", "stereogrid::Pipeline::~Pipeline()",
          "stereogrid::Pipeline::Pipeline(stereogrid::Pipeline&&)", "stereogrid::version()",
          "stereogrid::preset(std::basic_string_view<char, std::char_traits<char> >)"]
TYPES = [f"{kind} for stereogrid::{name}" for kind in ("typeinfo", "typeinfo name", "vtable")
         for name in ("ConfigError", "InputError", "DeviceError")]
OF_STANDARD_LIBRARY = ["std::vector<float, std::allocator<float> >::reserve(unsigned long)",
                       "double* std::__addressof<double>(double&)",
                       "std::__detail::__to_chars_10_impl<unsigned int>(char*, unsigned int, unsigned int)::__digits"]
INTERNAL = ["stereogrid::inverse(stereogrid::Pose2 const&)", "stereogrid::process(stereogrid::StereoFrame const&)",
            "stereogrid::Pipeline::Implementation::process(stereogrid::StereoFrame const&)",
            "stereogrid::Pipeline::implementation() const", "stereogrid::Tracker::process(int)",
            "stereogrid::filter::version()", "typeinfo for stereogrid::Tracker", "hwy::GetChosenTarget()",
            "tbb::detail::r1::deallocate(void*)", "vtable for tbb::detail::d1::task", "build_id"]


class Symbols(unittest.TestCase):
    """These checks find what must not be seen, and accept what may."""

    def test_a_library_shows_what_headers_declare(self):
        self.assertEqual(library_problems(PUBLIC + TYPES + OF_STANDARD_LIBRARY, HEADERS), [])

    def test_a_library_shows_nothing_else(self):
        for name in INTERNAL:
            self.assertEqual(len(library_problems(PUBLIC + TYPES + [name], HEADERS)), 1, name)

    def test_a_library_shows_what_programs_need(self):
        for missing in ("stereogrid::version()", "typeinfo for stereogrid::InputError"):
            names = [name for name in PUBLIC + TYPES if name != missing]
            self.assertEqual(library_problems(names, HEADERS), [f"does not show {missing.rstrip(')')}"])

    def test_a_plugin_shows_its_own(self):
        self.assertEqual(plugin_problems(["plugin_works"] + TYPES + OF_STANDARD_LIBRARY), [])
        self.assertEqual(len(plugin_problems([])), 1)
        for name in INTERNAL + PUBLIC:
            self.assertEqual(len(plugin_problems(["plugin_works", name])), 1, name)


def main() -> int:
    if sys.argv[1:] == []:
        return unittest.main()
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

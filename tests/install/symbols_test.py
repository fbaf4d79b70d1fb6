#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""symbols.py finds what must not be seen, and lets pass what may."""
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import symbols  # noqa: E402

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
    def test_a_library_shows_what_headers_declare(self):
        self.assertEqual(symbols.library_problems(PUBLIC + TYPES + OF_STANDARD_LIBRARY, HEADERS), [])

    def test_a_library_shows_nothing_else(self):
        for name in INTERNAL:
            self.assertEqual(len(symbols.library_problems(PUBLIC + TYPES + [name], HEADERS)), 1, name)

    def test_a_library_shows_what_programs_need(self):
        for missing in ("stereogrid::version()", "typeinfo for stereogrid::InputError"):
            names = [name for name in PUBLIC + TYPES if name != missing]
            self.assertEqual(symbols.library_problems(names, HEADERS), [f"does not show {missing.rstrip(')')}"])

    def test_a_plugin_shows_its_own(self):
        self.assertEqual(symbols.plugin_problems(["plugin_works"] + TYPES + OF_STANDARD_LIBRARY), [])
        self.assertEqual(len(symbols.plugin_problems([])), 1)
        for name in INTERNAL + PUBLIC:
            self.assertEqual(len(symbols.plugin_problems(["plugin_works", name])), 1, name)


if __name__ == "__main__":
    unittest.main()

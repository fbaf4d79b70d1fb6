#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of check.py, language.py and .githooks/commit-msg: each rule finds its violations and accepts the rest."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import check  # noqa: E402
import language  # noqa: E402

LICENCE = f"// {check.LICENCE}\n"
COPYRIGHT = f"// {check.COPYRIGHT}\n"


class Rules(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        for name in ("include/stereogrid/grid.hpp", "io/include/stereogrid/io/npz.hpp", "io/src/own.hpp",
                     "src/filter/filter.hpp", "src/backend/cpu.hpp", "scenes/world.hpp"):
            self.write(name, LICENCE)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return name

    def found(self, name, text, licence=None):
        if licence is None:
            licence = COPYRIGHT * bool(check.WITH_COPYRIGHT.fullmatch(name)) + LICENCE
        return check.violations(self.root, [self.write(name, licence + text)])

    def test_the_picture_of_a_frame(self):
        self.write("src/pipeline/frame_pipeline.hpp", "  void publish(int frame);\n")
        self.write(check.FRAME, "void FramePipeline::process(int frame) {\n  stages_->match(frame);\n  publish(frame);\n}\n")
        for picture, lacks in (("match ──► disparities\n publish", ""), ("match ──► disparities", "publish"),
                               ("match ──► a\n publish ──► b\n count ──► c", "count")):
            self.write("ARCHITECTURE.md", f"```\n{picture}\n```\n")
            found = " ".join(check.picture_violations(self.root))
            self.assertEqual(lacks in found and bool(lacks), bool(found), picture)

    def assert_allowed(self, name, include):
        self.assertEqual(self.found(name, f"#include {include}\n"), [])

    def assert_forbidden(self, name, include):
        self.assertEqual(len(self.found(name, f"#include {include}\n")), 1, f"{name} includes {include}")

    def test_public_headers_need_the_standard_library_only(self):
        for header in ("include/stereogrid/new.hpp", "io/include/stereogrid/io/new.hpp"):
            self.assert_allowed(header, "<vector>")
            self.assert_allowed(header, '"stereogrid/grid.hpp"')
            for other in ("<opencv2/core.hpp>", "<cuda_runtime.h>", "<oneapi/tbb/task_arena.h>", "<stdint.h>",
                          "<yaml-cpp/yaml.h>", "<nlohmann/json.hpp>", "<hwy/highway.h>", '"filter/filter.hpp"'):
                self.assert_forbidden(header, other)
        self.assert_forbidden("include/stereogrid/new.hpp", '"stereogrid/io/npz.hpp"')

    def test_rooms_include_those_before_them(self):
        for name in ("src/images/patch.hpp", "src/filter/filter.hpp", "io/src/files/file.hpp", "io/src/input/layout/layout.hpp"):
            self.write(name, LICENCE)
        self.assert_allowed("src/filter/new.cpp", '"images/patch.hpp"')
        self.assert_forbidden("src/images/new.cpp", '"filter/filter.hpp"')
        self.assert_allowed("io/src/input/new.cpp", '"files/file.hpp"')
        self.assert_forbidden("io/src/files/new.cpp", '"input/layout/layout.hpp"')

    def test_what_public_headers_declare_is_exported_with_a_comment(self):
        for header in ("include/stereogrid/new.hpp", "io/include/stereogrid/io/new.hpp"):
            for text in ("void set(int value);", "[[nodiscard]] std::string get(int key,\n                  int other);",
                         "class Pipeline {\n};", "class Recording final : public FrameSource {\n};"):
                self.assertEqual(len(self.found(header, text + "\n")), 1, text)
            for text in ("/// A.\nSTEREOGRID_EXPORT void set(int value);\nSTEREOGRID_EXPORT void set();",
                         "/// A.\nclass STEREOGRID_EXPORT Pipeline {\n  void process();\n};", "template <class T>\nclass Image {\n};",
                         "template <class T>\nvoid visit(T& value);", "struct Rig {\n  int width() const;\n};",
                         "[[nodiscard]] inline Pose2 inverse(Pose2 pose) {\n}", "constexpr int names_of(int) {\n}",
                         "class Later;", "using Call = std::function<void(int)>;"):
                self.assertEqual(self.found(header, text + "\n"), [], text)
            for text in ("STEREOGRID_EXPORT void set();", "/// A.\nstruct A {};\n[[nodiscard]] STEREOGRID_EXPORT int get();"):
                self.assertEqual(len(self.found(header, text + "\n")), 1, text)
        self.assertEqual(self.found("src/filter/filter.hpp", "void filter();\n"), [])

    def test_the_tool_speaks_through_its_console(self):
        for line in ('fmt::print("done");', 'fmt::print(stderr, "done");', 'std::cout << "done";'):
            self.assertEqual(len(self.found("apps/stereogrid/run.cpp", line + "\n")), 1, line)
        self.assertEqual(self.found("apps/stereogrid/run.cpp", 'tell("done");\n'), [])
        self.assertEqual(self.found("examples/small.cpp", 'std::cout << "done";\n'), [])

    def test_paths_are_queried_in_one_place(self):
        for line in ("if (fs::exists(path, error)) return;", "std::filesystem::directory_iterator entry{folder};"):
            self.assertEqual(len(self.found("io/src/input/layout.cpp", line + "\n")), 1, line)
            self.assertEqual(self.found("io/src/files/paths.cpp", line + "\n"), [])
            self.assertEqual(self.found("tests/io/layout.cpp", line + "\n"), [])
        self.assertEqual(self.found("io/src/input/layout.cpp", "if (is_there(path)) return;\n"), [])

    def test_the_core_knows_only_itself(self):
        self.assert_allowed("src/filter/cpu.cpp", '"filter/filter.hpp"')
        for other in ('"stereogrid/io/npz.hpp"', '"../../io/src/own.hpp"', "<opencv2/core.hpp>", "<fmt/format.h>"):
            self.assert_forbidden("src/filter/cpu.cpp", other)

    def test_threads_simd_and_cuda_have_one_place_each(self):
        self.assert_allowed("src/backend/cpu.hpp", "<oneapi/tbb/parallel_for.h>")
        self.assert_allowed("src/matching/correlation/correlate_simd.cpp", '"hwy/highway.h"')
        self.assert_allowed("src/filter/cuda.cu", "<cuda_runtime.h>")
        for other in ("<oneapi/tbb/parallel_for.h>", '"hwy/highway.h"', "<cuda_runtime.h>"):
            self.assert_forbidden("src/filter/cpu.cpp", other)

    def test_outer_parts_know_only_public_headers_of_others(self):
        self.assert_allowed("io/src/new.cpp", '"own.hpp"')
        self.assert_allowed("apps/stereogrid/main.cpp", '"stereogrid/io/npz.hpp"')
        self.assert_forbidden("io/src/new.cpp", '"../../scenes/world.hpp"')
        self.assert_forbidden("io/src/new.cpp", '"backend/cpu.hpp"')
        self.assert_forbidden("scenes/new.cpp", '"stereogrid/io/npz.hpp"')
        self.assert_forbidden("apps/stereogrid/main.cpp", '"backend/cpu.hpp"')

    def test_research_stands_outside(self):
        self.write("apps/stereogrid/input.hpp", LICENCE)
        self.write("research/baselines/columns.hpp", LICENCE)
        self.assert_allowed("research/baselines/new.cpp", '"baselines/columns.hpp"')
        self.assert_forbidden("research/baselines/new.cpp", '"input.hpp"')
        self.assert_forbidden("research/baselines/new.cpp", '"filter/filter.hpp"')
        self.assert_forbidden("apps/stereogrid/main.cpp", '"baselines/columns.hpp"')

    def test_licence_lines(self):
        for name, licence, faults in (("src/new.cpp", "", 1), ("src/CMakeLists.txt", "# SPDX-License-Identifier: MIT\n", 1),
                                      ("src/new.cpp", COPYRIGHT + LICENCE, 1), ("include/stereogrid/new.hpp", LICENCE, 1),
                                      ("io/include/stereogrid/io/new.hpp", "", 2), ("ros2/new.cpp", COPYRIGHT + LICENCE, 0)):
            self.assertEqual(len(self.found(name, "int x;\n", licence=licence)), faults, name)
        self.assertEqual(self.found("notes.txt", "any\n", licence=""), [])

    def test_paths_of_one_machine(self):
        for path in ("/".join(("", "wor" + "k", "x")), "/".join(("", "hom" + "e", "me", "x")), "/roo" + "t/x"):
            self.assertEqual(len(self.found("notes/page.md", f"see {path}\n")), 1, path)
        for text in ("at work/home", "${prefix}/wor" + "k/x", "./roo" + "t/x", "a/wor" + "k/b"):
            self.assertEqual(self.found("notes/page.md", f"see {text}\n"), [], text)

    def test_links_lead_somewhere(self):
        docs = "docs" + "/"  # in two parts, so that this file names no page itself
        self.write(f"{docs}page.md", "# Page\n\n## 2.1 A heading, long\n\n```\n# no heading\n```\n")
        good = ("[a](page.md)", "[a](page.md#21-a-heading-long)", "[a](#here)\n# Here", "[a](../include)",
                "[a](https://example.org/x)", "```\n[a](nowhere.md)\n```", f"{docs}page.md §2.1")
        for text in good:
            self.assertEqual(self.found(f"{docs}other.md", text + "\n"), [], text)
        bad = ("[a](nowhere.md)", "[a](page.md#no-heading)", "[a](#nowhere)", f"see {docs}nowhere.md",
               f"{docs}page.md §2.2", f"{docs}page.md §2.1 (one), §2.1 and §3")
        for text in bad:
            self.assertEqual(len(self.found(f"{docs}other.md", text + "\n")), 1, text)
        self.assertEqual(len(self.found("src/new.cpp", f"// {docs}page.md §4\n")), 1)

    def test_links_to_pages_that_the_site_generates(self):
        docs = "docs" + "/"
        self.assertEqual(len(self.found(f"{docs}other.md", "[a](results.md)\n")), 1)
        self.write("scripts/results.py", "print('# Measured\\n\\n## On a GPU')\n")
        self.write("bench/results.json", "{}\n")
        for text, faults in (("[a](results.md)", 0), ("[a](results.md#on-a-gpu)", 0), ("[a](results.md#elsewhere)", 1),
                             ("[a](../bench/results.json#on-a-gpu)", 0), ("[a](../bench/results.json#elsewhere)", 1)):
            self.assertEqual(len(self.found(f"{docs}other.md", text + "\n")), faults, text)

    def assert_language(self, name, text, rule):
        found = language.findings(name, text)
        self.assertEqual([line.split(": ")[1] for line in found], [rule] if rule else [], text)

    def test_language_of_comments_and_messages(self):
        for text in ("// What has no room is left out.", "int x;  // how it is mounted", "/* Of a frame. */", "// Is it free?"):
            self.assert_language("src/new.cpp", text + "\n", "first word")
        for text in ("// Maximum number of points.", "// Angle of\n// what follows", 'auto s{"http://What"};', "int what_if;"):
            self.assert_language("src/new.cpp", text + "\n", None)
        self.assert_language("apps/new.cpp", 'help("What is in an input.");\n', "first word")
        self.assert_language("tests/new.cpp", 'help("What is in an input.");\n', None)
        self.assert_language("src/new.cpp", "// The filter knows the pose.\n", "personification")
        self.assert_language("src/new.cpp", "// Use `knows` or knows_pose().\n", None)
        self.assert_language("research/new.py", '"""Draws\n\nrows that are born."""\n', "term")
        self.assert_language("research/new.py", '"""Draws."""\nx = "# Of"\n', None)
        self.assert_language("cmake/new.cmake", "set(x 1)  # how it is\n", "first word")

    def test_language_of_pages(self):
        words = "word " * (language.MAX_WORDS - 1)
        self.assert_language("notes/new.md", f"{words}end. Next {words.rstrip()}.\n", None)
        self.assert_language("notes/new.md", f"{words}too\nlong.\n", "length")
        self.assert_language("notes/new.md", f"```\n{words}too long.\n```\n\n`{words}too long`\n", None)
        self.assert_language("notes/new.md", "| a | The tool tells it. |\n", "personification")

    def test_language_of_files(self):
        (self.root / "image.png").write_bytes(b"\x89PNG")
        names = ["image.png", self.write("scripts/a.sh", "# Place.\n"), self.write("scripts/b.sh", "# What is it.\n")]
        self.assertEqual([line.split(": ")[0] for line in language.violations(self.root, names)], ["scripts/b.sh:1"])

    def test_language_of_identifiers(self):
        names = [self.write("src/a.cpp", "int is_told; // told\nTEST(Frame, IsTold) {}\nauto s{\"told\"};\n"), self.write("src/b.py", "told = 1\n")]
        found = language.violations(self.root, names)
        self.assertEqual([line.split(": ")[:3] for line in found if ": identifier: 3 places" in line],
                         [["src/a.cpp", "IsTold", "identifier"], ["src/a.cpp", "is_told", "identifier"], ["src/b.py", "told", "identifier"]])
        names = [self.write("src/a.cpp", "int take_one;\n")]
        self.assertEqual(language.violations(self.root, names), [])

    def test_language_of_messages(self):
        self.assert_language("src/new.cpp", 'fail("the value is no number");\n', "term")
        self.assert_language("src/new.cpp", 'fail("there is no such file");\n', None)
        self.assert_language("src/new.cpp", "// A ramp is no obstacle.\n", None)

    def test_commit_subjects(self):
        hook = Path(__file__).parents[2] / ".githooks" / "commit-msg"
        for subject, status in (("filter: " + "x" * 64, 0), ("filter: " + "é" * 64, 0), ("filter: " + "x" * 65, 1)):
            message = self.root / self.write("message", f"# comment\n\n{subject}\n\n{'body ' * 30}\n")
            self.assertEqual(subprocess.run([hook, message], capture_output=True).returncode, status, subject)


if __name__ == "__main__":
    unittest.main()

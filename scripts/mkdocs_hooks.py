# SPDX-License-Identifier: Apache-2.0
"""Hooks of mkdocs.yml. Pages of constants, of results and of runs are generated. In all pages

* links to bench/results.json lead to the page made of it;
* links to other files outside of docs/ lead to the forge of `repo_url`, or become plain text without one (tests/rules/links.py checks them);
* blocks of ```math become MathML, and symbols such as a_u outside of code get an index;
* <!-- snippet FILE --> is followed by the code of an example, as in README.md;
* bold lines between <!-- tabs --> and <!-- end --> become tabs.
"""
import logging
import re
from pathlib import Path
from textwrap import indent

import gallery
import playground
from constants import page as constants_page
from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File
from readme import snippet
from results import page as results_page


def on_files(files, config):
    files.append(File.generated(config, "constants.md", content=constants_page()))
    files.append(File.generated(config, "results.md", content=results_page()))
    files.append(File.generated(config, "gallery.md", content=gallery.page()))
    return files


def on_post_build(config):
    folder = Path(config.site_dir) / "gallery"
    if program := gallery.tool():
        gallery.make(program, folder)
    else:
        logging.getLogger("mkdocs").info("The gallery has no runs: build the tool first, or name it in STEREOGRID.")
    if program and playground.WASM.is_file():
        playground.make(program, playground.WASM, folder / "playground")
    else:
        logging.getLogger("mkdocs").info("The gallery has no playground: build the tool and viewer/playground first.")


def formula(latex: str) -> str:
    """MathML of a block; raises PluginError if it has a command that latex2mathml does not know, which it would show as text."""
    mathml = convert(latex.replace("\n", " ").replace("{aligned}", "{align*}"), display="block")
    if unknown := re.search(r"\\[A-Za-z]+", mathml):
        raise PluginError(f"formula with unknown command {unknown[0]}: {latex.strip()}. Use a command of latex2mathml.")
    return f'<div class="formula">{mathml}</div>\n'


def with_indices(markdown: str) -> str:
    """Symbols of one letter with an index, such as a_u; code and headings are left as they are."""
    return re.sub(r"(^```.*?^```|`[^`\n]+`|^#[^\n]*)|(?<!\w)([^\W\d_])_(\w+)",
                  lambda match: match[1] or f"{match[2]}<sub>{match[3]}</sub>", markdown, flags=re.DOTALL | re.MULTILINE)


def tabs(block: str) -> str:
    _, *parts = re.split(r"^\*\*(.+)\*\*\n", block, flags=re.MULTILINE)
    return "".join(f'=== "{name}"\n\n{indent(text, "    ")}\n' for name, text in zip(parts[::2], parts[1::2]))


def on_page_markdown(markdown, page, config, **_):
    if page.url == "":
        page.meta["hide"] = ["navigation", "toc"]
    markdown = markdown.replace("](../bench/results.json", "](results.md")
    up = r"\.\./" * (page.file.src_uri.count("/") + 1)
    link = rf"[\1]({config.repo_url}/blob/HEAD/\2)" if config.repo_url else r"\1"
    markdown = re.sub(rf"(?<!!)\[([^\]]+)\]\({up}([^)]*)\)", link, markdown)
    markdown = re.sub(r"^```math\n(.*?)^```\n", lambda match: formula(match[1]), markdown, flags=re.DOTALL | re.MULTILINE)
    markdown = with_indices(markdown)
    markdown = re.sub(r"<!-- snippet (\S+) -->", lambda match: snippet(match[1]), markdown)
    return re.sub(r"<!-- tabs -->(.*?)<!-- end -->", lambda match: tabs(match[1]), markdown, flags=re.DOTALL)

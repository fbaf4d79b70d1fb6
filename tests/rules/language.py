#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the language of comments, docstrings, messages, pages and identifiers.

language.py [ROOT]   prints file:line: rule: text: suggestion; exit status 1 if there are findings
"""
import ast
import functools
import io
import re
import sys
import tokenize
from dataclasses import dataclass
from pathlib import Path

MAX_WORDS = 30
# texts about banned words, and history
SKIPPED = re.compile(r"tests/rules/|CHANGELOG\.md$|docs/results\.md$|tests/.*/data/")
C_LIKE = {".hpp", ".cpp", ".cu", ".cuh", ".h", ".js"}
HASH = {".sh", ".cmake", ".yml", ".yaml", ".smk"}
C_TOKEN = re.compile(r'R"(?P<raw>\w*)\(.*?\)(?P=raw)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|//[^\n]*|/\*.*?\*/', re.DOTALL)
# what no rule applies to: code, paths, options, addresses, identifiers
VERBATIM = re.compile(r"`[^`]*`|\]\([^)]*\)|<[^>\s][^>]*>|https?:\S+|--[\w-]+|[\w.-]*/[\w./-]+|\w*[_:(]\w+[\w:().]*|\w+\.\w{2,4}\b")

FIRST_WORD = re.compile(r"(?:what|of|those|that|how|where|as if|so many|whatever|whoever|nobody|who)\b(?! *[=:(])|"
                        r"(?:is|are|does|do|has|have|can|should)\b[^.?]*\?", re.IGNORECASE)
PERSON = (r"hears?|heard|tells?|told|wish(?:es|ed)?|believes?|believed|knows|lends?|lent|looks(?! like)|doubts?|doubted|speaks?|forgets?|"
          r"listens? to|asks|asked|thinks?|wants|remembers|remembered|gives up|refuses|judges?|judged")
PERSONIFICATION = re.compile(rf"\b({PERSON})\b", re.IGNORECASE)
# expression: term of the field
TERMS = {
    r"centre_[uv]_px": "cx_px, cy_px",
    r"mountings?\b|mounted at": "extrinsics",
    r"rows? (?:are|is) off|row alignment": "epipolar rectification error; epipolar alignment",
    r"extended things?\b": "boundary",
    r"hand(?:s|ed|ing)? (?:over|on)\b": "pass",
    r"forgetting|forgotten": "decay; state is reset",
    r"\bborn\b": "birth",
    r"\bwhat (?:moves|stands)\b": "dynamic, static",
    r"not known\b": "unknown, unobserved",
    r"lost road|road elsewhere|road is lost": "ground lost",
    r"given disparit(?:y|ies)|disparities given": "external disparities",
    r"upright pixels?": "obstacle pixels",
    r"way of a frame": "frame pipeline",
    r"\bsinks?\b": "publisher",
    r"frames? in flight": "in-flight frame",
    r"\bgets? in\b": "access is granted / denied",
    r"(?:so|as) long as\b": "while",
    r"as soon as\b": "when",
    r"\bpictures?\b": "image, figure, visualisation",
    r"sayings?\b|a sentence\b": "text, message, description",
    r"\b(?:nobody|somebody|anybody|whoever)\b": "name the user, program or thread",
    r"\b(?:goes|go|going|carried|carries) on\b": "continue",
    r"\bso (?:many|much)\b": "number of; by",
    r"(?<=. )what (?:is|was|are|has|have|had|lies|comes|appears|occupies|differs|belongs)\b(?! wrong)": "begin with the noun",
    r"cannot be (?:true|right|meant)|that cannot be\b(?! \w+(?:ed|en|t)\b)": "is implausible / invalid",
}
# of messages alone
IS_NO = re.compile(r"(?<!here )\b(?:is|are) no (?!longer|more|such|other|pose|one\b)\w+|begins? anew", re.IGNORECASE)
# word of an identifier: (largest number of places in code, word of the field). The numbers only fall.
IDENTIFIERS = {
    "tells?|telling|told": (0, "report, notify, set"),
    "complain(?:s|ed|ts?)?": (0, "reject, report; problem, error"),
    "forgets?|forgetting|forgot(?:ten)?": (0, "reset, drop; decay"),
    "born|anew": (0, "birth; restart"),
    "believes?|believed|doubt(?:s|ed|ful)?|judges?|judged": (0, "accept, check; weighted, uncertain"),
    "hears?|heard|lends?|lent|wish(?:es|ed)?": (0, "receive, reference, request"),
    "takes?|taken|took": (613, "read, receive, set, claim"),
    "given": (496, "set by the user; external"),
    "rooms?": (199, "workspace, capacity"),
    "says?|said": (311, "text, message, output"),
    "things?": (217, "object, obstacle"),
    "wants?|wanted": (266, "request, require"),
}
TERM = re.compile("|".join(f"({pattern})" for pattern in TERMS), re.IGNORECASE)


@dataclass(frozen=True)
class Text:
    """A comment, message or paragraph; consecutive comment lines are one text."""

    line: int
    kind: str  # "comment", "message" or "page"
    text: str


def joined(pieces: list[tuple[int, int, str]], lines: list[str]) -> list[Text]:
    """Comments (line, column, text); a line without code continues the comment above it at the same column."""
    found: list[list] = []
    for line, column, text in pieces:
        is_alone = not lines[line - 1][:column].strip(" \t#/*")
        if is_alone and found and found[-1][1:3] == [line - 1, column] and found[-1][3] and text:
            found[-1][1] = line
            found[-1][3] += " " + text
        else:
            found.append([line, line, column, text])
    return [Text(start, "comment", text) for start, _, _, text in found]


def c_texts(text: str) -> list[Text]:
    comments, messages = [], []
    for match in C_TOKEN.finditer(text):
        token, line = match[0], text.count("\n", 0, match.start()) + 1
        if token.startswith("/"):
            column = match.start() - text.rfind("\n", 0, match.start()) - 1
            body = re.sub(r"\n\s*\*?", " ", token[2:-2]) if token.startswith("/*") else token.lstrip("/<! ")
            if token.startswith("/*") and " " not in body:  # name of a parameter
                continue
            comments.append((line, column, body.strip()))
        elif token.startswith(('"', "R")) and token.count(" ") >= 2:
            messages.append(Text(line, "message", token.strip('"R')))
    return joined(comments, text.splitlines()) + messages


def python_texts(text: str) -> list[Text]:
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    comments = [(token.start[0], token.start[1], token.string.lstrip("# ")) for token in tokens if token.type == tokenize.COMMENT]
    texts = joined(comments, text.splitlines())
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and (doc := ast.get_docstring(node)):
            texts.append(Text(node.body[0].lineno, "comment", doc))
    return texts


def hash_texts(text: str) -> list[Text]:
    comments = []
    for number, line in enumerate(text.splitlines(), start=1):
        if match := re.search(r"(?:^|\s)#(?!!)\s*(.*)", line):
            comments.append((number, match.start(1), match[1]))
    return joined(comments, text.splitlines())


def page_texts(text: str) -> list[Text]:
    """Paragraphs, list items and table cells of Markdown, without blocks of code."""
    text = re.sub(r"^( *)```.*?^ *```|<!--.*?-->|^\$\$.*?^\$\$", lambda match: re.sub(r"[^\n]", "", match[0]), text, flags=re.M | re.S)
    found, start, paragraph = [], 0, []
    for number, line in enumerate([*text.splitlines(), ""], start=1):
        if paragraph and (not line.strip() or re.match(r"\s*([*+-]|\d+\.) |#|\|", line)):
            found.append(Text(start, "page", " ".join(paragraph)))
            paragraph = []
        if not paragraph and line.startswith("    "):  # an equation
            continue
        if line.startswith("|"):
            found += [Text(number, "page", part.strip()) for part in re.split(r"[|;]", line) if re.search(r"\w", part)]
        elif line.strip():
            start = start if paragraph else number
            paragraph.append(re.sub(r"^([*+-]|\d+\.|#+) ", "", line.strip()))
    return found


def texts_of(name: str, text: str) -> list[Text]:
    suffix = Path(name).suffix
    if suffix in C_LIKE:
        found = c_texts(text)
        return [one for one in found if one.kind == "comment" or not name.startswith(("tests/", "bench/"))]
    if suffix == ".py":
        return python_texts(text)
    if suffix in HASH or Path(name).name == "CMakeLists.txt":
        return hash_texts(text)
    return page_texts(text) if suffix == ".md" else []


def long_sentences(text: str) -> list[str]:
    plain = re.sub(r"`[^`]*`|\$[^$]*\$", "Code", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text))
    plain = re.sub(r"Code(?:(?:,| and| or|,? to) Code)+", "Code", plain)  # a list of names reads as one
    sentences = re.split(r"(?<=[.!?])[*_)]*\s+(?=[*_(\[]*[A-Z0-9§])", plain)
    return [sentence for sentence in sentences if len(re.findall(r"[\w'’-]*\w", re.sub(r"[\d.,]+", "1", sentence))) > MAX_WORDS]


def findings(name: str, text: str) -> list[str]:
    """Lines to print."""
    found = []
    if SKIPPED.search(name):
        return found
    for one in texts_of(name, text):
        if one.text.startswith("SPDX-"):
            continue
        prose = VERBATIM.sub("`", one.text)
        place = f"{name}:{one.line}"
        if one.kind != "page" and (match := FIRST_WORD.match(prose)) and (one.kind == "comment" or match[0][0].isupper()):
            found.append(f"{place}: first word: '{one.text[:40]}': begin with a noun or a verb")
        found += [f"{place}: personification: '{match[0]}': name the operation (receives, assumes, stores, searches, rejects)"
                  for match in PERSONIFICATION.finditer(prose)]
        found += [f"{place}: term: '{match[0]}': {list(TERMS.values())[match.lastindex - 1]}" for match in TERM.finditer(prose)]
        if one.kind == "message":
            found += [f"{place}: term: '{match[0]}': is not a, must be; restarts" for match in IS_NO.finditer(prose)]
        if one.kind == "page":
            found += [f"{place}: length: '{sentence[:40]}': over {MAX_WORDS} words; divide it" for sentence in long_sentences(one.text)]
    return found


def identifiers(name: str, text: str) -> list[str]:
    """Identifiers of code, each as often as it occurs."""
    if Path(name).suffix == ".py":
        tokens = tokenize.generate_tokens(io.StringIO(text).readline)
        return [token.string for token in tokens if token.type == tokenize.NAME]
    return re.findall(r"[A-Za-z_]\w*", C_TOKEN.sub(" ", text)) if Path(name).suffix in C_LIKE else []


@functools.cache
def patterns_in(identifier: str) -> list[str]:
    """Expressions of IDENTIFIERS that fit a word of FrameIsTold or frame_is_told."""
    words = [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", identifier)]
    return [pattern for pattern in IDENTIFIERS if any(re.fullmatch(pattern, word) for word in words)]


def identifier_violations(places: dict[str, list[str]]) -> list[str]:
    """Findings of words that are in more places than IDENTIFIERS permits. `places`: by expression."""
    return [f"{place}: identifier: {len(found)} places of '{pattern}' (allowed: {IDENTIFIERS[pattern][0]}): {IDENTIFIERS[pattern][1]}"
            for pattern, found in places.items() if len(found) > IDENTIFIERS[pattern][0] for place in sorted(set(found))]


def violations(root: Path, names: list[str]) -> list[str]:
    """Findings of all files."""
    found, places = [], {pattern: [] for pattern in IDENTIFIERS}
    for name in names:
        try:
            text = (root / name).read_text(encoding="utf-8")
            found += findings(name, text)
            for identifier in [] if SKIPPED.search(name) else identifiers(name, text):
                for pattern in patterns_in(identifier):
                    places[pattern].append(f"{name}: {identifier}")
        except (UnicodeDecodeError, SyntaxError, tokenize.TokenError):  # an image; a Python file broken on purpose
            continue
    return found + identifier_violations(places)


def main() -> int:
    import check  # imports this file

    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2]).resolve()
    found = violations(root, check.files_of(root))
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

"""Reads the sentences of comments, help texts and Markdown for check_language.py."""

import ast
import collections
import re
import textwrap

MIN_WORDS = 4

# `follows` is true if the sentence is not the first one of its comment or paragraph.
Sentence = collections.namedtuple("Sentence", "first_line last_line text follows")

PLAIN_WORD = re.compile(r"(?<![\w./\\<:-])[A-Za-z][A-Za-z']*(?![\w/\\(:<]|\.\w|::)(?:(?=-[a-z])|(?!-\S))")
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|et al|vs|cf|Fig|Eqs?|Sec|resp|approx|etc|No|pp|vol|w\.r\.t)\.", re.I)
SENTENCE_END = re.compile(r"(?<=\S[.!?])[\"')\]`*_]*\s+(?=[\"'(\[`*_-]*[A-Z0-9]|`|--|[a-z_]+(?:\(|/|\.[a-z]))")
BULLET = re.compile(
    r"\s*(?:[-*+•]|\d+[.)])\s+|\s*[@\\](?:t?param(?:\[[\w,]+\])?\s+\S+|throws?\s+\w+|file\b.*|class\b.*|\w+)\s*"
)
LICENCE = re.compile(r"copyright|licen[cs]ed?\b|all rights reserved|spdx", re.I)
NOT_PROSE = re.compile(r"\W*(?:namespace|NOLINT\w*|clang-format|noqa|pragma|pylint|#\w+)\b|[^A-Za-z]*$")


def is_prose(text):
    letters = sum(len(word) for word in PLAIN_WORD.findall(text))
    return 2 * letters >= len("".join(text.split()))


def indentation(text):
    return len(text) - len(text.lstrip())


def split_passages(lines):
    """Splits a block, a list of (line, text), at blank lines, list items and lines of code.

    Lines that are indented by two or more blanks are code, except continuations of list items.
    """
    margin = min((indentation(text) for _, text in lines if text.strip()), default=0)
    passage, is_item = [], False
    for line, text in lines:
        bullet = BULLET.match(text)
        stripped = text[bullet.end() :].strip() if bullet else text.strip()
        is_item = bool(bullet or is_item and passage)
        is_code = indentation(text) > margin + 1 and not is_item
        is_code |= stripped[-1:] in ("{", "}", ";") and len(PLAIN_WORD.findall(stripped)) < MIN_WORDS
        is_text = stripped and not is_code and not NOT_PROSE.match(stripped)
        if passage and (bullet or not is_text):
            yield passage
            passage = []
        if not is_text:
            continue
        is_short = len(PLAIN_WORD.findall(stripped)) < MIN_WORDS
        if is_short and re.search(r"[=<>^\[\]|]|\w\(", stripped) and not is_prose(stripped):
            stripped = "`formula`" + "." * stripped.endswith(".")
        passage.append((line, stripped))
    if passage:
        yield passage


def split_sentences(lines):
    """Yields the sentences of a block."""
    for passage in split_passages(lines):
        text = ABBREVIATION.sub(r"\1" + "\0", "\n".join(part for _, part in passage))
        end = 0
        for part in SENTENCE_END.split(text):
            begin = text.index(part, end)
            follows, end = end > 0, begin + len(part)
            first, last = text.count("\n", 0, begin), text.count("\n", 0, end)
            part = part.replace("\0", ".").replace("\n", " ").strip()
            if len(PLAIN_WORD.findall(part)) >= MIN_WORDS and is_prose(part.replace("`formula`", "")):
                yield Sentence(passage[first][0], passage[last][0], part, follows)


class LineNumbers:
    """Line numbers of increasing offsets in a text."""

    def __init__(self, text):
        self.text, self.offset, self.line = text, 0, 1

    def line_of(self, offset):
        self.line += self.text.count("\n", self.offset, offset)
        self.offset = offset
        return self.line


class CommentLines:
    """Joins line comments to blocks.

    A comment continues the comment in the line above, and a trailing comment only in the same column.
    """

    def __init__(self, source):
        self.source, self.numbers, self.blocks = source, LineNumbers(source), []
        self.last_line, self.column, self.is_trailing = -1, -1, False

    def add(self, offset, text):
        line = self.numbers.line_of(offset)
        column = offset - self.source.rfind("\n", 0, offset) - 1
        is_trailing = bool(self.source[offset - column : offset].strip())
        is_next = line == self.last_line + 1 and not is_trailing
        if is_next and (not self.is_trailing or column == self.column):
            self.blocks[-1].append((line, text))
        else:
            self.blocks.append([(line, text)])
            self.column, self.is_trailing = column, is_trailing
        self.last_line = line


CPP_TOKEN = re.compile(
    r"//[^\n]*|/\*.*?\*/|R\"(?P<mark>[^(\s\"]*)\(.*?\)(?P=mark)\"|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])'",
    re.S,
)
HELP_CALL = re.compile(r"\b(?:DEFINE_\w+|Add\w*|def(?:_\w+)?|Help)\(")
HELP_TOKEN = re.compile(CPP_TOKEN.pattern + r"|[(){};]", re.S)


def help_blocks(source):
    """The string literals among the arguments of calls that declare flags and Python bindings."""
    numbers = LineNumbers(source)
    for call in HELP_CALL.finditer(source):
        depth, end, block = 1, -1, []
        for token in HELP_TOKEN.finditer(source, call.end()):
            text = token[0]
            if text in "({":
                depth += 1
            elif text in ")}":
                depth -= 1
            elif text[0] == '"' and depth == 1:
                line = source.count("\n", numbers.offset, token.start()) + numbers.line
                if block and source[end : token.start()].strip():
                    yield block
                    block = []
                block.append((line, text[1:-1].replace("\\n", " ").replace('\\"', '"')))
                end = token.end()
            if depth == 0:
                break
        numbers.line_of(call.end())
        if block:
            yield block


def cpp_blocks(source):
    comments = CommentLines(source)
    for token in CPP_TOKEN.finditer(source):
        text = token[0]
        if text.startswith("//"):
            comments.add(token.start(), text.lstrip("/!").removeprefix("<"))
        elif text.startswith("/*"):
            line = source.count("\n", 0, token.start()) + 1
            rows = re.sub(r"(?m)^\s*[*!]+<?", "", text[2:-2]).split("\n")
            comments.blocks.append(list(enumerate(rows, line)))
    return comments.blocks + list(help_blocks(source))


PYTHON_TOKEN = re.compile(
    r"#[^\n]*|\"\"\".*?\"\"\"|'''.*?'''|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.S
)


def python_blocks(source):
    comments = CommentLines(source)
    for token in PYTHON_TOKEN.finditer(source):
        if token[0][0] == "#":
            comments.add(token.start(), token[0].lstrip("#"))
    blocks = comments.blocks
    for node in ast.walk(ast.parse(source)):
        literal = None
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
            literal = node.body[0].value if node.body and isinstance(node.body[0], ast.Expr) else None
        elif isinstance(node, ast.keyword) and node.arg in ("help", "description", "epilog"):
            literal = node.value
        if isinstance(literal, ast.Constant) and isinstance(literal.value, str):
            first, *others = literal.value.split("\n")
            others = textwrap.dedent("\n".join(others)).split("\n") if others else []
            blocks.append(list(enumerate([first.lstrip(), *others], literal.lineno)))
    return blocks


CMAKE_TOKEN = re.compile(
    r"#[^\n]*|(?:\boption\(\w+\s+|\bCACHE \w+\s+)\"(?P<help>(?:\\.|[^\"\\])*)\"|\"(?:\\.|[^\"\\])*\"|\[\[.*?\]\]",
    re.S,
)


def cmake_blocks(source):
    comments = CommentLines(source)
    for token in CMAKE_TOKEN.finditer(source):
        if token[0][0] == "#":
            comments.add(token.start(), token[0].lstrip("#"))
        elif token["help"]:
            line = source.count("\n", 0, token.start("help")) + 1
            comments.blocks.append(list(enumerate(token["help"].split("\n"), line)))
    return comments.blocks


def shell_blocks(source):
    comments = CommentLines(source)
    for match in re.finditer(r"(?m)^(?P<before>[^\n#]*\s)?(?P<comment>#[^\n]*)", source):
        before = match["before"] or ""
        is_quoted = before.count('"') % 2 or before.count("'") % 2
        if not is_quoted and not match["comment"].startswith("#!"):
            comments.add(match.start("comment"), match["comment"].lstrip("#"))
    return comments.blocks


def markdown_blocks(source):
    """Paragraphs, list items and cells of tables. Headings, code and pictures are skipped."""
    lines, is_fenced, was_blank, was_code = [], False, True, False
    for line, row in enumerate(source.split("\n"), 1):
        is_fence = row.lstrip().startswith(("```", "~~~"))
        is_fenced ^= is_fence
        was_code = row.startswith("    ") and (was_code or was_blank)
        was_blank = not row.strip()
        if is_fence or is_fenced or was_code or was_blank or row.lstrip().startswith(("#", "<", "![")):
            lines.append((line, ""))
            continue
        row = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", row.strip())
        if not row.startswith("|"):
            lines.append((line, row))
            continue
        for cell in re.split(r"(?<!\\)\|", row):
            lines += [(line, cell), (line, "")]
    return [lines]


READERS = {
    **dict.fromkeys((".h", ".cc", ".hpp", ".cpp"), cpp_blocks),
    ".py": python_blocks,
    ".cmake": cmake_blocks,
    ".sh": shell_blocks,
    ".md": markdown_blocks,
}


def reader_of(path):
    return cmake_blocks if path.name == "CMakeLists.txt" else READERS.get(path.suffix)


def read_sentences(path):
    """The sentences of a file, sorted by line."""
    found = []
    blocks = reader_of(path)(path.read_text(encoding="utf-8", errors="replace"))
    for block in blocks:
        if path.suffix == ".md" or not any(LICENCE.search(text) for _, text in block):
            found.extend(split_sentences(block))
    return sorted(found)

#!/usr/bin/env python3
"""Checks comments, help texts and Markdown against the language rule of CONTRIBUTING.md.

    check_language.py PATH...            checks all sentences of files and folders
    check_language.py --changed [BASE]   checks the sentences on lines that differ from BASE

BASE is a commit. Its default is the merge base with the main branch, or the previous commit on the main
branch. Outside of a git repository, `--changed` checks nothing and prints the reason.

Each rule has 1, 2 or 3 marks. A sentence is flagged at 3 marks. Sentences of fewer than four words,
code in backticks, formulas and licences are skipped. The file `language_exceptions.txt` in the folder of
this script lists accepted sentences. An exception without a flagged sentence is an error.

Exit codes: 0 no flagged sentence, 1 flagged sentences or unused exceptions, 2 invalid arguments.
"""

import argparse
import pathlib
import re
import subprocess
import sys

sys.dont_write_bytecode = True  # leaves no files in the source tree
from language_rules import ADVICE, broken_rules, is_flagged
from language_sentences import read_sentences, reader_of

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXCEPTIONS = pathlib.Path(__file__).resolve().with_name("language_exceptions.txt")
GENERATED = {"docs/options.md"}  # contains the help texts of all flags
SKIPPED_FOLDERS = {"build", "node_modules", "third_party"}


def name_of(path):
    """The path relative to the source tree, if it is below."""
    path = path.resolve()
    return path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else path.as_posix()


def files_below(root):
    if root.is_file():
        return [root]

    def is_skipped(path):
        folders = path.relative_to(root).parts[:-1]
        return any(folder in SKIPPED_FOLDERS or folder.startswith(".") for folder in folders)

    paths = sorted(root.rglob("*"))
    return [path for path in paths if reader_of(path) and not is_skipped(path) and path.is_file()]


class Exceptions:
    """Accepted sentences: lines `file | part of the sentence | reason`. `#` begins a comment line."""

    def __init__(self, path):
        self.path, self.entries, self.errors, self.used = path, [], [], set()
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        for number, line in enumerate(lines, 1):
            if not line.strip() or line.startswith("#"):
                continue
            fields = [field.strip() for field in line.split(" | ")]
            if len(fields) != 3 or not all(fields):
                self.errors.append(f"{path.name}:{number}: must be `file | part of the sentence | reason`")
            else:
                self.entries.append((number, fields[0], fields[1]))

    def accepts(self, name, text):
        for number, file, part in self.entries:
            if file == name and part in text:
                self.used.add(number)
                return True
        return False

    def unused(self, names):
        """Errors of exceptions without a flagged sentence, for missing files and files in `names`."""
        for number, file, part in self.entries:
            if number not in self.used and (file in names or not (ROOT / file).is_file()):
                yield f"{self.path.name}:{number}: {file} has no flagged sentence with '{part}'"


class NoHistory(Exception):
    """There is no commit to compare with."""


def git(*arguments):
    result = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=False)
    return result.stdout.strip() if result.returncode == 0 else None


def default_base():
    """The merge base with the main branch, or the previous commit if HEAD is on the main branch."""
    head = git("rev-parse", "HEAD")
    for branch in ("origin/HEAD", "origin/main", "origin/master", "main", "master"):
        base = git("merge-base", "HEAD", branch) if git("rev-parse", "-q", "--verify", branch) else None
        if base and base != head:
            return base
    previous = git("rev-parse", "-q", "--verify", "HEAD^")
    if not previous:
        raise NoHistory("there is no previous commit")
    return previous


def changed_lines(base):
    """The changed and new lines since `base`, as a dictionary from file names to sets of lines.

    None stands for all lines of a file that git does not track.
    """
    try:
        top = git("rev-parse", "--show-toplevel")
    except FileNotFoundError:
        raise NoHistory("git is not installed") from None
    if not top or pathlib.Path(top).resolve() != ROOT:
        raise NoHistory(f"{ROOT} is not the top folder of a git repository")
    base = base or default_base()
    format_options = ["--unified=0", "--no-color", "--no-ext-diff", "--find-renames", "--dst-prefix=b/"]
    diff = git("-c", "core.quotePath=false", "diff", *format_options, base, "--")
    if diff is None:
        print(f"error: git finds no commit {base}", file=sys.stderr)
        sys.exit(2)
    lines, current = {}, set()
    for row in diff.split("\n"):
        if row.startswith("+++ b/"):
            current = lines.setdefault(row[6:].rstrip("\t"), set())
        elif row.startswith("@@"):
            begin, _, count = re.search(r"\+(\d+)(,(\d+))?", row).groups()
            current.update(range(int(begin), int(begin) + int(count or 1)))
    untracked = git("ls-files", "--others", "--exclude-standard") or ""
    lines.update((name, None) for name in untracked.splitlines())
    return lines


def check(path, changed, exceptions):
    """Prints the flagged sentences of a file, and returns their number.

    `changed` is the set of changed lines. None: all lines are checked.
    """
    name, count = name_of(path), 0
    for sentence in read_sentences(path):
        broken = broken_rules(sentence.text, sentence.follows)
        if not is_flagged(broken) or exceptions.accepts(name, sentence.text):
            continue
        if changed is not None and changed.isdisjoint(range(sentence.first_line, sentence.last_line + 1)):
            continue
        count += 1
        print(f"{name}:{sentence.first_line}: {sentence.text}")
        for rule_name in broken:
            print(f"    {rule_name}: {ADVICE[rule_name]}")
    return count


def main(arguments):
    as_written = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=as_written)
    parser.add_argument("paths", nargs="*", metavar="PATH", type=pathlib.Path, help="file or folder")
    parser.add_argument("--changed", nargs="?", const="", metavar="BASE", help="check changed lines")
    options = parser.parse_args(arguments)
    if bool(options.paths) == (options.changed is not None):
        parser.error("give either paths or --changed")

    exceptions = Exceptions(EXCEPTIONS)
    if options.paths:
        missing = [str(path) for path in options.paths if not path.exists()]
        if missing:
            parser.error(f"no such file: {', '.join(missing)}")
        changed = {path: None for root in options.paths for path in files_below(root)}
    else:
        try:
            lines = changed_lines(options.changed)
        except NoHistory as reason:
            print(f"not checked: {reason}")
            return 0
        changed = {ROOT / name: rows for name, rows in lines.items()}
        for file in {file for _, file, _ in exceptions.entries}:
            changed.setdefault(ROOT / file, set())
    files = {
        path: rows
        for path, rows in changed.items()
        if reader_of(path) and path.is_file() and name_of(path) not in GENERATED
    }

    flagged = sum(check(path, rows, exceptions) for path, rows in files.items())
    names = {name_of(path) for path in changed}
    errors = exceptions.errors + list(exceptions.unused(names))
    for error in errors:
        print(f"error: {error}")
    print(f"{len(files)} files, {flagged} flagged sentences")
    return 1 if flagged or errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

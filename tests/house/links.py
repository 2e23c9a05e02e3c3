#!/usr/bin/env python3
"""Whether the pages lead where they say: every relative link and image of a tracked Markdown page to
a tracked file, an anchor to a heading, and every `./ertbench COMMAND` to a command.

  tests/house/links.py            prints what leads nowhere, and fails where there is any
"""
import pathlib
import posixpath
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINK = re.compile(r"\]\(\s*<?([^()\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)|(?:src|href)=\"([^\"]+)\"")
COMMAND = re.compile(r"(?:\./|`)ertbench ([a-z][\w-]*)")
FENCE = re.compile(r"^ *(```|~~~).*?^ *\1[^\n]*$", re.MULTILINE | re.DOTALL)


def anchors(page):
    """The anchors that a forge gives the headings of a page, and those written out."""
    found = set(re.findall(r"<a (?:id|name)=\"([^\"]+)\"", page))
    for heading in re.findall(r"^ {0,3}#{1,6} +(.*?)[ #]*$", FENCE.sub("", page), re.MULTILINE):
        text = re.sub(r"!?\[([^]]*)\]\([^)]*\)", r"\1", heading).lower()
        slug = anchor = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
        repeated = 0
        while anchor in found:
            repeated += 1
            anchor = f"{slug}-{repeated}"
        found.add(anchor)
    return found


def complaints(pages, files, commands):
    """`pages`: texts by path; `files`: all that a link may lead to; all paths from the root."""
    folders = {str(parent) for file in files for parent in pathlib.PurePosixPath(file).parents}
    for page, text in sorted(pages.items()):
        for command in COMMAND.findall(text):
            if command not in commands:
                yield f"{page}: ./ertbench {command}: there is no such command"
        prose = re.sub(r"(`+).*?\1", lambda code: "`" * len(code[0]), FENCE.sub("", text))
        for link in (first or second for first, second in LINK.findall(prose)):
            if re.match(r"[a-z][a-z+.-]*:", link):
                continue
            path, _, anchor = link.partition("#")
            target = posixpath.normpath(posixpath.join(posixpath.dirname(page), path)) if path else page
            if target not in files and target not in folders:
                yield f"{page}: {link}: {target} is not a tracked file"
            elif anchor and target in pages and anchor not in anchors(pages[target]):
                yield f"{page}: {link}: {target} has no such heading"


def self_test():
    """What leads nowhere is told, and nothing else."""
    pages = {"docs/a.md": "# A `b` (c)\n# A b c\n[x](../b.md#two) [y](c.png) [z](#a-b-c-1) `[q](q)`\n"
                          "```sh\n./ertbench run\n[f](f)\n```\n[w](https://w.org) [v](../docs)",
             "b.md": "## One\n![g](docs/c.png \"g\") [h](#two) `ertbench ruin`"}
    assert list(complaints(pages, {"docs/a.md", "b.md"}, {"run"})) == [
        "b.md: ./ertbench ruin: there is no such command",
        "b.md: docs/c.png: docs/c.png is not a tracked file",
        "b.md: #two: b.md has no such heading",
        "docs/a.md: ../b.md#two: b.md has no such heading",
        "docs/a.md: c.png: docs/c.png is not a tracked file"]


def main():
    self_test()
    listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-z"], stdout=subprocess.PIPE)
    if listed.returncode != 0:
        print("not a git checkout: which files are tracked is not known")
        return 77  # skipped
    files = {name for name in listed.stdout.decode().split("\0") if (ROOT / name).is_file()}
    pages = {name: (ROOT / name).read_text() for name in files if name.endswith(".md")}
    table = (ROOT / "bench/cli/command.cpp").read_text()
    commands = set(re.findall(r"^ +\{\"(\w+)\", ", table, re.MULTILINE))
    # Those of the launcher.
    commands |= set(re.findall(r"\$\{1:-\} == (\w+)", (ROOT / "ertbench").read_text()))
    found = list(complaints(pages, files, commands))
    print("\n".join(found) or f"{len(pages)} pages: every link and command resolves")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

"""mdBook preprocessor: converts $...$ and $$...$$ to MathML, so that pages need neither scripts nor the network.

mdBook calls it (`[preprocessor.equations]` in book.toml). It requires the Python package latex2mathml. Code blocks, code
spans and escaped dollars are left alone. `\\tag{4.2}` in a displayed equation sets its number, at the right, and its
anchor `#eq-4.2`.
"""

import json
import os
import re
import sys

# Fenced code, indented code, code spans and escaped dollars come first; then displayed and inline equations.
PARTS = re.compile(
    r"^(?P<fence>`{3,}|~{3,})[^\n]*\n.*?^(?P=fence)[^\n]*$"
    r"|^(?: {4}|\t)[^\n]*$"
    r"|(?P<ticks>`+)(?!`).+?(?<!`)(?P=ticks)(?!`)"
    r"|\\\$"
    r"|\$\$(?P<display>.+?)\$\$"
    r"|(?<![\w$])\$(?P<inline>[^\s$](?:[^$\n]*[^\s$\\])?)\$(?![\w$])",
    re.DOTALL | re.MULTILINE,
)
TAG = re.compile(r"\\tag\{([^}]*)\}")
# Characters of text, not of tags, that Markdown would interpret.
MARKUP = re.compile(r"[*_\[\]`\\|~'\"!-](?=[^<>]*(?:<|$))")
# Browsers show no bold letters by attribute (MathML Core): the letters themselves are bold.
BOLD = re.compile(r'<mi mathvariant="bold-italic">([\u03b1-\u03c9])</mi>')


def converter():
    """Imports latex2mathml, from the Python of REVOLVE_PYTHON if this one lacks it."""
    try:
        import latex2mathml.converter

        return latex2mathml.converter.convert
    except ImportError:
        other = os.environ.get("REVOLVE_PYTHON")
        if other and "REVOLVE_EQUATIONS" not in os.environ:
            os.environ["REVOLVE_EQUATIONS"] = "1"
            os.execvp(other, [other, *sys.argv])
        sys.exit(
            f"error: the Python package `latex2mathml` is not installed for {sys.executable} (docs/equations.py)\n"
            "help: run `python3 -m pip install latex2mathml`, or set REVOLVE_PYTHON to a Python that has it"
        )


def mathml(convert, latex: str, display: str) -> str:
    """Returns an equation as MathML that the Markdown parser does not change."""
    math = convert(latex.strip(), display=display).replace("\n", " ")
    math = BOLD.sub(lambda found: f"<mi>{chr(0x1D736 + ord(found[1]) - 0x3B1)}</mi>", math)
    return MARKUP.sub(lambda found: f"&#{ord(found[0])};", math)


def replacement(convert, found: re.Match) -> str:
    """Returns the replacement of a part of a page."""
    if found["inline"] is not None:
        return mathml(convert, found["inline"], "inline")
    if found["display"] is None:
        return found[0]
    tag = TAG.search(found["display"])
    anchor, number = (f' id="eq-{tag[1]}"', f'<span class="equation-number">({tag[1]})</span>') if tag else ("", "")
    math = mathml(convert, TAG.sub("", found["display"]), "block")
    return f'<div class="equation"{anchor}><div class="equation-body">{math}</div>{number}</div>'


def convert_chapter(convert, item: object) -> None:
    """Converts the equations of a chapter and of its sub-chapters."""
    chapter = item.get("Chapter") if isinstance(item, dict) else None
    if chapter is None:
        return
    try:
        chapter["content"] = PARTS.sub(lambda found: replacement(convert, found), chapter["content"])
    except Exception as error:
        sys.exit(f"error: {chapter.get('path')}: invalid equation: {error!r} (docs/equations.py)")
    for sub in chapter["sub_items"]:
        convert_chapter(convert, sub)


def main() -> None:
    # A failure here would make mdBook skip the equations instead of stopping.
    if sys.argv[1:2] == ["supports"]:
        sys.exit(0 if sys.argv[2:] == ["html"] else 1)
    convert = converter()
    sys.stdin.reconfigure(encoding="utf-8")
    sys.stdout.reconfigure(encoding="utf-8")
    _, book = json.load(sys.stdin)
    for item in book.get("items", book.get("sections", [])):
        convert_chapter(convert, item)
    json.dump(book, sys.stdout)


if __name__ == "__main__":
    main()

"""mdBook preprocessor: converts $...$ and $$...$$ to MathML, so that pages need neither scripts nor the network.

mdBook calls it ([preprocessor.equations] in book.toml). It requires the Python package latex2mathml. Code blocks, code
spans and escaped dollars are left alone. `\\tag{4.2}` in a displayed equation sets its number, at the right, and its
anchor `#eq-4.2`. A line `Function: ...` after it names the functions that evaluate it. Links to source files, which are
not part of the book, become their paths.
"""

import json
import os
import re
import sys

# Fenced code, indented code, code spans and escaped dollars come first; then links to files of the repository, which is
# not part of the book; then displayed and inline equations.
PARTS = re.compile(
    r"^(?P<fence>`{3,}|~{3,})[^\n]*\n.*?^(?P=fence)[^\n]*$"
    r"|^(?: {4}|\t)[^\n]*$"
    r"|(?P<ticks>`+)(?!`).+?(?<!`)(?P=ticks)(?!`)"
    r"|\\\$"
    r"|^(?P<indent> *)(?P<functions>Functions?: \[[^\n]*)$"
    r"|\[[^\[\]\n]*\]\((?:\.\./)+(?P<file>(?:src|tests|input|examples)/[^)\s]*)\)"
    r"|\$\$(?P<display>.+?)\$\$"
    r"|(?<![\w$])\$(?P<inline>[^\s$](?:[^$\n]*[^\s$\\])?)\$(?![\w$])",
    re.DOTALL | re.MULTILINE,
)
# A function that evaluates an equation, with its file.
FUNCTION_LINK = re.compile(r"\[`([^`]*)`\]\((?:\.\./)+([^)\s]*)\)")
TAG = re.compile(r"\\tag\{([^}]*)\}")
# Characters of text, not of tags, that Markdown would interpret.
MARKUP = re.compile(r"[*_\[\]`\\|~'\"!-](?=[^<>]*(?:<|$))")
# Browsers do not set bold letters by the attribute (MathML Core), so bold characters take their place.
BOLD = re.compile(r'<mi mathvariant="bold(?:-italic)?">([A-Za-z\u03b1-\u03c9])</mi>')
# Spacing that TeX has and latex2mathml leaves to the browser: bars and slashes, and function names.
CLOSE = re.compile(r"<mo>([|/])</mo>")
FUNCTION = re.compile(r"(?<!<msup>)(?<!<msub>)<mi>(sin|cos|tan|ln|det|arctan)</mi>")
ENTITY = re.compile(r"&#x([0-9A-Fa-f]+);")


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


def bold(letter: str) -> str:
    """Returns the bold character of a Latin or Greek letter."""
    first, base = ("\u03b1", 0x1D736) if letter >= "\u03b1" else ("A", 0x1D400) if letter < "a" else ("a", 0x1D41A)
    return chr(base + ord(letter) - ord(first))


def mathml(convert, latex: str, display: str) -> str:
    """Returns an equation as MathML that the Markdown parser does not change."""
    try:
        math = convert(latex.strip(), display=display).replace("\n", " ")
    except Exception as error:  # The errors of latex2mathml have no common type.
        raise ValueError(f"invalid equation `{latex.strip()}`: {type(error).__name__}") from error
    math = ENTITY.sub(lambda found: found[0] if (c := chr(int(found[1], 16))) in "<>&" else c, math)
    math = BOLD.sub(lambda found: f"<mi>{bold(found[1])}</mi>", math)
    math = CLOSE.sub(r'<mo stretchy="false" lspace="0" rspace="0">\1</mo>', math)
    math = FUNCTION.sub(r'<mi>\1</mi><mspace width="0.16em"/>', math)
    return MARKUP.sub(lambda found: f"&#{ord(found[0])};", math)


def replacement(convert, found: re.Match) -> str:
    """Returns the replacement of a part of a page."""
    if found["file"] is not None:
        return f"`{found['file']}`"
    if found["functions"] is not None:
        functions = FUNCTION_LINK.sub(r"<code>\1</code> (<code>\2</code>)", found["functions"])
        return f'{found["indent"]}<p class="equation-functions">{functions}</p>'
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
    except ValueError as error:
        sys.exit(f"error: {chapter.get('path')}: {error} (docs/equations.py)")
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

"""Pages that are files elsewhere in the repository, marked by comments that a build replaces.

`<!-- page: ../CHANGELOG.md -->` becomes that file, its links as seen from the site.
`<!-- page: ../README.md from ## B before ## C -->` becomes a part of one, and
`<!-- history: ../bench/history -->` a table of the files of releases in that folder.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

MARK = re.compile(r"<!-- page: (\S+)(?: from (#+ .+?))?(?: before (#+ .+?))? -->")
HISTORY = re.compile(r"<!-- history: (\S+) -->")
PICTURE = re.compile(r'<picture>\s*(?:<source[^>]*>\s*)+<img alt="([^"]*)" src="([^"]*)"[^>]*>\s*</picture>')
LINK = re.compile(r"(!?\[[^\]]*\]\()([^)#\s]+)(#[^)\s]*)?\)")


def relinked(text: str, source: Path, page: Path, pages: dict[Path, Path]) -> str:
    """Return the Markdown text of a file as part of a page: relative links lead where they did, or to the page that has
    the file. A picture with a version for dark pages becomes its first version, which the site inverts itself.
    """

    def link(found: re.Match[str]) -> str:
        target = found[2]
        if "://" in target or target.startswith("mailto:"):
            return found[0]
        path = (source.parent / target).resolve()
        path = pages.get(path, path)
        return f"{found[1]}{Path(os.path.relpath(path, page.parent)).as_posix()}{found[3] or ''})"

    return LINK.sub(link, PICTURE.sub(r"![\1](\2)", text))


def part(text: str, begin: str | None, end: str | None) -> str:
    """Return the text from one heading on, or from its beginning, to before another one, or to its end."""
    lines = text.splitlines(keepends=True)
    headings = [line.rstrip() for line in lines]
    for heading in (begin, end):
        if heading is not None and heading not in headings:
            raise ValueError(f"there is no heading {heading!r}")
    first = 0 if begin is None else headings.index(begin)
    last = len(lines) if end is None else headings.index(end)
    return "".join(lines[first:last])


def history(files: list[Path]) -> str:
    """Return the Markdown table of the ratios that releases wrote, the newest first, and on what."""
    records = {path.stem: json.loads(path.read_text()) for path in files}
    versions = sorted(records, key=lambda name: [int(part) for part in re.findall(r"\d+", name)], reverse=True)
    lines = [["", *versions], ["---"] * (1 + len(versions))]
    for what in dict.fromkeys(what for name in versions for what in records[name]["ratios"]):
        lines.append([what, *(str(records[name]["ratios"].get(what, "")) for name in versions)])
    machines = [(name, records[name]["machine"]) for name in versions]
    made_on = [
        f"- {name}: {on['cpu']}, {on['cores']} cores; commit {on['commit']}, {on['date']}" for name, on in machines
    ]
    return "\n".join([*(f"| {' | '.join(line)} |" for line in lines), "", *made_on])


def include(app: Any, docname: str, content: list[str]) -> None:
    """Replace the marks of a page by the files they name."""
    folder = Path(app.srcdir)
    page = folder / f"{docname}.md"
    if page.exists():
        pages = {(folder / name).resolve(): folder / there for name, there in app.config.pages_of_files.items()}

        def text(found: re.Match[str]) -> str:
            source = (page.parent / found[1]).resolve()
            app.env.note_dependency(str(source))
            chosen = part(source.read_text(), found[2], found[3])
            return relinked(chosen, source, page.resolve(), pages)

        def table(found: re.Match[str]) -> str:
            files = sorted((page.parent / found[1]).glob("*.json"))
            for path in files:
                app.env.note_dependency(str(path.resolve()))
            return history(files)

        content[0] = HISTORY.sub(table, MARK.sub(text, content[0]))


def setup(app: Any) -> dict[str, Any]:
    """Connect to Sphinx."""
    app.add_config_value("pages_of_files", {}, "env")
    app.connect("source-read", include)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

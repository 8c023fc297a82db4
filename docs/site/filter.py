#!/usr/bin/env python3
"""Prints one of softcd's files for Doxygen: filter.py FILE, in the repository's root.

- Headers: without the inline namespaces of versions and precisions, as programs do not write their names. Also without
  move constructors and move assignments, which need no description.
- Pages: with links that work in the site. Pages and their sections are linked by names. docs/site.sh copies all other
  files of the repository below files/.
"""

import os
import re
import sys

PAGES = {"README.md": "index", "CHANGELOG.md": "changes", "CONTRIBUTING.md": "contributing",
         "CODE_OF_CONDUCT.md": "conduct", "SECURITY.md": "security"}


def page_name(path):
    """Returns the name of a page, or None for any other file."""
    if path.endswith(".md") and path.startswith("docs/"):
        return "page_" + re.sub(r"[-/]", "_", path[len("docs/"):-len(".md")])
    return PAGES.get(path)


def section_name(page, heading):
    """Returns the name of a section, from the words of its heading as in the anchors of GitHub."""
    words = re.sub(r"[^\w\- ]", "", heading.replace("`", "").lower())
    return f"{page}_{words}".replace(" ", "-").replace("-", "_")


def without_inline_namespaces(text):
    open_count = 0
    lines = []
    for line in text.split("\n"):
        if re.match(r"inline namespace \w+ \{$", line):
            open_count += 1
            line = ""
        elif open_count > 0 and re.match(r"}  // namespace( SOFTCD_VERSION_NAMESPACE)?$", line):
            line = ""
        elif re.search(r"^  (\w+\(\w+&&\)|\w+& operator=\(\w+&&\)) noexcept;$", line):
            line = ""
        lines.append(line)
    return "\n".join(lines)


def link(path, match):
    is_picture, text, target = match.groups()
    if re.match(r"[a-z]+:", target):
        return match.group(0)
    file, _, section = target.partition("#")
    place = os.path.normpath(os.path.join(os.path.dirname(path), file)) if file else path
    page = page_name(place)
    if is_picture:
        return f'<img src="files/{place}" alt="{text}"/>'
    if page is None:
        return f'<a href="files/{place}">{text}</a>'
    text = text.replace("`", "")
    return f'@ref {section_name(page, section) if section else page} "{text}"'


def page(path, text):
    name = page_name(path)
    sections = {}
    lines = []
    in_code = False
    for line in text.split("\n"):
        if line.startswith("```"):
            in_code = not in_code
        elif not in_code and not line.startswith("    "):
            heading = re.match(r"(#+) (.*)", line)
            if heading:
                marks, words = heading.groups()
                label = section_name(name, words) if marks != "#" else "mainpage" if name == "index" else name
                sections[label] = sections.get(label, 0) + 1
                line = f"{line} {{#{label if sections[label] == 1 else f'{label}_{sections[label] - 1}'}}}"
            line = re.sub(r"(!?)\[([^\]]*)\]\(([^)]*)\)", lambda match: link(path, match), line)
        lines.append(line)
    return "\n".join(lines)


def main():
    path = os.path.relpath(sys.argv[1])
    with open(path, encoding="utf-8") as file:
        text = file.read()
    text = page(path, text) if path.endswith(".md") else without_inline_namespaces(text)
    # The first comment of these headers describes the whole file.
    if os.path.basename(path) in ("softcd.h", "softcd.hpp", "softcd_probe.h"):
        text = text.replace("\n\n/**\n", "\n\n/** @file\n", 1).replace("\n\n///", "\n/// @file\n///", 1)
    sys.stdout.write(text)


main()

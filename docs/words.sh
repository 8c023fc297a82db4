#!/usr/bin/env bash
# Reports text that is hard to read.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: docs/words.sh [--all] [FILE...]

Reports, over the documents, headers and sources (or FILEs):
- doc comments that begin with Of, Where, As, Those, And or Who: they have no subject;
- sentences of more than 40 words;
- words with a special meaning in this project that docs/use/glossary.md does not explain, with the number of lines that
  have them.
Prints the first five of each kind and their number, or all with --all. The exit code is always 0.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

exec python3 - "$@" <<'PYTHON'
import pathlib
import re
import subprocess
import sys

# Words that this project uses with a special meaning, or instead of a standard term, and patterns that find them.
OWN_WORDS = {
    "answer (to contacts)": r"\banswer(s|ed|ing)?\b", "foresee, foresight": r"\bfores(ee\w*|ight)\b",
    "hold back": r"\bh[eo]ld\w* back\b",
    "lane": r"\blanes?\b", "let go": r"\blets? go\b", "look (noun)": r"\b(a|the|one|each|last|this|that) looks?\b",
    "rehearsal": r"\brehears\w*\b", "room (memory)": r"\broom for\b", "set apart": r"\bs[ei]ts? apart\b", "settle": r"\bsettl\w*\b",
    "snapshot": r"\bsnapshots?\b", "somebody else": r"\bsomebody else\b", "stand-in": r"\bstand-ins?\b",
    "stray": r"\bstrays?\b", "survey": r"\bsurveys?\b", "tangle": r"\btangl\w*\b", "way (motion)": r"\b(on|along) (its|their|the) way\b",
}  # fmt: skip

show_all = "--all" in sys.argv
files = [f for f in sys.argv[1:] if f != "--all"]
if not files:
    patterns = ["*.md", "*.hpp", "*.h", "*.cpp", "*.cu", "*.cuh"]
    files = subprocess.run(["git", "ls-files", *patterns], capture_output=True, text=True, check=True).stdout.split()


def paragraphs(path, lines):
    """(number of the first line, text) of each comment, or each paragraph of a document."""
    is_document, in_code, begin, text = path.endswith(".md"), False, 0, []
    for number, line in enumerate([*lines, ""], 1):
        if is_document:
            in_code ^= line.lstrip().startswith("```")
            is_left_out = in_code or line[:4] == "    " or line.startswith(("```", "#", "|"))
            part = "" if is_left_out else re.sub(r"^\s*([-*>]|\d+\.) ", "\n", line)
        else:
            found = re.match(r"\s*///? ?(?!<|/)(.*)|.*?///<( .*)", line)
            part = re.sub(r"^([-*]|\d+\.) ", "\n", (found[1] if found else None) or "")
            if found and found[2]:
                yield number, found[2]  # behind a member: a comment of its own
            if part.startswith("    "):
                part = ""  # an example
        if part.strip() and not part.startswith("\n"):
            begin, text = begin or number, [*text, part]
            continue
        if text:
            yield begin, " ".join(text)
        begin, text = (number, [part.strip()]) if part.strip() else (0, [])


def report(title, found):
    print(f"{title}: {len(found)}")
    for line in found if show_all else found[:5]:
        print("  " + line)


openings, long_sentences, uses = [], [], dict.fromkeys(OWN_WORDS, 0)
glossary = pathlib.Path("docs/use/glossary.md").read_text()
terms = " ".join(re.findall(r"^\| (.*?) \|", glossary, re.MULTILINE)).lower()
for path in files:
    lines = pathlib.Path(path).read_text(errors="replace").splitlines()
    for number, line in enumerate(lines, 1):
        is_within = number > 1 and re.match(r"\s*/// .*[^.:]$", lines[number - 2])
        if not is_within and re.search(r"///<? (Of|Where|As|Those|And|Who)\b", line):
            openings.append(f"{path}:{number}: {line.strip()[:100]}")
        for word, pattern in OWN_WORDS.items():
            uses[word] += bool(re.search(pattern, line, re.IGNORECASE))
    for number, text in paragraphs(path, lines):
        for sentence in re.split(r"(?<=[.!?:]) +(?=[A-Z`\[(])", text):
            words = len(sentence.split())
            if words > 40:
                long_sentences.append((words, f"{path}:{number}: {words} words: {sentence[:100]}..."))

report("Doc comments without a subject", openings)
report("Sentences of more than 40 words", [text for _, text in sorted(long_sentences, reverse=True)])
missing = {word: count for word, count in uses.items() if count and re.split(r",| \(", word)[0] not in terms}
most_first = sorted(missing.items(), key=lambda item: -item[1])
report("Own words that the glossary lacks", [f"{word}: {count} lines" for word, count in most_first])
PYTHON

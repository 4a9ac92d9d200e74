# Judges what fuzz.py found: `report.py OUTPUT CASES [--write PAGE | --check PAGE]`. Fails unless CASES cases ran, each
# as it must.
import collections
import json
import pathlib
import sys

from autobahntestsuite.case import CaseCategories

# Strictness is the suite's own: these pass, by its own report. Every other verdict is a failure here, those on the way
# that a connection ends ("UNCLEAN", "WRONG CODE", "FAILED BY CLIENT") included.
PASS = ["OK", "NON-STRICT", "INFORMATIONAL"]
BEGIN, END = "<!-- the table of just autobahn -->\n", "<!-- its end -->\n"


def key(case):
    return [int(part) for part in case.split(".")]


def table(verdicts):
    """Cases by section and verdict; the worse of how a case went and how it ended."""
    sections = collections.defaultdict(collections.Counter)
    for case, verdict in verdicts.items():
        sections[key(case)[0]][verdict] += 1
    rows = [["section", "", "cases", "OK", "non-strict", "informational", "failed"]]
    rows.append(["---"] * 2 + ["---:"] * 5)
    total = collections.Counter()
    for section, counts in sorted(sections.items()):
        total += counts
        rows.append([str(section), CaseCategories[str(section)], *numbers(counts)])
    rows.append(["", "all", *numbers(total)])
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def numbers(counts):
    passed = [counts[verdict] for verdict in PASS]
    return [str(n) for n in [counts.total(), *passed, counts.total() - sum(passed)]]


def main(output, expected, mode=None, page=None):
    output = pathlib.Path(output)
    found = json.loads((output / "index.json").read_text())["swellcast"]
    verdicts, failed = {}, []
    for case, result in found.items():
        went, ended = result["behavior"], result["behaviorClose"]
        verdicts[case] = max(went, ended, key=lambda verdict: PASS.index(verdict) if verdict in PASS else len(PASS))
        if verdicts[case] not in PASS:
            failed.append(case)
    text = table(verdicts)
    print(text, end="")
    for case in sorted(failed, key=key):
        detail = json.loads((output / found[case]["reportfile"]).read_text())
        print(f"\n{case}: {detail['behavior']}, {detail['behaviorClose']}: {detail['result']} {detail['resultClose']}")
        print(f"    sent: {detail['description']}\n    wanted: {detail['expectation']}")
        print(f"    expected {detail['expected']}, {detail['expectedClose']}\n    received {detail['received']}")
    print(f"{len(found) - len(failed)} passed, {len(failed)} failed")
    if len(found) != expected:
        sys.exit(f"{len(found)} cases ran, not {expected}")
    if failed:
        sys.exit(1)
    if page:
        page = pathlib.Path(page)
        before, rest = page.read_text().split(BEGIN)
        new = before + BEGIN + text + END + rest.split(END)[1]
        if mode == "--write":
            page.write_text(new)
        elif page.read_text() != new:
            sys.exit(f"{page} says otherwise; `just autobahn --write` writes it anew")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), *sys.argv[3:])

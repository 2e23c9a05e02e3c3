#!/usr/bin/env python3
"""Whether two runs left the same: every file byte by byte, but for what no two runs share, the times
that they took and when. Used by tests/failures and tests/kills.

  tests/same_results.py BEFORE AFTER      are the numbers of every summary.json below BEFORE, times
                                          included, those below AFTER? Lists may have been removed
"""
import csv
import io
import json
import pathlib
import re
import sys

# In JSON, wherever they stand; a checksum is also that of the times.
TIMES = {"fit_s", "date", "measured", "rendered", "busy_cores", "earlier_s", "peak_rss_mb", "latency_us", "frames_per_s",
         "calibration_us", "seconds", "checksum", "file_checksum"}
TIMES_IN_TEXT = re.compile("\"(?:" + "|".join(sorted(TIMES)) + ")\":[-+.0-9e]+")
# What is left behind by design, and says how a process fared.
NOT_RESULTS = (".log",)


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(inner) for key, inner in value.items() if key not in TIMES}
    if isinstance(value, list):
        return [without_times(inner) for inner in value]
    return value


def without_fit_times(text, divider):
    """A table without the column of what the fits took. A row is a line; `divider`, a regular
    expression, stands between its cells."""
    lines = text.split("\n")
    place = count = 0
    for number, line in enumerate(lines):
        cells = re.split(divider, line)
        titles = [i for i, cell in enumerate(cells) if "fit (s)" in cell]
        if titles and len(cells) > 3:
            place, count = titles[0], len(cells)
        elif count and len(cells) == count:
            cells[place] = "TIME"
            lines[number] = "\n".join(cells)
    return "\n".join(lines)


def comparable(file):
    """The contents of a file, without its times."""
    content = file.read_bytes()
    if file.suffix == ".json":
        return json.dumps(without_times(json.loads(content)), sort_keys=True).encode()
    if file.suffix == ".csv":
        rows = list(csv.reader(io.StringIO(content.decode())))
        kept = [i for i, name in enumerate(rows[0]) if name not in TIMES] if rows else []
        return json.dumps([[TIMES_IN_TEXT.sub("", row[i]) for i in kept] for row in rows]).encode()
    dividers = {".md": r" \| ", ".tex": " & ", ".html": "</t[hd]>"}
    if file.suffix in dividers:
        text = without_fit_times(content.decode(), dividers[file.suffix])
        text = re.sub(r"\d{4}-\d\d-\d\dT[\d:]+Z", "DATE", text)
        return re.sub(r"[ -]+", " ", text).encode()  # columns are padded to what is in them
    if file.suffix == ".fitted" and b'"seconds":' in content:
        return b"a trained solver, whose file has its times: the records tell whether it is the same"
    return content


def files_of(folder):
    # A probe that could not be kept is computed again, so its file is no result.
    return {str(file.relative_to(folder)): file for file in sorted(folder.rglob("*"))
            if file.is_file() and file.suffix not in NOT_RESULTS and "probes" not in file.parts}


def differences(expected, found):
    """What is not the same in two folders, a line for each file."""
    lines = []
    files, others = files_of(expected), files_of(found)
    for name in sorted(files.keys() | others.keys()):
        if name not in others:
            lines.append(f"{name} is missing")
        elif name not in files:
            lines.append(f"{name} is left over")
        elif comparable(files[name]) != comparable(others[name]):
            lines.append(f"{name} differs")
    return lines


# What metrics were called before, by what they are called now.
RENAMED = {"found": "detected", "ghosts": "false_positives"}


def changes(before, after, place, compared):
    """The places of values that are not the same in two summaries. What is lost counts too, but for
    lists, words and what a training ran on, which publishing may leave out. Adds the number of values to `compared`."""
    if isinstance(before, dict) and isinstance(after, dict):
        renamed = {RENAMED.get(key, key): value for key, value in after.items()}
        for key, value in before.items():
            key = RENAMED.get(key, key)
            if key in renamed:
                yield from changes(value, renamed[key], f"{place}/{key}", compared)
            elif key != "runtime" and not isinstance(value, (list, str)):
                yield f"{place}/{key} is lost"
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for number, (old, new) in enumerate(zip(before, after)):
            yield from changes(old, new, f"{place}/{number}", compared)
    else:
        compared.append(place)
        if before != after:
            yield f"{place} differs"


def changed_summaries(before, after):
    """Compares every summary.json below `before` with that at the same place below `after`: what was
    measured and what studies and charts say of it. Returns lines, the last with how much it was."""
    lines, compared = [], []
    files = sorted(pathlib.Path(before).rglob("summary.json"))
    for file in files:
        name = file.relative_to(before)
        if not (pathlib.Path(after) / name).exists():
            lines.append(f"{name} is missing")
            continue
        parts = []
        for content in (file, pathlib.Path(after) / name):
            summary = json.loads(content.read_bytes())
            parts.append({key: summary.get(key, {}) for key in ("studies", "speed_accuracy")})
            parts[-1]["rows"] = {f"{row['dataset']}, {row['label']}": row for row in summary["rows"]}
        lines += [f"{name}: {one}" for one in changes(*parts, "", compared)]
    return lines + [f"{len(files)} summaries, {len(compared)} values, {len(lines)} changed or lost"]


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    found = changed_summaries(*sys.argv[1:])
    print("\n".join(found))
    sys.exit(1 if len(found) > 1 or found[0].startswith("0 ") else 0)

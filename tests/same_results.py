"""Whether two runs left the same: every file byte by byte, but for what no two runs share, the times
that they took and when. Used by tests/failures and tests/kills."""
import csv
import io
import json
import re

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

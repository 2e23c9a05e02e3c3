"""The static site that results/site/make writes: complete, without a network, and readable on small screens."""

import html.parser
import json
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.parse

import pytest

PROJECT = pathlib.Path(__file__).parents[2]
CHROMIUM = pathlib.Path("/usr/bin/chromium")
SUMMARY = PROJECT / "results/published/speed_accuracy/summary.json"


def make(out):
    return subprocess.run([sys.executable, PROJECT / "results/site/make", "--out", out], capture_output=True, text=True)


class Links(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.links, self.loaded, self.anchors, self.text = [], [], set(), ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.anchors.add(given.get("id"))
        if tag == "a":
            self.links.append(given["href"])
        elif "src" in given or tag == "link":
            self.loaded.append(given.get("src") or given["href"])

    def handle_data(self, data):
        self.text += data


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    out = tmp_path_factory.mktemp("site")
    done = make(out)
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture(scope="module")
def pages(site):
    return {page: Links(page.read_text("utf-8")) for page in site.rglob("*.html")}


def test_every_link_and_anchor_leads_somewhere(site, pages):
    for page, read in pages.items():
        for link in read.links:
            address = urllib.parse.urlsplit(link)
            if address.scheme:
                assert address.scheme in ("http", "https"), f"{page}: {link}"
                continue
            target = (page.parent / address.path).resolve() if address.path else page
            assert target.is_file(), f"{page.relative_to(site)}: {link}"
            if address.fragment:
                assert urllib.parse.unquote(address.fragment) in pages[target].anchors, f"{page.relative_to(site)}: {link}"


def test_what_is_loaded_is_there_and_nothing_comes_from_elsewhere(site, pages):
    for page, read in pages.items():
        assert read.loaded
        for source in read.loaded:
            assert (page.parent / source).is_file(), f"{page.relative_to(site)}: {source}"
    for text in ((site / "site.css").read_text(), (site / "chart.js").read_text()):
        assert not re.search(r"https?:|url\(|@import|fetch\(|import\(", text)


def test_every_page_is_there_with_its_words(site, pages):
    for source in [PROJECT / "README.md", *(PROJECT / "docs").glob("*.md"), *SUMMARY.parents[1].glob("**/README.md")]:
        read = pages[site / source.relative_to(PROJECT).with_suffix(".html")]
        told = re.sub(r"<!--.*?-->", "", source.read_text("utf-8"), flags=re.DOTALL)
        # Words of letters, outside the targets of links.
        words = re.findall(r"[^\W\d_]{4,}", re.sub(r"!\[[^]]*\]\([^)]*\)|(?<=\])\([^)]*\)", "", told))
        assert len(words) > 50
        assert [word for word in words if word not in read.text and word not in ("json", "cmake", "python", "octave")] == []
        code = re.search(r"^```\w*\n(.*?)^```", told, re.DOTALL | re.MULTILINE)
        assert not code or code[1] in read.text


def test_markdown_becomes_what_it_says(tmp_path):
    for name in ("results/site", "docs", "results/published/speed_accuracy"):
        (tmp_path / name).mkdir(parents=True)
    for name in ("make", "site.css", "chart.js"):
        shutil.copy(PROJECT / "results/site" / name, tmp_path / "results/site")
    shutil.copy(SUMMARY, tmp_path / "results/published/speed_accuracy")
    (tmp_path / "README.md").write_text(
        "# A `b` [c](docs/x.md#one)\n## One\n## One\n<!-- gone -->\nx *y* **z** `*<q>*` \\| 2 * 3 * 4\n\n"
        "| p | q |\n|---|---:|\n| `a|` b | 1 |\n".replace("a|", "a\\|") +
        "\n1. first\n   second\n\n   | u |\n   |---|\n   | v |\n\n2. `third`\n\nend\n- dot\n\n```sh\n# <no heading>\n```\n")
    (tmp_path / "docs/x.md").write_text("# X\n## One\n[up](../README.md) [dir](../results)")
    run = [sys.executable, tmp_path / "results/site/make", "--out", tmp_path / "out"]
    assert subprocess.run(run).returncode == 0
    body = re.sub(r"\n", "", (tmp_path / "out/README.html").read_text("utf-8"))
    for part in ['<h1 id="a-b-c">A <code>b</code> <a href="docs/x.html#one">c</a></h1>', '<h2 id="one">', '<h2 id="one-1">',
                 "x <em>y</em> <strong>z</strong> <code>*&lt;q&gt;*</code> | 2 * 3 * 4", "<td><code>a|</code> b</td><td class=number>1</td>",
                 "<ol><li>firstsecond<div class=wide><table>", "<li><code>third</code></ol><p>end</p><ul><li>dot</ul>",
                 "<pre><code># &lt;no heading&gt;</code></pre>"]:
        assert part in body, part
    assert "gone" not in body
    assert (tmp_path / "out/results/index.html").is_file()
    assert subprocess.run(run).returncode == 0  # over its own site
    (tmp_path / "docs/x.md").write_text("[lost](y.md)")
    done = subprocess.run(run, capture_output=True, text=True)
    assert done.returncode == 1 and "docs/x.md: y.md: there is no docs/y.md" in done.stderr


def test_a_folder_of_others_is_left_alone(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    done = make(tmp_path)
    assert done.returncode == 1 and "not empty" in done.stderr
    assert [one.name for one in tmp_path.iterdir()] == ["mine.txt"]


# Opens pages in frames as wide as the screens and reports what they show.
PROBE = """<!DOCTYPE html><meta charset="utf-8"><pre id=report></pre><script>
const report = [], asked = PAGES;
const next = () => {
  if (!asked.length) { document.getElementById("report").textContent = "REPORT" + JSON.stringify(report) + "END"; return; }
  const [page, width] = asked.shift(), frame = document.createElement("iframe");
  frame.style = `width:${width}px;height:900px;border:0`;
  frame.onload = () => {
    const inside = frame.contentDocument, all = [...inside.querySelectorAll("body *")], circles = [...inside.querySelectorAll("circle")];
    const found = {page, width, wide: inside.documentElement.scrollWidth, points: circles.length, rows: inside.querySelectorAll("#rows tbody tr").length,
      least: Math.min(...all.filter(one => one.innerText || one.tagName == "text").map(one => parseFloat(frame.contentWindow.getComputedStyle(one).fontSize))),
      outside: circles.filter(one => one.getBoundingClientRect().right > width || one.getBoundingClientRect().left < 0).length};
    if (circles.length) {
      const first = inside.querySelector("#rows tbody tr").innerText;
      circles[0].dispatchEvent(new FocusEvent("focusin", {bubbles: true}));
      found.frontier = inside.querySelector(".frontier").getAttribute("d").split("H").length - 1;
      found.detail = inside.getElementById("detail").innerText;
      const click = selector => inside.querySelector(selector).click();
      click("[data-sort=error]");
      const errors = [...inside.querySelectorAll("#rows tbody tr")].map(one => parseFloat(one.children[1].innerText));
      found.sorted = errors.every((error, i) => !i || errors[i - 1] <= error);
      click("[value=tsvd]");
      found.without = [...inside.querySelectorAll("#rows tbody tr")].map(one => one.innerText);
      found.scores = [...inside.querySelectorAll("#metric option")].map(option => {
        inside.getElementById("metric").value = option.value;
        inside.getElementById("metric").dispatchEvent(new Event("change", {bubbles: true}));
        return [option.value, inside.querySelectorAll("circle").length, inside.getElementById("plot").innerHTML.includes("NaN")];
      });
    }
    report.push(found);
    frame.remove();
    next();
  };
  frame.src = page;
  document.body.append(frame);
};
next();
</script>"""


@pytest.mark.skipif(not CHROMIUM.exists(), reason="chromium is not installed")
def test_pages_fit_their_screens_and_the_chart_works(site, pages, tmp_path):
    asked = [[page.relative_to(site).as_posix(), width] for page in sorted(pages) for width in (1280, 400)]
    (site / "probe.html").write_text(PROBE.replace("PAGES", json.dumps(asked)))
    shown = subprocess.run(
        ["timeout", "300", CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync",
         "--disable-background-networking", "--disable-component-update", "--disable-dev-shm-usage", "--dump-dom",
         "--allow-file-access-from-files", "--virtual-time-budget=200000", "--window-size=1300,1000",
         f"--user-data-dir={tmp_path}/profile", f"file://{site}/probe.html"], capture_output=True, text=True)
    (site / "probe.html").unlink()
    found = re.search(r"REPORT(.*?)END", shown.stdout, re.DOTALL)
    assert found, shown.stderr[-2000:]
    report = json.loads(html.unescape(found[1]))
    assert len(report) == len(asked)
    for one in report:
        assert one["wide"] <= one["width"], one
        assert one["least"] >= 12, one
    timed = [row for row in json.loads(SUMMARY.read_text())["rows"] if row["latency_us"]]
    fast = sorted(timed, key=lambda row: row["latency_us"]["p50"])
    error = [row["metrics"]["relative_error"]["mean"] if row["frames_not_converged"] <= 10 else float("inf") for row in fast]
    frontier = [i for i in range(len(fast)) if error[i] < min(error[:i], default=float("inf"))]
    for one in (one for one in report if one["page"] == "index.html"):
        assert one["points"] == one["rows"] == len(timed) and one["outside"] == 0
        assert re.match(rf"{re.escape(fast[0]['label'])}: relative error of δσ {fast[0]['metrics']['relative_error']['mean']:.3f} \(", one["detail"])
        assert f'./ertbench run experiments/speed_accuracy.json --only "{fast[0]["label"]}"' in one["detail"]
        assert one["frontier"] == len(frontier)
        assert one["sorted"]
        assert one["without"] and not any("tsvd" in row for row in one["without"])
        assert all(points > 40 and not broken for _, points, broken in one["scores"]) and len(one["scores"]) == 6

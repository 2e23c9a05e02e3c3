// The speed-accuracy chart of index.html and the table below it, from the JSON that stands in the page.
"use strict";
const data = JSON.parse(document.getElementById("data").textContent), place = document.getElementById("chart");
const colours = {  // as in the other figures (bench/report/chart.cpp)
  "one-step-gn": "#0072b2", tsvd: "#d55e00", pdipm: "#009e73", lmmse: "#cc79a7", "gauss-newton": "#e69f00", contacts: "#56b4e9",
  fcnn: "#000000", dcnn: "#003f62", "eit-nn": "#753400", "dd-ert": "#00573f", "lean-net": "#70435c"};
const colour = row => colours[row.method] || "#707070", dot = row => `<span class=dot style="background:${colour(row)}"></span>`;
const shown = {metric: "relative_error", time: "p50", log: true, hidden: new Set(), sort: "p50", up: true};
const escaped = text => String(text).replace(/[&<>"]/g, c => `&#${c.charCodeAt(0)};`);
const time = us => { const [n, unit] = us < 1e3 ? [us, "µs"] : us < 1e6 ? [us / 1e3, "ms"] : [us / 1e6, "s"]; return `${+n.toPrecision(3)} ${unit}`; };
const interval = row => row.metrics[shown.metric].map(x => x.toPrecision(3)).join(" (").replace(/ \((?!.* \()/, " to ") + ")";
const error = row => row.metrics[shown.metric][0], duration = row => row.time[shown.time];
const options = names => Object.entries(names).map(([key, name]) => `<option value="${key}">${escaped(name.name || name)}</option>`).join("");

place.innerHTML = `<div class=controls><label>Score: <select id=metric>${options(data.metrics)}</select></label>
  <label>Time: <select id=time>${options(data.times)}</select></label> <label><input type=checkbox id=log checked> logarithmic</label></div>
  <div class=controls role=group aria-label=Methods>${[...new Set(data.rows.map(row => row.method))].map(method =>
    `<label><input type=checkbox name=method value="${method}" checked>${dot({method})}${method}</label>`).join(" ")}</div>
  <div id=plot></div><p id=detail aria-live=polite>Point at a method, or reach it with the Tab key, to see its parameters and how to reproduce it.
  The line is the frontier: nothing faster is better. Hollow points lie beyond the upper edge.</p><div class=wide><table id=rows></table></div>`;

function ticks(low, high, log) {
  if (log) return [...Array(14).keys()].map(n => 10 ** (n - 4)).filter(x => x >= low && x <= high);
  const step = [1, 2, 5, 10].map(n => n * 10 ** Math.floor(Math.log10(high / 5))).find(n => high / n <= 6);
  return [...Array(7).keys()].map(n => +(n * step).toPrecision(6)).filter(x => x <= high);
}

function draw() {
  const {name, more} = data.metrics[shown.metric], means = data.rows.filter(row => row.metrics[shown.metric]).map(error).sort((a, b) => a - b);
  const rows = data.rows.filter(row => !shown.hidden.has(row.method) && row.metrics[shown.metric]).sort((a, b) => duration(a) - duration(b));
  const frontier = [];  // those that are better than every faster one
  for (const row of rows) if (row.converged && !frontier.some(one => more ? error(one) >= error(row) : error(one) <= error(row))) frontier.push(row);
  const width = Math.max(280, place.clientWidth), left = 46, right = width - 12, above = 34, below = (width < 600 ? 360 : 500) - 46;
  const times = data.rows.map(duration), top = more ? 1 : Math.min(means.at(-1) * 1.05, 2 * means[means.length >> 1]), scale = shown.log ? Math.log : x => x;
  const [low, high] = shown.log ? [Math.min(...times) / 1.5, Math.max(...times) * 1.5] : [0, Math.max(...times) * 1.05];
  const x = us => left + (right - left) * (scale(us) - scale(low)) / (scale(high) - scale(low)), y = e => Math.max(above - 8, below - (below - above) * e / top);
  let svg = ticks(low, high, shown.log).map(us => `<path stroke="#e4e4e4" d="M${x(us)} ${above}V${below}"/><text x=${x(us)} y=${below + 18} text-anchor=middle>${time(us)}</text>`).join("")
    + ticks(0, top).map(e => `<path stroke="#e4e4e4" d="M${left} ${y(e)}H${right}"/><text x=${left - 6} y=${y(e) + 4} text-anchor=end>${e}</text>`).join("")
    + `<text x=4 y=14>${escaped(name)}</text><text x=${right} y=${below + 40} text-anchor=end>${escaped(data.times[shown.time])}</text>`;
  const [, best, worst, what = "best known estimator"] = data.limit[shown.metric] || [];
  if (worst < top) svg += `<path fill="#f2dada" d="M${left} ${y(best)}H${right}V${y(worst)}H${left}Z"/><text x=${right - 6} y=${y((best + worst) / 2) + 4} text-anchor=end>${what}, ${data.limit_frames} frames</text>`;
  svg += frontier.length ? `<path class=frontier d="M${frontier.map(row => `${x(duration(row))} ${y(error(row))}`).reduce((d, at) => `${d}H${at.split(" ")[0]}V${at.split(" ")[1]}`)}H${right}"/>` : "";
  for (const row of rows) svg += `<path stroke="${colour(row)}" d="M${x(duration(row))} ${y(row.metrics[shown.metric][1])}V${y(row.metrics[shown.metric][2])}"/><circle tabindex=0 role=img
    aria-label="${escaped(row.label)}: ${interval(row)}, ${time(duration(row))}" data-row=${data.rows.indexOf(row)} cx=${x(duration(row))} cy=${y(error(row))} r=5.5
    fill="${error(row) > top ? "#fff" : colour(row)}" stroke="${colour(row)}"/>`;
  let end = [0, 0];  // of the last label: one that would touch it is left out
  for (const row of width < 600 ? [] : frontier) {
    const at = [x(duration(row)) - 9, y(error(row)) + 17], long = 7.5 * row.label.length;
    if (at[0] - long < left || Math.abs(at[1] - end[1]) < 16 && at[0] - long < end[0]) continue;
    svg += `<text x=${at[0]} y=${at[1]} text-anchor=end fill="${colour(row)}">${escaped(row.label)}</text>`;
    end = at;
  }
  document.getElementById("plot").innerHTML = `<svg width=${width} height=${below + 46} role=group aria-label="Chart of ${escaped(name)} against time">${svg}</svg>`;
  const columns = {label: ["method", row => row.label], error: [name + ", 95 %", error], p50: ["p50", row => row.time.p50], p99: ["p99", row => row.time.p99], batch: ["in a batch", row => row.time.batch],
    ...data.times.contacts && {contacts: ["to contacts", row => row.time.contacts]}};
  const key = columns[shown.sort][1], sorted = [...rows].sort((a, b) => (key(a) < key(b) ? -1 : key(a) > key(b)) * (shown.up ? 1 : -1));
  document.getElementById("rows").innerHTML = `<thead><tr>${Object.entries(columns).map(([id, [words]]) => `<th${id === "label" ? "" : " class=number"}${id === shown.sort ?
    ` aria-sort=${shown.up ? "ascending" : "descending"}` : ""}><button data-sort=${id}>${escaped(words)}${id === shown.sort ? (shown.up ? " ▲" : " ▼") : ""}</button>`).join("")}</thead><tbody>` + sorted.map(row =>
    `<tr data-row=${data.rows.indexOf(row)}><td>${dot(row)}${escaped(row.label)}<td class=number>${[interval(row), ...Object.keys(data.times).map(name => time(row.time[name]))].join("<td class=number>")}`).join("");
}

function tell({target}) {
  const row = data.rows[target.closest("[data-row]")?.dataset.row];
  if (row) document.getElementById("detail").innerHTML = `<strong>${dot(row)}${escaped(row.label)}</strong>: ${escaped(data.metrics[shown.metric].name)} ${interval(row)};
    p50 ${time(row.time.p50)}, p99 ${time(row.time.p99)}, ${time(row.time.batch)} in a batch.${row.converged ? "" : " Not on the frontier: frames did not converge."}
    <br>${escaped(row.parameters)}<br><code>${escaped(row.command)}</code>`;
}

place.addEventListener("change", ({target}) => {
  if (target.name === "method") shown.hidden[target.checked ? "delete" : "add"](target.value);
  else shown[target.id] = target.type === "checkbox" ? target.checked : target.value;
  draw();
});
place.addEventListener("click", event => {
  const sort = event.target.dataset.sort;
  if (!sort) return;
  Object.assign(shown, {sort, up: sort !== shown.sort || !shown.up});
  draw();
  place.querySelector(`[data-sort=${sort}]`).focus();
});
for (const kind of ["mouseover", "focusin", "click"]) place.addEventListener(kind, tell);
window.addEventListener("resize", draw);
draw();

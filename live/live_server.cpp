#include "live/live_server.h"

#include <arpa/inet.h>

#include <atomic>
#include <thread>

#include "core/errors.h"
#include "core/text.h"
#include "live/live_state.h"

namespace ertbench {
namespace {

constexpr const char* page_head = R"HTML(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>ertbench live</title>
<link rel="icon" href="data:,">
<style>
:root { --ink: #1d2226; --soft: #5b6570; --line: #d5dae0; --ground: #f5f6f8; --alarm: #b00020;
  --good: #14713d; --care: #9a5b00; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink);
  font: 15px/1.4 system-ui, "DejaVu Sans", sans-serif; }
header { display: flex; flex-wrap: wrap; gap: 4px 14px; align-items: baseline; padding: 12px 16px;
  background: #fff; border-bottom: 1px solid var(--line); }
h1 { margin: 0; font-size: 18px; } h2 { margin: 0 0 8px; font-size: 13px; color: var(--soft); font-weight: 600; }
header span { color: var(--soft); overflow-wrap: anywhere; }
main { display: grid; grid-template-columns: minmax(0, 11fr) minmax(0, 9fr); gap: 12px;
  max-width: 1120px; margin: 0 auto; padding: 12px; }
section { background: #fff; border: 1px solid var(--line); border-radius: 6px; padding: 12px;
  min-width: 0; }
.sheet { grid-row: span 4; }
canvas { display: block; width: 100%; }
#scale { display: flex; align-items: center; gap: 8px; margin-top: 8px; font-size: 12px;
  color: var(--soft); font-variant-numeric: tabular-nums; }
#scale i { flex: 1; height: 10px; border: 1px solid var(--line);
  background: linear-gradient(90deg, #2166ac, #67a9cf, #f7f7f7, #ef8a62, #b2182b); }
#badge { display: inline-block; padding: 3px 10px; border-radius: 4px; background: var(--soft);
  color: #fff; font-weight: 600; }
#badge.ok { background: var(--good); } #badge.care { background: var(--care); }
#badge.bad { background: var(--alarm); }
#reasons { margin: 6px 0 0; min-height: 1.4em; color: var(--soft); }
dl { display: grid; grid-template-columns: repeat(auto-fit, minmax(88px, 1fr)); gap: 8px; margin: 0; }
dt { font-size: 12px; color: var(--soft); } dd { margin: 0; font-size: 19px;
  font-variant-numeric: tabular-nums; white-space: nowrap; }
dd.bad { color: var(--alarm); }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; font-size: 13px; }
th, td { text-align: right; padding: 2px 4px; border-bottom: 1px solid var(--line); }
th { color: var(--soft); font-weight: 600; } th:first-child, td:first-child { text-align: left; }
@media (max-width: 760px) { main { grid-template-columns: minmax(0, 1fr); padding: 8px; gap: 8px; }
  .sheet { grid-row: auto; } header { padding: 8px 12px; } }
</style>
</head>
<body>
<header><h1>ertbench live</h1><span id="solver"></span><span id="input"></span></header>
<main>
<section class="sheet"><h2>Change of the conductivity, contacts and their trail</h2>
<canvas id="image" role="img" aria-label="image of the sheet"></canvas>
<div id="scale"><span id="low"></span><i></i><span id="high"></span></div></section>
<section><h2>Frame <span id="frame">–</span></h2>
<div aria-live="polite"><span id="badge">waiting</span> <span id="alarm"></span></div>
<p id="reasons"></p></section>
<section><h2>Stream</h2><dl>
<div><dt>arriving, 1/s</dt><dd id="came">–</dd></div>
<div><dt>answered, 1/s</dt><dd id="answered">–</dd></div>
<div><dt>dropped</dt><dd id="dropped">–</dd></div>
<div><dt>damaged</dt><dd id="damaged">–</dd></div>
<div><dt>p50, ms</dt><dd id="p50">–</dd></div>
<div><dt>p99, ms</dt><dd id="p99">–</dd></div>
<div><dt>largest, ms</dt><dd id="largest">–</dd></div>
<div><dt>late</dt><dd id="late">–</dd></div></dl></section>
<section><h2>Latency, from arrival to answer</h2>
<canvas id="histogram" role="img" aria-label="histogram of the latency"></canvas></section>
<section><h2>Contacts</h2><table><thead><tr><th>contact</th><th>x, mm</th><th>y, mm</th>
<th>peak, S/m</th><th>force, N</th></tr></thead><tbody id="contacts"></tbody></table></section>
</main>
<script>
)HTML";

constexpr const char* page_script = R"JS('use strict';
const $ = id => document.getElementById(id);
const say = (id, text) => { if ($(id).textContent !== text) $(id).textContent = text; };
const colours = [[33, 102, 172], [103, 169, 207], [247, 247, 247], [239, 138, 98], [178, 24, 43]];
const hues = ['#111111', '#0b7a75', '#7b2d8b', '#c75000', '#0050a0', '#5b7a00'];
const trailSeconds = 3;
let range = 0;               // of the colours, S/m
const trails = new Map();    // of the tracks: [[time, x, y], ...]

function colour(share) {     // -1 ... 1
  const place = Math.min(Math.max((share + 1) * 2, 0), 3.9999), i = Math.floor(place);
  return colours[i].map((c, k) => Math.round(c + (place - i) * (colours[i + 1][k] - c)));
}

// A canvas with as many pixels as the screen has; drawn on in px of the page.
function pen(canvas, height) {
  const width = canvas.clientWidth, ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.height = height + 'px';
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  return [context, width];
}

function drawSheet(state) {
  const canvas = $('image'), margin = 26;
  const [sizeX, sizeY] = state.size_mm;
  const height = (canvas.clientWidth - 2 * margin) * sizeY / sizeX + 2 * margin;
  const [pencil, width] = pen(canvas, height);
  const scale = (width - 2 * margin) / sizeX;
  const x = mm => width / 2 + mm * scale, y = mm => height / 2 - mm * scale;
  const sheet = new Path2D();
  state.outline.forEach(([ox, oy], i) => i ? sheet.lineTo(x(ox), y(oy)) : sheet.moveTo(x(ox), y(oy)));
  sheet.closePath();
  pencil.fillStyle = '#e9ecef';
  pencil.fill(sheet);
  if (state.image && state.image.length) {
    const [rows, columns] = state.image_size, picture = new ImageData(columns, rows);
    const peak = Math.max(...state.image.map(Math.abs));
    range = Math.max(peak, 0.98 * range);
    state.image.forEach((value, i) => {
      const rgb = colour(range > 0 ? value / range : 0);
      const row = rows - 1 - Math.floor(i / columns);
      picture.data.set([...rgb, 255], 4 * (row * columns + i % columns));
    });
    const small = document.createElement('canvas');
    small.width = columns;
    small.height = rows;
    small.getContext('2d').putImageData(picture, 0, 0);
    pencil.imageSmoothingEnabled = false;
    pencil.save();
    pencil.clip(sheet);
    pencil.drawImage(small, margin, margin, sizeX * scale, sizeY * scale);
    pencil.restore();
    say('low', '−' + range.toPrecision(2) + ' S/m');
    say('high', '+' + range.toPrecision(2) + ' S/m');
  }
  pencil.strokeStyle = '#8a949e';
  pencil.stroke(sheet);
  pencil.font = '11px system-ui, "DejaVu Sans", sans-serif';
  pencil.textAlign = 'center';
  pencil.textBaseline = 'middle';
  const dead = state.answer ? state.answer.dead_electrodes : [];
  state.electrodes.forEach(([ex, ey], e) => {
    pencil.fillStyle = dead.includes(e) ? '#b00020' : '#303840';
    pencil.beginPath();
    pencil.arc(x(ex), y(ey), dead.includes(e) ? 5 : 3, 0, 7);
    pencil.fill();
    // Outside of a straight side, or away from the middle.
    const out = (ax, half) => Math.abs(Math.abs(ax) - half) < 0.02 * half ? Math.sign(ax) : 0;
    const away = state.outline.length > 4 ? [ex, ey].map(a => a / Math.hypot(ex, ey))
                                          : [out(ex, sizeX / 2), out(ey, sizeY / 2)];
    pencil.fillText(e, x(ex) + 14 * away[0], y(ey) - 14 * away[1]);
  });
  const bar = 10 ** Math.floor(Math.log10(sizeX / 3));
  const length = [5, 2, 1].map(f => f * bar).find(l => l <= sizeX / 3);
  pencil.strokeStyle = pencil.fillStyle = '#111';
  pencil.lineWidth = 2;
  pencil.beginPath();
  pencil.moveTo(margin + 10, height - margin - 10);
  pencil.lineTo(margin + 10 + length * scale, height - margin - 10);
  pencil.stroke();
  pencil.fillText(length + ' mm', margin + 10 + length * scale / 2, height - margin - 20);
  if (!state.answer) return;
  for (const track of state.answer.tracks) {
    if (!track.seen) continue;  // where it should be by now is no place that it was seen at
    if (!trails.has(track.id)) trails.set(track.id, []);
    trails.get(track.id).push([state.time_s, track.x_mm, track.y_mm]);
  }
  pencil.save();
  pencil.beginPath();
  pencil.rect(margin, margin, sizeX * scale, sizeY * scale);
  pencil.clip();
  for (const [id, trail] of trails) {
    while (trail.length && trail[0][0] < state.time_s - trailSeconds) trail.shift();
    if (!trail.length) { trails.delete(id); continue; }
    pencil.strokeStyle = hues[id % hues.length];
    pencil.lineWidth = 2;
    pencil.beginPath();
    trail.forEach(([, tx, ty], i) => i ? pencil.lineTo(x(tx), y(ty)) : pencil.moveTo(x(tx), y(ty)));
    pencil.stroke();
  }
  pencil.restore();
  for (const track of state.answer.tracks) {
    if (!track.seen) continue;
    pencil.fillStyle = hues[track.id % hues.length];
    pencil.beginPath();
    pencil.arc(x(track.x_mm), y(track.y_mm), 4, 0, 7);
    pencil.fill();
  }
  pencil.strokeStyle = '#000';
  pencil.lineWidth = 1.5;
  for (const one of state.answer.contacts) {
    pencil.beginPath();
    pencil.arc(x(one.x_mm), y(one.y_mm), Math.max(7, Math.sqrt(one.area_mm2 / Math.PI) * scale), 0, 7);
    pencil.stroke();
  }
}

const duration = us => us < 1e3 ? us + ' µs' : us < 1e6 ? us / 1e3 + ' ms' : us / 1e6 + ' s';

function drawHistogram(state) {
  const height = 150, below = 22, above = 16, h = state.histogram;
  const [pencil, width] = pen($('histogram'), height);
  const first = Math.max(0, h.counts.findIndex(c => c > 0) - 2);
  let last = h.counts.length - 1;
  while (last > first && !h.counts[last]) --last;
  const deadline = state.deadline_us;
  const place = us => Math.log10(us * 1e-6 / h.least_s) * h.per_decade;
  const low = Math.floor((deadline ? Math.min(first, place(deadline) - 2) : first) / 10) * 10;
  const high = Math.ceil((deadline ? Math.max(last + 1, place(deadline) + 2) : last + 1) / 10) * 10;
  const x = at => 10 + (at - low) / Math.max(1, high - low) * (width - 20);
  const most = Math.max(1, ...h.counts);
  const y = count => height - below -
    (count ? Math.log10(1 + count) / Math.log10(1 + most) : 0) * (height - below - above);
  h.counts.forEach((count, i) => {
    if (!count) return;
    const late = deadline && i >= place(deadline) - 0.001;
    pencil.fillStyle = late ? '#b00020' : '#3b6ea5';
    pencil.fillRect(x(i), y(count), x(i + 1) - x(i) - 0.5, height - below - y(count));
  });
  pencil.fillStyle = '#8a949e';
  pencil.fillRect(10, height - below, width - 20, 1);
  pencil.font = '11px system-ui, "DejaVu Sans", sans-serif';
  pencil.fillStyle = '#5b6570';
  for (let at = low; at <= high; at += h.per_decade) {
    pencil.textAlign = at === low ? 'left' : at === high ? 'right' : 'center';
    pencil.fillText(duration(Math.round(10 ** (at / h.per_decade))), x(at), height - 7);
  }
  pencil.textAlign = 'left';
  pencil.fillText('frames, logarithmic', 10, 10);
  if (!deadline) return;
  const at = x(place(deadline));
  pencil.strokeStyle = pencil.fillStyle = '#b00020';
  pencil.setLineDash([4, 3]);
  pencil.beginPath();
  pencil.moveTo(at, above - 2);
  pencil.lineTo(at, height - below);
  pencil.stroke();
  pencil.setLineDash([]);
  pencil.textAlign = at > width / 2 ? 'right' : 'left';
  pencil.fillText('deadline ' + duration(deadline), at + (at > width / 2 ? -5 : 5), above + 8);
}
)JS";

constexpr const char* page_end = R"JS(
function ms(us) { return us === null ? '–' : (us / 1000).toPrecision(3); }
const badge = (text, kind) => { say('badge', text); $('badge').className = kind; };

function show(state) {
  say('solver', state.solver);
  say('input', state.input);
  const c = state.counts, damaged = Object.values(c.damaged).reduce((a, b) => a + b, 0);
  say('came', state.came_per_s.toFixed(0));
  say('answered', state.answered_per_s.toFixed(0));
  say('dropped', String(c.dropped));
  say('damaged', String(damaged));
  $('damaged').title = Object.entries(c.damaged).map(([k, n]) => k + ': ' + n).join('\n');
  $('damaged').className = damaged ? 'bad' : '';
  say('p50', ms(state.latency.p50));
  say('p99', ms(state.latency.p99));
  say('largest', ms(state.latency.max));
  say('late', state.deadline_us === null ? '–' : String(c.late));
  $('late').className = c.late ? 'bad' : '';
  drawSheet(state);
  drawHistogram(state);
  const a = state.answer;
  if (a) {
    say('frame', String(state.frame));
    badge(a.status, a.status === 'ok' ? 'ok' : a.status === 'undefined' ? 'bad' : 'care');
    say('reasons', a.reasons.join(', ') +
      (a.dead_electrodes.length ? ' (electrodes ' + a.dead_electrodes.join(', ') + ')' : ''));
    say('alarm', a.alarm === null ? '' : a.alarm ? 'COLLISION' : 'no collision');
    $('alarm').style.color = a.alarm ? 'var(--alarm)' : '';
    $('contacts').replaceChildren(...a.contacts.slice(0, 6).map((one, i) => {
      const row = document.createElement('tr');
      for (const text of [String(i + 1), one.x_mm.toFixed(1), one.y_mm.toFixed(1),
                          one.peak.toPrecision(3),
                          one.force_N === null ? '–' : one.force_N.toFixed(2)]) {
        row.appendChild(document.createElement('td')).textContent = text;
      }
      return row;
    }));
  }
  if (state.silent_s > 0) badge('silent for ' + state.silent_s.toFixed(0) + ' s', 'bad');
  if (state.finished) badge('the stream has ended', '');
  document.body.dataset.frame = state.frame ?? '';
}

const events = new EventSource('/events');
let newest = null, drawn = true;
events.onmessage = event => {
  newest = JSON.parse(event.data);
  if (newest.finished) events.close();
  if (!drawn) return;
  drawn = false;
  setTimeout(() => { drawn = true; show(newest); }, 0);
};
events.onerror = () => { if (!newest || !newest.finished) badge('no connection', 'bad'); };
window.addEventListener('resize', () => { if (newest) show(newest); });
</script>
</body>
</html>
)JS";

}  // namespace

const std::string& live_page() {
  static const std::string page = std::string(page_head) + page_script + page_end;
  return page;
}

namespace {

constexpr int write_patience_s = 2;
constexpr int read_patience_s = 2;
/// Threads beside those of the clients that watch: they hand out the page and refuse.
constexpr int further_threads = 2;

/// Frees a place among the clients.
class WatcherPlace {
 public:
  explicit WatcherPlace(std::atomic<int>& watchers) : watchers_(watchers) {}
  WatcherPlace(const WatcherPlace&) = delete;
  WatcherPlace& operator=(const WatcherPlace&) = delete;
  ~WatcherPlace() { --watchers_; }

 private:
  std::atomic<int>& watchers_;
};

/// "127.0.0.1" of "127.0.0.1:8080", "::1" of "[::1]:8080".
std::string host_of(const std::string& header) {
  if (header.starts_with('[')) return header.substr(1, header.find(']') - 1);
  return header.substr(0, header.find(':'));
}

}  // namespace

bool is_loopback(const std::string& host) {
  // A name may begin with "127." and stand for any machine: an address is what can be parsed as
  // one.
  in_addr address{};
  const bool parsed = ::inet_pton(AF_INET, host.c_str(), &address) == 1;
  return host == "localhost" || host == "::1" || (parsed && ntohl(address.s_addr) >> 24 == 127);
}

struct LiveServer::Parts {
  httplib::Server server;
  LiveState& state;
  LiveServerOptions options;
  std::thread thread;

  Parts(const LiveServerOptions& its_options, LiveState& its_state)
      : state(its_state), options(its_options) {}

  void add_pages();
  void watch(httplib::Response& response);
};

void LiveServer::Parts::watch(httplib::Response& response) {
  if (++state.watchers > options.clients) {
    --state.watchers;
    response.status = 503;
    response.set_content("as many clients are served as may be (--http-clients)\n", "text/plain");
    return;
  }
  const auto place = std::make_shared<WatcherPlace>(state.watchers);
  response.set_header("Cache-Control", "no-store");
  response.set_chunked_content_provider(
      "text/event-stream",
      [this, place, version = std::uint64_t{0}](std::size_t, httplib::DataSink& sink) mutable {
        const bool last = state.finished();
        if (!last) version = state.wait_for_newer(version);
        std::string event = "data: ";
        event.append(state.json()).append("\n\n");
        if (!sink.write(event.data(), event.size())) return false;
        if (last) sink.done();
        return true;
      });
}

void LiveServer::Parts::add_pages() {
  const int threads = options.clients + further_threads;
  server.new_task_queue = [threads] {
    return new httplib::ThreadPool(static_cast<std::size_t>(threads));
  };
  server.set_write_timeout(write_patience_s);
  server.set_read_timeout(read_patience_s);
  server.set_keep_alive_timeout(1);
  server.set_payload_max_length(0);
  server.set_tcp_nodelay(true);
  server.set_default_headers(
      {{"Content-Security-Policy",
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
       {"X-Content-Type-Options", "nosniff"},
       {"Referrer-Policy", "no-referrer"}});
  server.set_pre_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        if (is_loopback(options.host) && !is_loopback(host_of(request.get_header_value("Host")))) {
          response.status = 403;
          response.set_content("ask for this machine by its address\n", "text/plain");
          return httplib::Server::HandlerResponse::Handled;
        }
        if (request.method != "GET" && request.method != "HEAD") {
          response.status = 405;
          response.set_header("Allow", "GET, HEAD");
          return httplib::Server::HandlerResponse::Handled;
        }
        return httplib::Server::HandlerResponse::Unhandled;
      });
  server.Get("/", [](const httplib::Request&, httplib::Response& response) {
    response.set_content(live_page(), "text/html; charset=utf-8");
  });
  server.Get("/state", [this](const httplib::Request&, httplib::Response& response) {
    response.set_header("Cache-Control", "no-store");
    response.set_content(state.json() + "\n", "application/json");
  });
  server.Get("/events",
             [this](const httplib::Request&, httplib::Response& response) { watch(response); });
}

LiveServer::LiveServer(const LiveServerOptions& options, LiveState& state)
    : parts_(std::make_unique<Parts>(options, state)) {
  parts_->add_pages();
  LiveServerOptions& own = parts_->options;
  if (own.port == 0) {
    own.port = parts_->server.bind_to_any_port(own.host);
  } else if (!parts_->server.bind_to_port(own.host, own.port)) {
    own.port = -1;
  }
  if (own.port <= 0) {
    throw InputError("--http: " + printable(options.host) + ":" + std::to_string(options.port) +
                     " cannot be listened at; name an address of this machine and a port that is "
                     "free, or port 0 for any");
  }
  parts_->thread = std::thread([this] { parts_->server.listen_after_bind(); });
}

LiveServer::~LiveServer() {
  parts_->state.finish();
  while (!parts_->server.is_running()) std::this_thread::yield();
  parts_->server.stop();
  parts_->thread.join();
}

int LiveServer::port() const { return parts_->options.port; }

std::string LiveServer::address() const {
  const std::string& host = parts_->options.host;
  const bool ip6 = host.find(':') != std::string::npos;
  return "http://" + (ip6 ? "[" + host + "]" : host) + ":" + std::to_string(port()) + "/";
}

}  // namespace ertbench

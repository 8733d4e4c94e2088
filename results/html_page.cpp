#include "results/html_page.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam::internal {
namespace {

std::string Base64(const std::vector<uchar>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t n = std::min<size_t>(3, bytes.size() - i);
    const uint32_t group =
        uint32_t(bytes[i]) << 16 | (n > 1 ? uint32_t(bytes[i + 1]) << 8 : 0) | (n > 2 ? uint32_t(bytes[i + 2]) : 0);
    out += kDigits[group >> 18];
    out += kDigits[group >> 12 & 63];
    out += n > 1 ? kDigits[group >> 6 & 63] : '=';
    out += n > 2 ? kDigits[group & 63] : '=';
  }
  return out;
}

// Series colours are those of Okabe and Ito, distinct to colour-blind eyes, a little lighter in the dark.
constexpr std::string_view kStyle = R"css(
:root {
  color-scheme: light dark;
  --page: #f6f6f3; --card: #ffffff; --ink: #1b1d20; --muted: #646a71; --line: #e3e3de; --soft: #f0f0ec;
  --sim3: #0072b2; --se3: #c75a00; --green: #00805e; --purple: #a4497e; --truth: #30343a;
  --good: #1a7f4b; --warn: #8f5a00; --bad: #b3261e; --good-soft: #e3f3ea; --warn-soft: #fdf1da; --bad-soft: #fce8e6;
  --grid: rgba(0, 0, 0, .08); --lost: rgba(179, 38, 30, .12); --wait: rgba(100, 106, 113, .13);
}
@media (prefers-color-scheme: dark) {
  :root:not(.paper) {
    --page: #131518; --card: #1b1e22; --ink: #e9eaec; --muted: #9ba1a9; --line: #2c3036; --soft: #23272c;
    --sim3: #5db4ea; --se3: #f2994a; --green: #3fc79a; --purple: #d98bb6; --truth: #d5d8dc;
    --good: #63d297; --warn: #f0be62; --bad: #ff8a80; --good-soft: #17301f; --warn-soft: #35290f; --bad-soft: #3b1b19;
    --grid: rgba(255, 255, 255, .09); --lost: rgba(255, 138, 128, .17); --wait: rgba(155, 161, 169, .15);
  }
}
* { box-sizing: border-box; }
body {
  margin: 0; background: var(--page); color: var(--ink); -webkit-text-size-adjust: 100%;
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif;
}
main { max-width: 1180px; margin: 0 auto; padding: 2.25rem 1.25rem 3rem; }
header { display: flex; flex-wrap: wrap; gap: .5rem 1rem; align-items: baseline; margin-bottom: 1.25rem; }
header .brand { flex-basis: 100%; color: var(--muted); font-size: .8rem; letter-spacing: .08em; text-transform: uppercase; }
h1 { font-size: clamp(1.6rem, 4vw, 2.25rem); line-height: 1.15; letter-spacing: -.02em; margin: 0; overflow-wrap: anywhere; }
header p { flex-basis: 100%; margin: 0; color: var(--muted); }
h2 { font-size: 1.15rem; letter-spacing: -.01em; margin: 2.4rem 0 .75rem; }
h3 { font-size: .95rem; font-weight: 600; margin: 0; }
.note { color: var(--muted); font-size: .875rem; margin: 0 0 .75rem; max-width: 72ch; }
.pill { display: inline-block; border-radius: 99px; padding: .15rem .7rem; font-size: .85rem; font-weight: 600; white-space: nowrap; }
.pill.good { color: var(--good); background: var(--good-soft); }
.pill.warn { color: var(--warn); background: var(--warn-soft); }
.pill.bad { color: var(--bad); background: var(--bad-soft); }
.banner { border-left: 5px solid; border-radius: 8px; padding: .8rem 1.1rem; margin: .6rem 0; }
.banner b { display: block; }
.banner.bad { border-color: var(--bad); background: var(--bad-soft); }
.banner.bad b { color: var(--bad); }
.banner.warn { border-color: var(--warn); background: var(--warn-soft); }
.banner.warn b { color: var(--warn); }
.cards { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: .75rem; margin: 1.25rem 0 0; padding: 0; }
@media (min-width: 760px) { .cards { grid-template-columns: repeat(4, minmax(0, 1fr)); } }
.cards div, .panel { background: var(--card); border: 1px solid var(--line); border-radius: 12px; }
.cards div { padding: .85rem 1rem .8rem; display: flex; flex-direction: column; }
.cards dt { color: var(--muted); font-size: .82rem; }
.cards dd { margin: 0; }
.cards .value { font-size: 1.7rem; line-height: 1.25; font-weight: 650; letter-spacing: -.02em; font-variant-numeric: tabular-nums; }
.cards .value small { font-size: .95rem; font-weight: 500; color: var(--muted); letter-spacing: 0; margin-left: .2em; }
.cards .hint { color: var(--muted); font-size: .78rem; line-height: 1.35; margin-top: .15rem; }
.panel { padding: 1rem 1.1rem; margin: 0; }
.panel + .panel { margin-top: .75rem; }
.grid { display: grid; gap: .75rem; grid-template-columns: minmax(0, 1fr); }
.grid > .panel + .panel { margin-top: 0; }
.grid.halves { margin-top: .75rem; }
@media (min-width: 860px) {
  .grid.two { grid-template-columns: minmax(0, 3fr) minmax(0, 2fr); }
  .grid.halves { grid-template-columns: minmax(0, 1fr) minmax(0, 1fr); }
}
.chart { position: relative; margin-top: .5rem; }
.key { display: flex; flex-wrap: wrap; gap: .1rem 1.1rem; list-style: none; margin: .3rem 0 0; padding: 0; font-size: .82rem; color: var(--muted); }
h2 + .key { margin: -.3rem 0 .7rem; }
.key button { all: unset; cursor: pointer; }
.key button:hover { color: var(--ink); }
.key button:focus-visible { outline: 2px solid var(--sim3); outline-offset: 2px; border-radius: 3px; }
.key button[aria-pressed="false"] { text-decoration: line-through; opacity: .65; }
.key button[aria-pressed="false"]::after { content: " (show)"; display: inline-block; white-space: pre; text-decoration: none; }
.key li::before { content: ""; display: inline-block; width: 1.3em; border-top: 3px solid var(--c); vertical-align: .28em; margin-right: .45em; }
.key li.dashed::before { border-top-style: dashed; }
.key li.area::before { height: .85em; border: 0; background: var(--c); vertical-align: -.1em; border-radius: 2px; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .875rem; }
th, td { text-align: left; padding: .32rem .8rem .32rem 0; border-bottom: 1px solid var(--line); vertical-align: baseline; }
tr:last-child td { border-bottom: 0; }
thead th, tbody th { color: var(--muted); font-weight: 600; font-size: .8rem; }
tbody th { padding-top: 1.1rem; color: var(--ink); font-size: .875rem; }
td code { font: .84rem/1.4 ui-monospace, "SF Mono", Menlo, Consolas, "DejaVu Sans Mono", monospace; white-space: nowrap; }
td.number { text-align: right; font-variant-numeric: tabular-nums; font-weight: 600; white-space: nowrap; padding-right: .4rem; }
td.unit, td.meaning { color: var(--muted); }
details > summary { cursor: pointer; font-weight: 600; font-size: .95rem; }
pre { margin: .75rem 0 0; padding: .9rem 1rem; background: var(--soft); border-radius: 8px; overflow-x: auto; font: .82rem/1.5 ui-monospace, "SF Mono", Menlo, Consolas, "DejaVu Sans Mono", monospace; }
.facts { display: grid; grid-template-columns: minmax(7rem, max-content) minmax(0, 1fr); gap: .25rem 1.2rem; margin: 0; font-size: .875rem; }
.facts dt { color: var(--muted); }
.facts dd { margin: 0; overflow-wrap: anywhere; }
footer { margin-top: 2.5rem; color: var(--muted); font-size: .8rem; }
a { color: var(--sim3); }
@media (max-width: 640px) {
  main { padding: 1.25rem .8rem 2rem; }
  td.meaning, thead th.meaning { display: none; }
  .panel { padding: .8rem .8rem; }
}
@media print {
  @page { margin: 14mm; }
  body { background: #fff; font-size: 12px; }
  main { max-width: none; padding: 0; }
  .chart { height: auto !important; }
  .chart canvas { max-width: 100% !important; height: auto !important; }
  .grid.two { grid-template-columns: minmax(0, 3fr) minmax(0, 2fr); }
  .key li:has(button[aria-pressed="false"]) { display: none; }
  .panel:not(.scroll), .cards div, figure, .banner, tr { break-inside: avoid; }
  h2, .note, .key { break-after: avoid; }
  .cards { grid-template-columns: repeat(4, 1fr); }
  * { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
}
)css";

constexpr std::string_view kScript = R"js(
// What every page's charts share, as an object `gaitcam`.
const gaitcam = (() => {
'use strict';
const data = JSON.parse(document.getElementById('data').textContent);
const charts = [];
const hidden = {};  // Series by id: by the reader, or because they would dwarf the rest.
const css = name => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
const range = n => Array.from({length: n}, (_, i) => i);
const xy = (x, y) => range(x.length).map(i => ({x: x[i], y: y[i]}));
// `id` is what a key's button names.
function line(id, label, colour, points, more) {
  return Object.assign({id, label, data: points, borderColor: css(colour), backgroundColor: css(colour), borderWidth: 1.8,
    pointRadius: 0, pointHitRadius: 6, pointHoverRadius: 3, tension: 0, spanGaps: false, borderJoinStyle: 'round'}, more);
}

function axis(text, more) {
  return Object.assign({type: 'linear', title: {display: true, text, color: css('muted'), font: {size: 12}},
    grid: {color: css('grid'), borderColor: css('grid'), drawTicks: false},
    ticks: {color: css('muted'), padding: 6, font: {size: 11}, maxRotation: 0, autoSkipPadding: 18,
      includeBounds: false, callback: value => +value.toPrecision(6)}}, more);
}

function options(x, y, more) {
  return Object.assign({animation: false, responsive: true, maintainAspectRatio: false, parsing: false, normalized: true,
    layout: {padding: {top: 4, right: 8}},
    interaction: {mode: 'nearest', axis: 'x', intersect: false},
    plugins: {legend: {display: false}, tooltip: {backgroundColor: 'rgba(20, 22, 25, .92)', padding: 10, displayColors: true,
      boxWidth: 8, boxHeight: 8, callbacks: {}}},
    scales: {x, y}}, more);
}

// Counts opaque pixels inside the axes: grid and shading are translucent, only data is not.
function showsData(chart) {
  const c = chart.canvas, k = c.width / c.clientWidth || 1, a = chart.chartArea;
  const w = Math.floor(a.width * k), h = Math.floor(a.height * k);
  if (w < 10 || h < 10) return false;
  const pixels = c.getContext('2d').getImageData(Math.ceil(a.left * k), Math.ceil(a.top * k), w, h).data;
  let opaque = 0;
  for (let i = 3; i < pixels.length; i += 4) if (pixels[i] > 200) ++opaque;
  return opaque > 30;
}

function applyHidden(chart) {
  chart.data.datasets.forEach((d, i) => { if (d.id) chart.setDatasetVisibility(i, !hidden[d.id]); });
  chart.update('none');
  if (chart.gaitcamFit) chart.gaitcamFit();
}

// A series hidden in one chart is hidden in all.
// Draws every <canvas data-chart=NAME> with drawers[NAME](canvas), which returns a Chart, now and whenever colours change.
function start(drawers) {
  // A series hidden in one chart is hidden in all.
  const buttons = document.querySelectorAll('.key button');
  const showPressed = () => buttons.forEach(b => b.setAttribute('aria-pressed', String(!hidden[b.dataset.series])));
  buttons.forEach(button => button.addEventListener('click', () => {
    hidden[button.dataset.series] = !hidden[button.dataset.series];
    charts.forEach(applyHidden);
    showPressed();
  }));
  showPressed();

  function draw() {
    Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
    while (charts.length) charts.pop().destroy();
    const canvases = document.querySelectorAll('canvas[data-chart]');
    let drawn = 0;
    for (const canvas of canvases) {
      const chart = drawers[canvas.dataset.chart](canvas);
      charts.push(chart);
      applyHidden(chart);
      canvas.dataset.drawn = showsData(chart) ? 'yes' : 'no';
      if (canvas.dataset.drawn === 'yes') ++drawn;
    }
    document.body.dataset.charts = canvases.length;
    document.body.dataset.chartsDrawn = drawn;
  }

  draw();
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
  window.addEventListener('beforeprint', () => { document.documentElement.classList.add('paper'); draw(); });
  window.addEventListener('afterprint', () => { document.documentElement.classList.remove('paper'); draw(); });
}

return {data, charts, hidden, css, range, xy, line, axis, options, start};
})();
)js";

/// JSON inside a script element must not hold the text that would close it.
std::string ScriptSafe(std::string json) {
  for (size_t at = json.find("</"); at != std::string::npos; at = json.find("</", at + 3)) json.insert(at + 1, "\\");
  return json;
}

}  // namespace

std::string JpegUri(const cv::Mat& picture, int max_width_px) {
  cv::Mat shown = picture;
  if (picture.cols > max_width_px) {
    cv::resize(picture, shown, {max_width_px, int(std::lround(double(picture.rows) * max_width_px / picture.cols))}, 0,
               0, cv::INTER_AREA);
  }
  std::vector<uchar> bytes;
  cv::imencode(".jpg", shown, bytes, {cv::IMWRITE_JPEG_QUALITY, 88});
  return "data:image/jpeg;base64," + Base64(bytes);
}

std::string Escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

std::string ReadChartLibrary(const std::filesystem::path& wanted) {
  std::vector<std::filesystem::path> places = {wanted};
  if (wanted.empty()) {
    places = {"/usr/share/javascript/chart.js/chart.min.js", "/usr/share/nodejs/chart.js/dist/chart.min.js"};
  }
  for (const std::filesystem::path& place : places) {
    std::ifstream file(place, std::ios::binary);
    std::stringstream text;
    if (file && text << file.rdbuf()) return text.str();
  }
  throw MissingResource("the report needs Chart.js at " + places.front().string() +
                        "; install the Debian package libjs-chart.js");
}

std::string Banner(const std::string& kind, const std::string& head, const std::string& text) {
  return fmt::format("<div class=\"banner {}\" role=\"alert\"><b>{}</b>{}</div>\n", kind, Escape(head), Escape(text));
}

std::string ThreeDigits(double value) {
  if (value == std::floor(value) || std::abs(value) >= 100) return fmt::format("{:.0f}", value);
  return fmt::format("{:#.3g}", value);
}

std::string Card(const std::string& name, double value, const std::string& unit, const std::string& hint) {
  return fmt::format("<div><dt>{}</dt><dd class=\"value\">{}<small>{}</small></dd><dd class=\"hint\">{}</dd></div>\n",
                     Escape(name), std::isfinite(value) ? ThreeDigits(value) : "&ndash;",
                     std::isfinite(value) ? Escape(unit) : "", Escape(hint));
}

std::string Key(const std::vector<KeyEntry>& entries, const std::string& charts) {
  std::string html = fmt::format("<ul class=\"key\" data-for=\"{}\">", charts);
  for (const KeyEntry& e : entries) {
    const std::string text =
        e.series.empty() ? Escape(e.text)
                         : fmt::format("<button type=\"button\" data-series=\"{}\" title=\"hide or show\">{}</button>",
                                       Escape(e.series), Escape(e.text));
    html += fmt::format("<li class=\"{}\" style=\"--c: var(--{})\">{}</li>", e.kind, e.colour, text);
  }
  return html + "</ul>\n";
}

std::string Panel(const std::string& chart, const std::string& title, const std::vector<KeyEntry>& key, int height_px) {
  return fmt::format(
      "<section class=\"panel\"><h3>{}</h3>\n{}<div class=\"chart\" style=\"height: {}px\"><canvas data-chart=\"{}\" "
      "role=\"img\" aria-label=\"{}\"></canvas></div></section>\n",
      Escape(title), key.empty() ? "" : Key(key, chart), height_px, chart, Escape(title));
}

std::string Facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  std::string html = "<section class=\"panel\"><dl class=\"facts\">\n";
  for (const auto& [name, value] : facts) html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", Escape(name), Escape(value));
  return html + "</dl></section>\n";
}

std::string PageHtml(const HtmlPage& page, const std::filesystem::path& chart_library) {
  const std::string library = ReadChartLibrary(chart_library);
  std::string html = "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  html += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  html += "<link rel=\"icon\" href=\"data:,\">\n";
  html += "<title>" + Escape(page.title) + " - gaitcam</title>\n<style>" + std::string(kStyle) +
          std::string(page.style) + "</style>\n";
  html += "</head>\n<body>\n<main>\n" + page.body;
  html += "<footer>Written by gaitcam. Charts by Chart.js (MIT licence), inlined.</footer>\n</main>\n";
  html += "<script type=\"application/json\" id=\"data\">" + ScriptSafe(page.data) + "</script>\n";
  html +=
      "<script>" + library + "</script>\n<script>" + std::string(kScript) + std::string(page.script) + "</script>\n";
  return html + "</body>\n</html>\n";
}

}  // namespace gaitcam::internal

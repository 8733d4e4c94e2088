#include "results/report_page.h"

namespace gaitcam::internal {
namespace {

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
video { display: block; width: 100%; border-radius: 12px; background: #000; border: 1px solid var(--line); }
.strip { display: grid; gap: .75rem; grid-template-columns: repeat(auto-fill, minmax(min(100%, 215px), 1fr)); }
@media (min-width: 1000px) { .strip { grid-template-columns: repeat(4, 1fr); } }
.strip figure { margin: 0; background: var(--card); border: 1px solid var(--line); border-radius: 12px; overflow: hidden; }
.strip .shot { position: relative; display: block; }
.strip img { display: block; width: 100%; height: auto; }
.strip .shot + .shot { border-top: 2px solid var(--card); }
.strip .shot span { position: absolute; left: .5rem; top: .45rem; font-size: .7rem; font-weight: 600; padding: .05rem .45rem; border-radius: 5px; background: rgba(0, 0, 0, .62); color: #fff; }
.strip figcaption { padding: .5rem .75rem .6rem; font-size: .82rem; color: var(--muted); font-variant-numeric: tabular-nums; }
.strip figcaption b { color: var(--ink); }
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
  .film { display: none; }
  .chart { height: auto !important; }
  .chart canvas { max-width: 100% !important; height: auto !important; }
  .grid.two { grid-template-columns: minmax(0, 3fr) minmax(0, 2fr); }
  .key li:has(button[aria-pressed="false"]) { display: none; }
  .panel:not(.scroll), .cards div, .strip figure, .banner, tr { break-inside: avoid; }
  h2, .note, .key { break-after: avoid; }
  .cards { grid-template-columns: repeat(4, 1fr); }
  .strip { grid-template-columns: repeat(4, 1fr); }
  * { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
}
)css";

constexpr std::string_view kScript = R"js(
(() => {
'use strict';
const data = JSON.parse(document.getElementById('data').textContent);
const charts = [];
let hoverTime = null;
const css = name => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
const range = n => Array.from({length: n}, (_, i) => i);
const xy = (x, y) => range(x.length).map(i => ({x: x[i], y: y[i]}));

// Shades spans in which there was no pose, and marks the time under the pointer in all charts over time.
const timePlugin = {
  id: 'time',
  beforeDatasetsDraw(chart) {
    const {ctx, chartArea: a, scales: {x}} = chart;
    ctx.save();
    ctx.beginPath(); ctx.rect(a.left, a.top, a.width, a.height); ctx.clip();
    for (const [from, to, kind] of data.spans) {
      ctx.fillStyle = css(kind === 'lost' ? 'lost' : 'wait');
      ctx.fillRect(x.getPixelForValue(from), a.top, x.getPixelForValue(to) - x.getPixelForValue(from), a.height);
    }
    ctx.strokeStyle = css('bad'); ctx.setLineDash([2, 3]); ctx.lineWidth = 1;
    for (const t of data.restarts) {
      const px = x.getPixelForValue(t);
      ctx.beginPath(); ctx.moveTo(px, a.top); ctx.lineTo(px, a.bottom); ctx.stroke();
    }
    ctx.restore();
  },
  afterDatasetsDraw(chart) {
    if (hoverTime === null) return;
    const {ctx, chartArea: a, scales: {x}} = chart, px = x.getPixelForValue(hoverTime);
    if (px < a.left || px > a.right) return;
    ctx.save(); ctx.strokeStyle = css('muted'); ctx.lineWidth = 1;
    ctx.beginPath(); ctx.moveTo(px, a.top); ctx.lineTo(px, a.bottom); ctx.stroke(); ctx.restore();
  },
  afterEvent(chart, {event}) {
    const inside = event.type !== 'mouseout' && event.x >= chart.chartArea.left && event.x <= chart.chartArea.right;
    const now = inside ? chart.scales.x.getValueForPixel(event.x) : null;
    if (now === hoverTime) return;
    hoverTime = now;
    for (const other of charts) if (other.config.options.gaitcamTime) other.draw();
  },
};

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

function overTime(canvas, datasets, yTitle, unit, yMore) {
  const y = axis(yTitle, Object.assign({beginAtZero: true, afterFit: s => { s.width = 58; }}, yMore));
  const x = axis('time, s', {min: data.t_min, max: data.t_max});
  const o = options(x, y, {gaitcamTime: true});
  o.interaction = {mode: 'index', intersect: false};
  o.plugins.tooltip.callbacks.title = items => items.length ? 't = ' + items[0].parsed.x.toFixed(2) + ' s' : '';
  o.plugins.tooltip.callbacks.label = i => ' ' + i.dataset.label + ': ' + (+i.parsed.y.toPrecision(4)) + ' ' + unit;
  return new Chart(canvas, {type: 'line', data: {datasets}, options: o, plugins: [timePlugin]});
}

// Chooses the limits of both axes so that a metre is as long up as across, with all points of `box` in view.
function equalAspect(chart, box) {
  for (let pass = 0; pass < 3; ++pass) {
    const a = chart.chartArea;
    const w = Math.max(box.x1 - box.x0, 1e-3), h = Math.max(box.y1 - box.y0, 1e-3);
    const perPixel = 1.06 * Math.max(w / a.width, h / a.height);
    const set = (scale, low, high, pixels) => {
      const middle = (low + high) / 2, half = perPixel * pixels / 2;
      scale.min = middle - half; scale.max = middle + half;
    };
    set(chart.options.scales.x, box.x0, box.x1, a.width);
    set(chart.options.scales.y, box.y0, box.y1, a.height);
    chart.update('none');
  }
}

// By the reader, or because they would dwarf the rest.
const hidden = {se3: !!(data.error && data.error.hide_se3), rot: !!(data.error && data.error.hide_rot)};

// The part of the world that a path chart shows: the truth, and the estimates as far as they do not dwarf it.
function pathBox(h, v) {
  const p = data.path, box = {x0: 1 / 0, x1: -1 / 0, y0: 1 / 0, y1: -1 / 0};
  const grow = s => range(s[h].length).forEach(i => {
    if (s[h][i] === null) return;
    box.x0 = Math.min(box.x0, s[h][i]); box.x1 = Math.max(box.x1, s[h][i]);
    box.y0 = Math.min(box.y0, s[v][i]); box.y1 = Math.max(box.y1, s[v][i]);
  });
  grow(p.truth);
  const limit = Object.assign({}, box), reach = 1.5 * Math.max(box.x1 - box.x0, box.y1 - box.y0, 0.1);
  for (const id of ['sim3', 'se3']) if (p[id] && !hidden[id]) grow(p[id]);
  return {x0: Math.max(box.x0, limit.x0 - reach), x1: Math.min(box.x1, limit.x1 + reach),
    y0: Math.max(box.y0, limit.y0 - reach), y1: Math.min(box.y1, limit.y1 + reach)};
}

function path(canvas, view) {
  const p = data.path, h = view.horizontal, v = view.vertical, datasets = [];
  if (p.sim3) {
    datasets.push(line('sim3', 'estimate, Sim(3)', 'sim3', xy(p.sim3[h], p.sim3[v]), {borderWidth: 2}));
    datasets.push(line('se3', 'estimate, SE(3)', 'se3', xy(p.se3[h], p.se3[v]), {borderWidth: 1.6, borderDash: [5, 4]}));
  }
  const last = p.truth[h].length - 1;
  const mark = (label, i, more) => datasets.push(Object.assign({label, type: 'scatter', pointHitRadius: 0,
    data: [{x: p.truth[h][i], y: p.truth[v][i]}]}, more));
  mark('start', 0, {pointStyle: 'circle', pointRadius: 7, backgroundColor: css('card'), borderColor: css('truth'), borderWidth: 2, order: -1});
  mark('end', last, {pointStyle: 'rectRot', pointRadius: 5, backgroundColor: css('truth'), borderColor: css('card'), borderWidth: 1.5, order: -2});
  datasets.push(line('truth', 'truth', 'truth', xy(p.truth[h], p.truth[v]), {borderWidth: 3.2, order: 9}));
  const title = n => ({x: 'x forward, m', y: 'y left, m', z: 'z up, m'}[n]);
  // x does not increase along a path, so Chart.js must look at the data itself.
  const o = options(axis(title(h)), axis(title(v), {afterFit: s => { s.width = 58; }}), {parsing: true, normalized: false});
  o.interaction = {mode: 'nearest', axis: 'xy', intersect: false};
  o.plugins.tooltip.callbacks.label = i => ' ' + i.dataset.label + ': ' + h + ' ' + i.parsed.x.toFixed(3) + ' m, ' + v + ' ' + i.parsed.y.toFixed(3) + ' m';
  o.plugins.tooltip.callbacks.title = () => '';
  o.onResize = chart => setTimeout(() => equalAspect(chart, pathBox(h, v)), 0);
  const chart = new Chart(canvas, {type: 'line', data: {datasets}, options: o});
  chart.gaitcamFit = () => equalAspect(chart, pathBox(h, v));
  return chart;
}

const drawers = {
  top: canvas => path(canvas, {horizontal: 'x', vertical: 'y'}),
  side: canvas => path(canvas, {horizontal: data.path.side_axis, vertical: 'z'}),
  error: canvas => overTime(canvas, [
    line('sim3', 'Sim(3)', 'sim3', xy(data.error.t, data.error.sim3)),
    line('se3', 'SE(3)', 'se3', xy(data.error.t, data.error.se3), {borderDash: [5, 4]})], 'position error, m', 'm'),
  rotation: canvas => overTime(canvas, [
    line('own', 'best rotation', 'purple', xy(data.error.t, data.error.own)),
    line('rot', 'aligned positions', 'se3', xy(data.error.t, data.error.rot), {borderDash: [5, 4]})], 'rotation error, °', '°'),
  heading: canvas => overTime(canvas, [
    line('estimate', 'estimate', 'sim3', xy(data.heading.t, data.heading.estimate)),
    line('truth', 'truth', 'truth', xy(data.heading.t, data.heading.truth), {borderWidth: 3.2, order: 9})], 'turned left, °', '°', {beginAtZero: false}),
  blur: canvas => overTime(canvas, [
    line('median', 'median', 'sim3', xy(data.frames.t, data.frames.blur_median)),
    line('p90', '90 %', 'green', xy(data.frames.t, data.frames.blur_p90), {borderWidth: 1.4}),
    line('max', 'largest', 'se3', xy(data.frames.t, data.frames.blur_max), {borderWidth: 1})], 'blur extent, px', 'px'),
  inliers: canvas => overTime(canvas, [
    line('inliers', 'inliers', 'sim3', xy(data.frames.t, data.frames.inliers)),
    line('features', 'features', 'green', xy(data.frames.t, data.frames.features), {borderWidth: 1.2})], 'points per frame', ''),
  gait: canvas => {
    const rows = data.gait.rows.map(row => line(row.name, row.name, row.colour, row.points, {borderWidth: 14, borderCapStyle: 'butt', pointHitRadius: 0}));
    const chart = overTime(canvas, rows, '', '', {min: 0.3, max: 2.7, grid: {display: false, drawBorder: false}, title: {display: false},
      afterBuildTicks: s => { s.ticks = [{value: 1}, {value: 2}]; },
      ticks: {color: css('muted'), font: {size: 11}, callback: v => ({1: 'right', 2: 'left'}[v])}});
    chart.options.plugins.tooltip.enabled = false;
    chart.update('none');
    return chart;
  },
};

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
})();
)js";

}  // namespace

std::string_view ReportStyle() { return kStyle; }
std::string_view ReportScript() { return kScript; }

}  // namespace gaitcam::internal

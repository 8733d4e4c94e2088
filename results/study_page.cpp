#include "results/study_page.h"

namespace gaitcam::internal {
namespace {

constexpr std::string_view kStyle = R"css(
.pill.quiet { color: var(--muted); background: var(--soft); font-weight: 500; }
.effects td, .effects th { padding-right: .5rem; white-space: nowrap; }
.effects td:nth-child(3) { white-space: normal; min-width: 12rem; }
.effects .pill { font-size: .76rem; padding: .05rem .55rem; }
.effects td { font-size: .84rem; }
.more { margin-top: .75rem; }
.note.after { margin-top: 1rem; }
.effects thead th:nth-child(5), .effects thead th:nth-child(6), .effects thead th:nth-child(7), .effects thead th:nth-child(8), .effects thead th:nth-child(10) { text-align: right; }
.effects .within { color: var(--muted); }
td.number.plain { font-weight: 400; }
.effects svg { display: block; }
.effects svg .zero { stroke: var(--muted); opacity: .45; }
.effects svg .bar { stroke-width: 2; }
.effects svg line.good { stroke: var(--good); } .effects svg circle.good { fill: var(--good); }
.effects svg line.bad { stroke: var(--bad); } .effects svg circle.bad { fill: var(--bad); }
.effects svg line.none { stroke: var(--muted); } .effects svg circle.none { fill: var(--muted); }
.grid.halves + .grid.halves { margin-top: .75rem; }
h2 code { font: 600 1.05rem ui-monospace, "SF Mono", Menlo, Consolas, "DejaVu Sans Mono", monospace; }
.map { margin-top: .5rem; width: auto; min-width: 60%; }
.map th, .map td { text-align: center; border: 2px solid var(--card); padding: .35rem .7rem; }
.map tbody th { text-align: right; padding: .35rem .7rem; color: var(--ink); font-weight: 600; font-size: .82rem; }
.map thead th { border: 0; }
.map thead tr:last-child th:first-child { text-align: right; }
.map td { background: color-mix(in srgb, var(--se3) var(--t), var(--card)); font-variant-numeric: tabular-nums; font-weight: 600; border-radius: 5px; }
.map td small { display: block; font-weight: 400; font-size: .7rem; opacity: .8; }
.map td.empty { background: var(--soft); color: var(--muted); font-weight: 400; }
@media print { .effects { font-size: 9px; } }
)css";

constexpr std::string_view kScript = R"js(
(() => {
'use strict';
const {data, css, line, axis, options, start} = gaitcam;
const digits = value => String(+value.toPrecision(3));

// Intervals as bars with caps, in the colour of their series.
const bars = {
  id: 'bars',
  beforeDatasetsDraw(chart) {
    const {ctx, scales: {x, y}} = chart;
    chart.data.datasets.forEach((set, i) => {
      if (!set.bars || !chart.isDatasetVisible(i)) return;
      ctx.save();
      ctx.strokeStyle = set.borderColor; ctx.lineWidth = 1.6;
      for (const p of set.data) {
        if (p.low === null || p.high === null || p.y === null) continue;
        const px = x.getPixelForValue(p.x), low = y.getPixelForValue(p.low), high = y.getPixelForValue(p.high);
        ctx.beginPath();
        ctx.moveTo(px, low); ctx.lineTo(px, high);
        for (const end of [low, high]) { ctx.moveTo(px - 4, end); ctx.lineTo(px + 4, end); }
        ctx.stroke();
      }
      ctx.restore();
    });
  },
};

function scaleY(c, values) {
  const more = {afterFit: s => { s.width = Math.max(s.width, 58); }};
  if (c.ratio) return axis(c.y, Object.assign(more, {beginAtZero: true, max: 1.03, afterBuildTicks: s => { s.ticks = [0, .2, .4, .6, .8, 1].map(value => ({value})); }}));
  if (!c.log) return axis(c.y, Object.assign(more, {beginAtZero: true, suggestedMax: 1.04 * Math.max(...values)}));
  more.type = 'logarithmic';
  more.min = Math.min(...values) / 1.3; more.max = Math.max(...values) * 1.3;
  const y = axis(c.y + ' (logarithmic)', more);
  y.ticks = Object.assign({}, y.ticks, {callback: v => /^[125]/.test(String(+v.toExponential(0)).replace(/^0\.0*/, '')) ? digits(v) : ''});
  return y;
}

function effect(canvas, c) {
  const count = c.series.length, span = c.ticks.length > 1 ? c.ticks[c.ticks.length - 1] - c.ticks[0] : 1;
  const gap = c.numeric ? 0.014 * Math.abs(span) : 0.08, values = [];
  const sets = c.series.map((s, k) => {
    const shift = (k - (count - 1) / 2) * gap;
    const points = s.points.map(p => Object.assign({}, p, {x: p.x + shift}));
    for (const p of points) for (const v of [p.low, p.high]) if (v !== null) values.push(v);
    return line('s' + k, s.name, s.colour, points, {bars: true, pointRadius: 4, pointHoverRadius: 6, borderWidth: 1.2, spanGaps: true});
  });
  const low = Math.min(...c.ticks), high = Math.max(...c.ticks), margin = c.numeric ? 0.06 * (high - low || 1) : 0.5;
  const x = axis(c.x, {min: low - margin, max: high + margin, afterBuildTicks: s => { s.ticks = c.ticks.map(value => ({value})); }});
  x.ticks = Object.assign({}, x.ticks, {autoSkip: c.numeric, callback: v => c.numeric ? digits(v) : (c.labels[v] || '').split(/, | (?=\w+=)/)});
  const o = options(x, scaleY(c, values));
  o.interaction = {mode: 'nearest', axis: 'xy', intersect: false};
  o.plugins.tooltip.callbacks.title = items => items.length ? c.x + ': ' + c.labels[items[0].dataIndex] : '';
  o.plugins.tooltip.callbacks.label = i => ' ' + i.dataset.label + ': ' + digits(i.raw.y) + ' [' + digits(i.raw.low) + ', ' + digits(i.raw.high) + '], n = ' + i.raw.n + ' of ' + i.raw.runs;
  return new Chart(canvas, {type: 'line', data: {datasets: sets}, options: o, plugins: [bars]});
}

function scatter(canvas, c) {
  const sets = [], values = [];
  c.series.forEach((s, k) => {
    for (const p of s.points) values.push(p.y);
    sets.push(line('s' + k, s.name + ', medians', s.colour, s.medians, {pointRadius: 5, pointStyle: 'rectRot', borderWidth: 2, order: 1,
      pointBorderColor: css('card'), pointBorderWidth: 1}));
    sets.push(line('s' + k, s.name, s.colour, s.points, {showLine: false, pointRadius: 3, order: 2, backgroundColor: css(s.colour) + '80', borderColor: css(s.colour) + '80', pointBorderWidth: 0}));
  });
  const o = options(axis(c.x, {beginAtZero: true}), scaleY(c, values));
  o.interaction = {mode: 'nearest', axis: 'xy', intersect: false};
  o.normalized = false;
  o.plugins.tooltip.callbacks.title = () => '';
  o.plugins.tooltip.callbacks.label = i => ' ' + i.dataset.label + ': ' + digits(i.parsed.y) + ' at ' + digits(i.parsed.x) + ' px' + (i.raw.n ? ', n = ' + i.raw.n : '');
  return new Chart(canvas, {type: 'line', data: {datasets: sets}, options: o});
}

const drawers = {};
for (const [id, c] of Object.entries(data.charts)) drawers[id] = canvas => (c.kind === 'effect' ? effect : scatter)(canvas, c);
start(drawers);
})();
)js";

}  // namespace

std::string_view StudyStyle() { return kStyle; }
std::string_view StudyScript() { return kScript; }

}  // namespace gaitcam::internal

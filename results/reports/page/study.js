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
        if (p.low === null || p.high === null || p.y === null || p.x === null) continue;
        const along = set.lying ? x : y, at = set.lying ? y.getPixelForValue(p.y) : x.getPixelForValue(p.x);
        const ends = [along.getPixelForValue(p.low), along.getPixelForValue(p.high)];
        const point = (value, aside) => set.lying ? [value, at + aside] : [at + aside, value];
        ctx.beginPath();
        ctx.moveTo(...point(ends[0], 0)); ctx.lineTo(...point(ends[1], 0));
        for (const end of ends) { ctx.moveTo(...point(end, -4)); ctx.lineTo(...point(end, 4)); }
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

// Words in lines of some 44 characters.
function wrapped(label) {
  const lines = [''];
  for (const word of label.split(' ')) {
    const last = lines[lines.length - 1];
    if (last && last.length + word.length > 44) lines.push(word); else lines[lines.length - 1] = last ? last + ' ' + word : word;
  }
  return lines;
}

// Levels as lines one below the other, for labels that do not fit side by side.
function lyingEffect(canvas, c) {
  const count = c.series.length, values = [];
  const sets = c.series.map((s, k) => {
    const points = s.points.map(p => Object.assign({}, p, {x: p.y, y: p.x + (k - (count - 1) / 2) * 0.6 / count}));
    for (const p of points) for (const v of [p.low, p.high]) if (v !== null) values.push(v);
    return line('s' + k, s.name, s.colour, points, {bars: true, lying: true, showLine: false, pointRadius: 4, pointHoverRadius: 6});
  });
  const x = scaleY(c, values);
  delete x.afterFit;
  const y = axis('', {reverse: true, min: -0.5, max: c.labels.length - 0.5, afterBuildTicks: s => { s.ticks = c.ticks.map(value => ({value})); }});
  y.title.display = false;
  y.ticks = Object.assign({}, y.ticks, {autoSkip: false, callback: v => wrapped(c.labels[v] || '')});
  const o = options(x, y);
  o.interaction = {mode: 'nearest', axis: 'xy', intersect: false};
  o.normalized = false;
  o.plugins.tooltip.callbacks.title = items => items.length ? wrapped(c.labels[items[0].dataIndex]) : '';
  o.plugins.tooltip.callbacks.label = i => intervalText(i, i.raw.x);
  return new Chart(canvas, {type: 'line', data: {datasets: sets}, options: o, plugins: [bars]});
}

const intervalText = (item, value) => ' ' + item.dataset.label + ': ' + digits(value) + ' [' + digits(item.raw.low) + ', ' + digits(item.raw.high) + '], n = ' + item.raw.n + ' of ' + item.raw.runs;

function effect(canvas, c) {
  if (c.lying) return lyingEffect(canvas, c);
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
  o.plugins.tooltip.callbacks.label = i => intervalText(i, i.raw.y);
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
  o.parsing = true;  // else Chart.js takes runs to be sorted by blur, and ends the axis at the last one's
  o.plugins.tooltip.callbacks.title = () => '';
  o.plugins.tooltip.callbacks.label = i => ' ' + i.dataset.label + ': ' + digits(i.parsed.y) + ' at ' + digits(i.parsed.x) + ' px' + (i.raw.n ? ', n = ' + i.raw.n : '');
  return new Chart(canvas, {type: 'line', data: {datasets: sets}, options: o});
}

const drawers = {};
for (const [id, c] of Object.entries(data.charts)) drawers[id] = canvas => (c.kind === 'effect' ? effect : scatter)(canvas, c);
start(drawers);
})();

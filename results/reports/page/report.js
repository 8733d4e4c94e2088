(() => {
'use strict';
const {data, charts, hidden, css, range, xy, line, axis, options, start} = gaitcam;
let hoverTime = null;

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
    ctx.strokeStyle = css('bad'); ctx.globalAlpha = 0.6; ctx.setLineDash([2, 3]); ctx.lineWidth = 1;
    for (const t of data.jumps) {
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

// What would dwarf the rest starts hidden.
hidden.se3 = !!(data.error && data.error.hide_se3);
hidden.rot = !!(data.error && data.error.hide_rot);

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
    if (p.live) datasets.push(line('live', 'live, Sim(3)', 'purple', xy(p.live[h], p.live[v]), {borderWidth: 1.2}));
    datasets.push(line('se3', 'estimate, SE(3)', 'se3', xy(p.se3[h], p.se3[v]), {borderWidth: 1.6, borderDash: [5, 4]}));
  }
  if (p.ellipses && v === 'y') {
    datasets.push(line('ellipses', '95 % by its covariance', 'green', xy(p.ellipses.x, p.ellipses.y), {borderWidth: 1, tension: 0}));
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
    line('sim3', 'final, Sim(3)', 'sim3', xy(data.error.t, data.error.sim3)),
    ...(data.error.live ? [line('live', 'live, Sim(3)', 'purple', xy(data.error.live.t, data.error.live.sim3), {borderWidth: 1.2})] : []),
    line('se3', 'SE(3)', 'se3', xy(data.error.t, data.error.se3), {borderDash: [5, 4]})], 'position error, m', 'm'),
  rotation: canvas => overTime(canvas, [
    line('own', 'best rotation', 'purple', xy(data.error.t, data.error.own)),
    line('rot', 'aligned positions', 'se3', xy(data.error.t, data.error.rot), {borderDash: [5, 4]})], 'rotation error, °', '°'),
  nees: canvas => overTime(canvas, [
    line('nees', 'NEES', 'sim3', xy(data.nees.t, data.nees.nees)),
    line('band', 'band', 'truth', xy(data.nees.t, data.nees.low), {borderDash: [5, 4]}),
    line('band', 'band', 'truth', xy(data.nees.t, data.nees.high), {borderDash: [5, 4]})], 'NEES', ''),
  heading: canvas => overTime(canvas, [
    line('estimate', 'estimate', 'sim3', xy(data.heading.t, data.heading.estimate)),
    line('truth', 'truth', 'truth', xy(data.heading.t, data.heading.truth), {borderWidth: 3.2, order: 9})], 'turned left, °', '°', {beginAtZero: false}),
  blur: canvas => overTime(canvas, [
    line('median', 'median', 'sim3', xy(data.frames.t, data.frames.blur_median)),
    line('p90', '90 %', 'green', xy(data.frames.t, data.frames.blur_p90), {borderWidth: 1.4}),
    line('max', 'largest', 'se3', xy(data.frames.t, data.frames.blur_max), {borderWidth: 1})], 'length of the blur path, px', 'px'),
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

start(drawers);
})();

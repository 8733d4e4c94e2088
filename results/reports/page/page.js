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

(() => {
'use strict';
const {data, css, axis, options, start} = gaitcam;
function bars(canvas, name, title, max) {
  const o = options({type: 'category', labels: data.conditions, grid: {display: false}, ticks: {color: css('muted'), font: {size: 11}}},
    axis(title, {min: 0, max}), {parsing: true, normalized: false});
  o.interaction = {mode: 'index', intersect: false};
  o.plugins.tooltip.callbacks.label = i => ' ' + i.dataset.label + ': ' + (+i.parsed.y.toPrecision(3));
  return new Chart(canvas, {type: 'bar', data: {labels: data.conditions, datasets: data.methods.map(m => ({id: m.name, label: m.name,
    data: m[name], backgroundColor: css(m.colour), borderWidth: 0, categoryPercentage: 0.8, barPercentage: 0.92}))}, options: o});
}
start({found: canvas => bars(canvas, 'found', 'found, %', 100), bearing: canvas => bars(canvas, 'bearing', 'bearing error, \u00b0')});
})();

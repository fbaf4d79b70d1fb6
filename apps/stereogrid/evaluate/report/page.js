// SPDX-License-Identifier: Apache-2.0
// The report: its charts, made of viewer/plot.js, then its parts.

const colour = index => `var(--s${index % 8})`;
const dashes = index => index < 8 ? {} : {'stroke-dasharray': '7 3'};  // when the colours come round again
const shares = [0, 0.2, 0.4, 0.6, 0.8, 1].map(v => [v, v ? v.toFixed(1) : '0']);

/** series: [[bins of {cells, mean_probability, share_occupied}]] */
function reliabilityChart(series) {
  const bars = 62;
  const plot = axes({height: 392, bottom: 36 + bars + 8, x: (a, b) => linear(0, 1, a, b), y: (a, b) => linear(0, 1, a, b),
                     xTicks: [], yTicks: shares, xTitle: 'probability of the grid', yTitle: 'share occupied'});
  const floor = plot.box.bottom + 8 + bars;
  let svg = plot.svg;
  for (const [value, label] of shares) {
    svg += tag('line', {x1: plot.toX(value), x2: plot.toX(value), y1: plot.box.top, y2: plot.box.bottom, stroke: 'var(--grid)'});
    svg += tag('text', {x: plot.toX(value), y: floor + 15, 'text-anchor': 'middle'}, label);
  }
  svg += path([[plot.toX(0), plot.toY(0)], [plot.toX(1), plot.toY(1)]], 'var(--soft)', {'stroke-dasharray': '4 4', 'stroke-width': 1});
  const most = Math.max(10, ...series.flat().map(bin => bin.cells));
  series.forEach((bins, index) => {
    const there = bins.filter(bin => bin.cells > 0);
    const at = bin => [plot.toX(bin.mean_probability), plot.toY(bin.share_occupied)];
    if (there.length) svg += path(there.map(at), colour(index), dashes(index));
    const width = (plot.box.right - plot.box.left) / bins.length;
    bins.forEach((bin, place) => {
      if (!bin.cells) return;
      const tip = title(`${bin.cells} cells, mean p ${bin.mean_probability.toFixed(3)}, occupied ${bin.share_occupied.toFixed(3)}`);
      const [cx, cy] = at(bin);
      svg += tag('circle', {cx, cy, r: 3.5, fill: colour(index)}, tip);
      const height = bars * Math.log10(bin.cells + 1) / Math.log10(most + 1), part = (width - 4) / series.length;
      svg += tag('rect', {x: plot.box.left + place * width + 2 + index * part, y: floor - height, width: part, height,
                          fill: colour(index)}, tip);
    });
  });
  svg += tag('line', {x1: plot.box.left, x2: plot.box.right, y1: floor, y2: floor, stroke: 'var(--line)'});
  return plot.wrap(svg);
}

/** series: [[[false alarms, recall]]]; false alarms on a logarithmic axis. */
function rocChart(series, negatives) {
  const least = 0.001;
  const log = (a, b) => value => linear(Math.log(least), 0, a, b)(Math.log(Math.max(value, least)));
  const plot = axes({x: log, y: (a, b) => linear(0, 1, a, b), yTicks: shares, xTitle: `false alarms among ${negatives}`,
                     xTicks: [[0.001, '0.1 %'], [0.01, '1 %'], [0.1, '10 %'], [1, '100 %']], yTitle: 'found'});
  let svg = plot.svg + path([[plot.toX(0.01), plot.toY(0)], [plot.toX(0.01), plot.toY(1)]], 'var(--soft)',
                            {'stroke-dasharray': '4 4', 'stroke-width': 1});
  series.forEach((points, index) => {
    if (points.length) svg += path(points.map(([alarms, found]) => [plot.toX(alarms), plot.toY(found)]), colour(index), dashes(index));
  });
  if (!series.some(points => points.length)) {
    svg += tag('text', {x: 290, y: 150, 'text-anchor': 'middle'}, 'no such cells in this range');
  }
  return plot.wrap(svg);
}

/** series: [{from_m, step_m, columns: [count]}] as shares. */
function depthChart(series) {
  const {from_m: from, step_m: step} = series[0], bins = series[0].columns.length;
  const part = series.map(({columns}) => {
    const all = columns.reduce((a, b) => a + b, 0);
    return columns.map(count => all ? count / all : 0);
  });
  const root = value => Math.sqrt(value);  // rare but dangerous errors have to be seen
  const most = Math.max(0.1, ...part.flat());
  const yTicks = [0.01, 0.1, 0.25, 0.5, 1].filter(v => v <= most * 1.05).map(v => [v, `${Math.round(v * 100)} %`]);
  const xTicks = [-10, -5, 0, 5, 10].map(v => [v, Math.abs(v) === 10 ? `${v < 0 ? '≤ −' : '≥ '}10` : String(v).replace('-', '−')]);
  const plot = axes({height: 392, left: 60, right: 30, x: (a, b) => linear(from, -from, a, b), xTicks, yTicks, xTitle: 'found − true, m',
                     y: (a, b) => value => linear(0, root(most), a, b)(root(value)), yTitle: 'columns (root scale)'});
  let svg = plot.svg + path([[plot.toX(0), plot.box.top], [plot.toX(0), plot.box.bottom]], 'var(--soft)', {'stroke-width': 1});
  part.forEach((values, index) => {
    const points = values.flatMap((v, i) => [[plot.toX(from + i * step), plot.toY(v)], [plot.toX(from + (i + 1) * step), plot.toY(v)]]);
    const closed = [[plot.toX(from), plot.toY(0)], ...points, [plot.toX(from + bins * step), plot.toY(0)]];
    svg += path(closed, 'none', {fill: colour(index), 'fill-opacity': 0.14 / Math.max(1, series.length / 2)}) + path(points, colour(index), {'stroke-width': 1.7, ...dashes(index)});
  });
  return plot.wrap(svg);
}

/** series: [{name, frames: [{name, balanced_log_loss}]}], a row of bars each. */
function frameChart(series) {
  const width = 1110, row = series.length > 3 ? 44 : 74, left = 46, gap = 40, height = series.length * (row + gap) + 4;
  const losses = series.flatMap(({frames}) => frames.map(frame => frame.balanced_log_loss ?? 0));
  const most = Math.max(0.1, ...losses);
  let svg = '';
  series.forEach(({name, frames}, index) => {
    const top = index * (row + gap) + gap - 8, bottom = top + row, step = (width - left) / frames.length;
    const values = frames.map(frame => frame.balanced_log_loss).filter(value => value !== null).sort((a, b) => b - a);
    const limit = values[Math.max(0, Math.ceil(values.length / 10) - 1)];
    svg += tag('text', {x: left, y: top - 19}, escaped(name));
    for (const tick of [0, most / 2]) {
      const y = linear(0, most, bottom, top)(tick);
      svg += tag('line', {x1: left, x2: width, y1: y, y2: y, stroke: 'var(--grid)'});
      svg += tag('text', {x: left - 6, y: y + 4, 'text-anchor': 'end'}, tick.toFixed(2));
    }
    const bad = [];
    frames.forEach(({name: frame, balanced_log_loss: loss}, place) => {
      if (loss === null) return;
      const bar = Math.max(1, row * loss / most), worst = values.length > 1 && loss >= limit, x = left + place * step;
      svg += tag('rect', {x: x + step * 0.1, y: bottom - bar, width: step * 0.8, height: bar, rx: Math.min(2, step / 6),
                          fill: worst ? 'var(--bad)' : colour(index), 'fill-opacity': worst ? 1 : 0.75},
                 title(`${frame}: ${loss.toFixed(3)}`));
      if (worst) bad.push({frame, loss, x: Math.min(x + step / 2, width - 22), y: bottom - bar - 3});
    });
    const named = [];  // the worst first; the others where there is room
    for (const {frame, x, y} of bad.sort((a, b) => b.loss - a.loss)) {
      if (named.some(other => Math.abs(other - x) < 46)) continue;
      named.push(x);
      svg += tag('text', {x, y, class: 'strong', 'text-anchor': 'middle'}, escaped(frame));
    }
  });
  return `<svg viewBox="0 0 ${width} ${height}" role="img">${svg}</svg>`;
}

const data = JSON.parse(document.getElementById('data').textContent);
const names = Object.keys(data.series);
const put = (id, html) => { document.getElementById(id).innerHTML = html; };
const cells = (band, metric) => names.map(name => data.series[name].bands[band][metric]);
const swatch = index => `<span class="swatch${index < 8 ? '' : ' dashed'}" style="--c:${colour(index)}"></span>`;
const digits = value => value === null || value === undefined ? '–' : value.toFixed(3).replace('-', '−');
const range = band => band.replace(/(\d+)-(\d+)/, '$1–$2 m');
const explained = {
  balanced_log_loss: 'surprise at the truth, occupied and free weighing the same',
  auc: 'an occupied cell is rated above a free one',
  iou_occupied: 'overlap of what is occupied and what has p > 0.55',
  missed: 'occupied cells with p < 0.45',
  known: 'cells with |p − 0.5| > 0.05',
  calibration_error: 'distance between what the grid says and what is',
  hidden_recall: 'partly hidden cells found at 1 % false alarms',
  depth_error_m: 'mean error of free space along image columns, m',
};

/** A bar of the interval with a dot at the value, on a scale that all series share. */
function interval(estimates, index) {
  const known = estimates.flatMap(e => [e.low, e.value, e.high]).filter(v => v !== null);
  const from = Math.min(...known), to = Math.max(...known), at = linear(from, to === from ? from + 1 : to, 8, 132);
  const {value, low, high} = estimates[index];
  if (value === null) return '';
  const bar = low === null || high === null ? '' :
    tag('line', {x1: at(low), x2: at(high), y1: 7, y2: 7, stroke: colour(index), 'stroke-width': 4, 'stroke-opacity': 0.35, 'stroke-linecap': 'round'});
  return `<svg viewBox="0 0 140 14">${bar}${tag('circle', {cx: at(value), cy: 7, r: 4, fill: colour(index)})}${title(`${digits(low)} to ${digits(high)}`)}</svg>`;
}

function card(band, metric) {
  const estimates = cells(band, metric.name);
  const rows = estimates.map((e, index) =>
    `<div class="row" style="--c:${colour(index)}" title="${escaped(names[index])}"><b>${digits(e.value)}</b>${
      names.length > 2 ? `<i>${escaped(names[index])}</i>` : ''}${interval(estimates, index)}</div>`);
  return `<div class="card"><h3>${escaped(metric.title)}</h3><p>${explained[metric.name]}</p>${rows.join('')}</div>`;
}

function best(metric, estimates) {
  const sign = metric.better === 'higher' ? -1 : 1;
  const rank = estimates.map(e => e.value === null ? Infinity : metric.better === 'zero' ? Math.abs(e.value) : sign * e.value);
  return Math.min(...rank) === Infinity || rank.length < 2 ? -1 : rank.indexOf(Math.min(...rank));
}

function table(band) {
  const b = data.series[names[0]].bands[band], n = count => count.toLocaleString('en').replaceAll(',', '\u202f');
  const counts = `${b.frames} frames, ${n(b.cells)} cells, ${n(b.occupied)} of them occupied; partly hidden: ${n(b.hidden_occupied)} occupied and ${
    n(b.hidden_free)} free; ${n(b.columns)} image columns that end in an obstacle`;
  const row = metric => {
    const estimates = cells(band, metric.name), winner = best(metric, estimates);
    return `<tr><td>${escaped(metric.title)}</td>${estimates.map((e, i) => `<td class="${i === winner ? 'best' : ''}">${digits(e.value)}${
      e.low === null ? '' : ` <small>${digits(e.low)} – ${digits(e.high)}</small>`}</td>`).join('')}</tr>`;
  };
  const group = (text, metrics) => `<tr class="group"><td colspan="${names.length + 1}">${text}</td></tr>${metrics.map(row).join('')}`;
  const of = prefix => data.metrics.filter(metric => metric.name.startsWith(prefix));
  return `<p class="counts">${counts}</p><div class="scroll"><table><thead><tr><th>${range(band)}</th>${names.map((name, i) => `<th>${swatch(i)}${escaped(name)}</th>`).join('')}</tr></thead>
    <tbody>${group('cells', data.metrics.filter(m => !/^(hidden|depth)/.test(m.name)))}${group('partly hidden cells', of('hidden'))}
    ${group('free space along image columns', of('depth'))}</tbody></table></div>`;
}

/** The figures of the cards for every series and range. */
function overview(filled) {
  const shown = data.metrics.filter(metric => explained[metric.name]);
  const row = (name, index, band) => `<tr><td>${swatch(index)}${escaped(name)}, ${range(band)}</td>${
    shown.map(metric => `<td>${digits(data.series[name].bands[band][metric.name].value)}</td>`).join('')}</tr>`;
  return `<div class="scroll"><table><thead><tr><th></th>${shown.map(metric => `<th>${escaped(metric.title)}</th>`).join('')}</tr></thead>
    <tbody>${names.map((name, index) => filled.map(band => row(name, index, band)).join('')).join('')}</tbody></table></div>`;
}

// Figures are declared in evaluate/figures.hpp: title with its unit, value with its whole.
const label = figure => escaped(figure.title + (figure.unit ? `, ${figure.unit}` : ''));
const of = (whole, unit = '') => ` <small>${unit ? `(${whole})` : `of ${whole}`}</small>`;
const shown = (figure, values) => (figure.is_count ? values[figure.name] ?? '–' : digits(values[figure.name])) +
  (figure.whole ? of(values[figure.whole], figure.unit) : '');

/** Figures of a group for the series that have it. */
function grouped(key, title) {
  const having = names.filter(name => data.series[name][key]);
  if (!having.length) return '';
  const row = figure => `<tr><td>${label(figure)}</td>${having.map(n => `<td>${shown(figure, data.series[n][key])}</td>`).join('')}</tr>`;
  return `<h2>${title}</h2><div class="scroll"><table><thead><tr><th></th>${having.map(n => `<th>${swatch(names.indexOf(n))}${escaped(n)}</th>`).join('')}</tr></thead>
    <tbody>${data.figures[key].map(row).join('')}</tbody></table></div>`;
}

/** Scores of obstacles; empty if they were not scored. */
function obstacles() {
  const o = data.obstacles;
  if (!o) return '';
  const kinds = Object.entries(o.by_kind).map(([kind, k]) => [`${escaped(kind)} with an obstacle of its own`, digits(k.separate) + of(k.things)]);
  const lines = (figures, values) => figures.map(figure => [label(figure), shown(figure, values)]);
  const groups = [['things, 3–20 m ahead, from 1 s on', [...lines(data.figures.things, o), ...kinds]],
                  ['followed', lines(data.figures.tracking, o.tracking)],
                  [`matched, medians of ${o.errors.matches}`, lines(data.figures.errors, o.errors)]];
  const rows = groups.map(([text, inner]) => `<tr class="group"><td colspan="2">${text}</td></tr>${
    inner.map(([name, value]) => `<tr><td>${name}</td><td>${value}</td></tr>`).join('')}`);
  return `<h2>Obstacles</h2><div class="scroll"><table><tbody>${rows.join('')}</tbody></table></div>`;
}

function show(band) {
  for (const button of document.querySelectorAll('#bands button')) button.setAttribute('aria-pressed', button.dataset.band === band);
  put('cards', data.metrics.filter(metric => explained[metric.name]).map(metric => card(band, metric)).join(''));
  put('frames', frameChart(names.map(name => ({name, frames: data.series[name].frames[band]}))));
  put('reliability', reliabilityChart(cells(band, 'reliability')));
  put('depth', depthChart(cells(band, 'depth_errors')));
  put('roc', rocChart(cells(band, 'roc'), 'free cells'));
  put('roc_hidden', rocChart(cells(band, 'roc_hidden'), 'free cells'));
  put('table', table(band));
}

put('about', Object.entries(data.about).map(([key, text]) => `<div><dt>${escaped(key)}</dt><dd>${escaped(text)}</dd></div>`).join(''));
put('obstacles', obstacles());
if (names.length) {
  const bands = Object.keys(data.series[names[0]].bands);
  const filled = bands.filter(band => data.series[names[0]].bands[band].cells > 0);
  put('bands', bands.map(band => `<button data-band="${band}">${range(band)}</button>`).join(''));
  put('legend', names.map((name, index) => `<span>${swatch(index)}${escaped(name)}</span>`).join(''));
  put('motion', grouped('motion', 'Motion') + grouped('witness', 'Free cells by witness'));
  put('overview', overview(filled));
  document.getElementById('bands').addEventListener('click', event => { if (event.target.dataset.band) show(event.target.dataset.band); });
  show(filled.includes('3-20') ? '3-20' : filled[0] ?? bands[0]);
} else {  // nothing is known of the cells
  for (const id of ['plots', 'ranges', 'figures']) put(id, '');
}

// SPDX-License-Identifier: Apache-2.0

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

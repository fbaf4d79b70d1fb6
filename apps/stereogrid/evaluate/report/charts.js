// SPDX-License-Identifier: Apache-2.0
// The charts of a report, made of viewer/plot.js.

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

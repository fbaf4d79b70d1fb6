// SPDX-License-Identifier: Apache-2.0
// Parts of charts as SVG text, for the page and for reports of `evaluate`. Colours are CSS variables of theme.css.

export const escaped = text => String(text).replace(/[&<>"]/g, c => ({'&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;'})[c]);
export const tag = (name, attributes, content = '') =>
  `<${name} ${Object.entries(attributes).map(([key, value]) => `${key}="${value}"`).join(' ')}>${content}</${name}>`;
export const title = text => tag('title', {}, escaped(text));
export const linear = (from, to, start, end) => value => start + (value - from) / (to - from) * (end - start);

/** A frame with axes; x and y map values to pixels. */
export function axes({width = 540, height = 330, left = 50, right = 24, top = 10, bottom = 36, x, y, xTicks, yTicks,
                      xTitle = '', yTitle = ''}) {
  const box = {left, top, right: width - right, bottom: height - bottom};
  const toX = x(box.left, box.right), toY = y(box.bottom, box.top);
  let svg = '';
  for (const [value, label] of xTicks) {
    svg += tag('line', {x1: toX(value), x2: toX(value), y1: box.top, y2: box.bottom, stroke: 'var(--grid)'});
    svg += tag('text', {x: toX(value), y: box.bottom + 15, 'text-anchor': 'middle'}, label);
  }
  for (const [value, label] of yTicks) {
    svg += tag('line', {x1: box.left, x2: box.right, y1: toY(value), y2: toY(value), stroke: 'var(--grid)'});
    svg += tag('text', {x: box.left - 6, y: toY(value) + 4, 'text-anchor': 'end'}, label);
  }
  svg += tag('text', {x: (box.left + box.right) / 2, y: height - 4, 'text-anchor': 'middle'}, xTitle);
  svg += tag('text', {transform: `translate(12 ${(box.top + box.bottom) / 2}) rotate(-90)`, 'text-anchor': 'middle'}, yTitle);
  return {svg, toX, toY, box, wrap: content => `<svg viewBox="0 0 ${width} ${height}" role="img">${content}</svg>`};
}

export const path = (points, stroke, extra = {}) =>
  tag('path', {d: 'M' + points.map(p => p.map(v => v.toFixed(1)).join(' ')).join('L'), fill: 'none', stroke, 'stroke-width': 2,
               'stroke-linejoin': 'round', ...extra});

// SPDX-License-Identifier: Apache-2.0

function part(name, text = '') {
  const made = document.createElement('span');
  made.className = name;
  made.textContent = text;
  return made;
}

/** Shows the scale of a layer (legendOf of layers.js) in an element. */
export function showLegend(into, { stops, wheel, labels = [], kinds = [] }) {
  const parts = [];
  if (stops) {
    const bar = part('bar');
    bar.style.background = `linear-gradient(to right, ${stops.join(', ')})`;
    const scale = part('scale');
    const row = part('labels');
    row.append(...labels.map((label) => part('label', label)));
    scale.append(bar, row);
    parts.push(scale);
  }
  if (wheel) { // conic gradients run clockwise
    const disc = part('wheel');
    disc.style.background = `conic-gradient(${[...wheel].reverse().join(', ')})`;
    parts.push(disc, ...labels.map((label) => part('label', label)));
  }
  for (const [colour, text] of kinds) {
    const swatch = part('swatch');
    swatch.style.background = colour;
    const kind = part('kind');
    kind.append(swatch, text);
    parts.push(kind);
  }
  into.replaceChildren(...parts);
}

/** Turns the wheel of directions as the grid is turned: the vehicle heads up. */
export function turnLegend(legend, yaw) {
  const wheel = legend.querySelector('.wheel');
  if (wheel) wheel.style.transform = `rotate(${yaw}rad)`;
}

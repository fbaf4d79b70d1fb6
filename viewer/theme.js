// SPDX-License-Identifier: Apache-2.0

const dark = window.matchMedia('(prefers-color-scheme: dark)');

/** A colour of style.css, such as "--accent". */
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** The same as [red, green, blue]; colours of the style sheet have six digits. */
export function rgb(name) {
  const number = parseInt(colour(name).slice(1), 16);
  return [number >> 16, (number >> 8) & 255, number & 255];
}

export const isDark = () => dark.matches;

/** What `make` makes of the theme's colours: once for each theme. */
export function perTheme(make) {
  const made = new Map();
  return () => {
    if (!made.has(isDark())) made.set(isDark(), make());
    return made.get(isDark());
  };
}

/** Calls `then` when the system turns dark or light. */
export const onThemeChange = (then) => dark.addEventListener('change', then);

/** Makes a canvas as fine as the screen; returns its context, scaled to CSS pixels, and its size in those. */
export function fitCanvas(canvas) {
  const { width, height } = canvas.getBoundingClientRect();
  const ratio = window.devicePixelRatio || 1;
  const wide = Math.max(1, Math.round(width * ratio));
  const high = Math.max(1, Math.round(height * ratio));
  if (canvas.width !== wide || canvas.height !== high) Object.assign(canvas, { width: wide, height: high });
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

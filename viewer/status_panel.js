// SPDX-License-Identifier: Apache-2.0
import { axes, linear, path, tag } from './plot.js';

const kept = 600; // frames in the chart
const stages = ['odometry', 'match', 'ground', 'count', 'project', 'filter', 'flow', 'track'];

/** Milliseconds of each stage as bars, whole frames and latency over time, frames per second and dropped ones. */
export class StatusPanel {
  #history = []; // {stamp, total, latency}, in the order of stamps
  #stamp = 0;
  #arrivals = [];

  constructor(elements) {
    this.elements = elements;
    new ResizeObserver(() => this.redraw()).observe(elements.chart);
  }

  /** A diagnostic_msgs/DiagnosticArray of the topic "status". */
  show(message, stamp) {
    const values = Object.fromEntries(message.status[0].values.map(({ key, value }) => [key, value]));
    this.#arrivals.push(performance.now());
    this.#stamp = stamp;
    this.#remember({ stamp, total: Number(values.total_ms), latency: Number(values.latency_ms ?? NaN) });
    this.#showStages(values);
    const { message: state, dropped, obstacles, latency, speedLimit } = this.elements;
    state.textContent = message.status[0].message;
    dropped.textContent = values.dropped;
    obstacles.textContent = values.obstacles;
    const [median, p99] = [values.latency_median_ms, values.latency_p99_ms].map((ms) => Number(ms).toFixed(0));
    latency.textContent = values.latency_median_ms === undefined ? '–' : `${median} (99 %: ${p99})`;
    const limit = values.speed_limit_mps;
    speedLimit.textContent = limit === undefined ? '–' : `${Number(limit).toFixed(1)} (${values.speed_limit_reason})`;
    this.redraw();
  }

  /** Before another server, whose stamps may be far away. */
  reset() {
    this.#history = [];
    this.redraw();
  }

  /** To be called now and then. */
  showRate() {
    const now = performance.now();
    this.#arrivals = this.#arrivals.filter((at) => now - at < 2000);
    this.elements.rate.textContent = (this.#arrivals.length / 2).toFixed(1);
  }

  #remember(entry) {
    const at = this.#history.findIndex((one) => one.stamp >= entry.stamp);
    if (at < 0) this.#history.push(entry);
    else this.#history.splice(at, this.#history[at].stamp === entry.stamp ? 1 : 0, entry);
    if (this.#history.length > kept) this.#history.shift();
  }

  #showStages(values) {
    const times = stages.map((stage) => Number(values[`${stage}_ms`] ?? 0));
    const most = Math.max(...times, 1e-3);
    const { stageList } = this.elements;
    if (stageList.children.length === 0) {
      stageList.innerHTML = stages.map((stage) => `<div><dt>${stage}</dt><dd><i></i><b></b></dd></div>`).join('');
    }
    stages.forEach((_, i) => {
      stageList.children[i].querySelector('i').style.width = `${(70 * times[i]) / most}%`;
      stageList.children[i].querySelector('b').textContent = times[i].toFixed(1);
    });
  }

  redraw() {
    const { chart } = this.elements;
    const { width, height } = chart.getBoundingClientRect();
    const history = this.#history;
    chart.innerHTML = '';
    if (history.length === 0) return;
    const first = history[0].stamp;
    const span = Math.max(1e-3, history.at(-1).stamp - first);
    const end = `${span.toFixed(1)} s`;
    const numbers = history.flatMap(({ total, latency }) => [total, latency]).filter(Number.isFinite);
    const most = Math.max(1, ...numbers);
    const { svg, toX, toY, box, wrap } = axes({
      width, height, left: 34, right: 20, top: 8, bottom: 18,
      x: (from, to) => linear(0, span, from, to), xTicks: [[0, '0 s'], [span, end]],
      y: (from, to) => linear(0, 1.1 * most, from, to), yTicks: [0, 0.5, 1].map((share) => [most * share, (most * share).toFixed(0)]),
    });
    const now = toX(this.#stamp - first);
    const line = (of, stroke) => {
      const known = history.filter((one) => Number.isFinite(one[of]));
      if (known.length === 0) return '';
      const current = known.find(({ stamp }) => stamp === this.#stamp);
      return path(known.map((one) => [toX(one.stamp - first), toY(one[of])]), stroke, { 'stroke-width': 1.5 }) +
        (current ? tag('circle', { cx: now, cy: toY(current[of]), r: 3, fill: stroke }) : '');
    };
    chart.innerHTML = wrap(svg + line('total', 'var(--accent)') + line('latency', 'var(--obstacle-moving)') +
      tag('line', { x1: now, x2: now, y1: box.top, y2: box.bottom, stroke: 'var(--soft)' }));
    chart.setAttribute('aria-label', `Milliseconds per frame over ${end}: at most ${most.toFixed(0)}`);
  }
}

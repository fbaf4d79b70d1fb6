// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
import { colour, fitCanvas } from './theme.js';

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
    const { message: state, dropped, obstacles, latency } = this.elements;
    state.textContent = message.status[0].message;
    dropped.textContent = values.dropped;
    obstacles.textContent = values.obstacles;
    const [median, p99] = [values.latency_median_ms, values.latency_p99_ms].map((ms) => Number(ms).toFixed(0));
    latency.textContent = values.latency_median_ms === undefined ? '–' : `${median} (99 %: ${p99})`;
    this.redraw();
  }

  /** Before another server, whose stamps may be far away. */
  forget() {
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
    const { context, width, height } = fitCanvas(chart);
    const history = this.#history;
    if (history.length === 0) return;
    const [left, top, bottom] = [34, 8, 18];
    const first = history[0].stamp;
    const span = Math.max(1e-3, history.at(-1).stamp - first);
    const numbers = history.flatMap(({ total, latency }) => [total, latency]).filter(Number.isFinite);
    const most = Math.max(1, ...numbers) * 1.1;
    const x = (stamp) => left + ((width - left - 6) * (stamp - first)) / span;
    const y = (ms) => height - bottom - ((height - top - bottom) * ms) / most;
    context.font = '11px system-ui, sans-serif';
    context.fillStyle = colour('--soft');
    context.strokeStyle = colour('--line');
    for (const share of [0, 0.5, 1]) {
      const ms = (most / 1.1) * share;
      context.fillText(ms.toFixed(0), 2, y(ms) + 4);
      context.beginPath();
      context.moveTo(left, y(ms));
      context.lineTo(width, y(ms));
      context.stroke();
    }
    context.fillText('0 s', left, height - 4);
    const end = `${span.toFixed(1)} s`;
    context.fillText(end, width - context.measureText(end).width - 4, height - 4);
    this.#line(context, '--accent', (one) => [x(one.stamp), y(one.total)]);
    this.#line(context, '--obstacle-moving', (one) => [x(one.stamp), y(one.latency)]);
    context.fillStyle = colour('--soft');
    context.fillRect(x(this.#stamp) - 0.5, top, 1, height - top - bottom);
    chart.setAttribute('aria-label', `Milliseconds per frame over ${end}: at most ${Math.max(...numbers).toFixed(0)}`);
  }

  #line(context, name, place) {
    context.strokeStyle = context.fillStyle = colour(name);
    context.lineWidth = 1.5;
    context.beginPath();
    for (const one of this.#history) {
      const [x, y] = place(one);
      if (!Number.isFinite(y)) continue;
      context.lineTo(x, y);
      if (one.stamp === this.#stamp) context.fillRect(x - 2.5, y - 2.5, 5, 5);
    }
    context.stroke();
    context.lineWidth = 1;
  }
}

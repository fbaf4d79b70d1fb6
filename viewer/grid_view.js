// SPDX-License-Identifier: Apache-2.0
import { Path } from './grid_tools.js';
import { colour, fitCanvas } from './theme.js';

const margin = 0.56;
const emptyLayer = { corner: [0, -20], resolution: 1, width: 40, height: 40, frame: '' };
// m, around the camera, on grids of 20 m and larger; smaller grids have a smaller vehicle
const vehicle = [[3.6, 0], [3.2, 0.9], [-0.9, 0.9], [-0.9, -0.9], [3.2, -0.9]];

/**
 * The grid from above, the vehicle heading up, with obstacles. Moved and zoomed with mouse, touch and keys. Calls
 * `onPoint(text)` with a description of the cell under the pointer, `onHover(id | null)` and `onPick(id)` with obstacles.
 */
export class GridView {
  #bitmap = document.createElement('canvas');
  #pointers = new Map();
  #scheduled = false;
  #isPlaced = false;
  #layerOf = null;
  #ruler = null; // from and to, in vehicle coordinates
  layer = null;
  path = new Path();
  measures = false; // a drag draws the ruler instead of moving the grid
  obstacles = [];
  pose = [0, 0, 0];
  worldFrame = 'odom';
  highlighted = null;
  views = []; // places and fields of view of several cameras (viewOf)
  linked = []; // grids that are moved and zoomed with this one

  constructor(canvas, { onPoint, onHover, onPick }) {
    Object.assign(this, { canvas, onPoint, onHover, onPick });
    this.home();
    canvas.addEventListener('pointerdown', (event) => this.#press(event));
    canvas.addEventListener('pointermove', (event) => this.#move(event));
    for (const type of ['pointerup', 'pointercancel']) {
      canvas.addEventListener(type, (event) => this.#pointers.delete(event.pointerId));
    }
    canvas.addEventListener('pointerleave', () => { onPoint(''); onHover(null); });
    canvas.addEventListener('click', (event) => onPick(this.#obstacleAt(this.#vehiclePoint(event))));
    canvas.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener('keydown', (event) => this.#key(event));
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  /** Shows the whole layer, or the largest one of the linked grids. */
  home() {
    const extent = ({ resolution, width, height }) => resolution * Math.max(width, height);
    const layers = [this, ...this.linked].map(({ layer }) => layer).filter(Boolean).sort((a, b) => extent(b) - extent(a));
    const { corner, resolution, width, height, frame } = layers[0] ?? emptyLayer;
    const size = [width * resolution, height * resolution];
    const middle = corner.map((value, i) => value + size[i] / 2);
    this.centre = frame === this.worldFrame ? this.#inVehicle(middle) : middle; // m ahead, m to the left
    this.metres = margin * Math.max(...size); // from the middle to the nearer edge, at zoom 1
    this.zoom = 1;
    this.#share();
  }

  /** Shows the part of the world that is shown here in the linked grids, too. */
  #share() {
    const { centre, metres, zoom } = this;
    for (const view of [this, ...this.linked]) {
      Object.assign(view, { centre, metres, zoom });
      view.redraw();
    }
  }

  /** `layerOf()`: the layer; requested when it is drawn, so that hidden layers cost nothing. */
  show(layerOf) {
    this.#layerOf = layerOf;
    this.redraw();
  }

  #takeLayer() {
    const isFirst = !this.layer;
    this.layer = this.#layerOf();
    this.#layerOf = null;
    const { width, height, pixels } = this.layer;
    if (this.#bitmap.width !== width || this.#bitmap.height !== height) Object.assign(this.#bitmap, { width, height });
    this.#bitmap.getContext('2d').putImageData(pixels, 0, 0);
    if (isFirst) this.home();
  }

  /** The vehicle's pose in the frame of the world. */
  place(pose, worldFrame, stamp) {
    Object.assign(this, { pose, worldFrame });
    this.path.add(stamp, pose);
    if (!this.#isPlaced) this.home();
    this.#isPlaced = true;
  }

  redraw() {
    if (this.#scheduled) return;
    this.#scheduled = true;
    requestAnimationFrame(() => {
      this.#scheduled = false;
      this.#draw();
    });
  }

  #scale(width, height) {
    return (this.zoom * Math.min(width, height)) / (2 * this.metres);
  }

  /** From vehicle coordinates: x up, y to the left. */
  #enter(context, width, height) {
    const scale = this.#scale(width, height);
    context.translate(width / 2, height / 2);
    context.transform(0, -scale, -scale, 0, scale * this.centre[1], scale * this.centre[0]);
  }

  #enterWorld(context) {
    context.rotate(-this.pose[2]);
    context.translate(-this.pose[0], -this.pose[1]);
  }

  #draw() {
    if (this.#layerOf) this.#takeLayer();
    const { context, width, height } = fitCanvas(this.canvas);
    context.fillStyle = colour('--cell-unknown');
    context.fillRect(0, 0, width, height);
    this.#enter(context, width, height);
    if (this.layer) this.#drawLayer(context);
    this.#drawRings(context, this.#scale(width, height));
    context.save();
    this.#enterWorld(context);
    this.#drawPath(context, this.#scale(width, height));
    for (const obstacle of this.obstacles) this.#drawObstacle(context, obstacle, this.#scale(width, height));
    context.restore();
    this.#drawVehicle(context, this.#scale(width, height));
    for (const view of this.views) this.#drawView(context, view, this.#scale(width, height));
    if (this.#ruler) this.#drawRuler(context, this.#scale(width, height));
  }

  #drawPath(context, scale) {
    context.strokeStyle = colour('--accent');
    context.lineWidth = 1.5 / scale;
    context.setLineDash([4 / scale, 4 / scale]);
    context.beginPath();
    this.path.trace(context);
    context.stroke();
    context.setLineDash([]);
  }

  #drawRuler(context, scale) {
    const [from, to] = this.#ruler;
    context.strokeStyle = colour('--highlight');
    context.lineWidth = 2 / scale;
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(...to);
    context.stroke();
    this.#write(context, to, scale, `${Math.hypot(to[0] - from[0], to[1] - from[1]).toFixed(2)} m`);
  }

  /** Letters at a point, upright, with a halo over light and dark cells alike. */
  #write(context, point, scale, text) {
    context.save();
    context.translate(...point);
    context.transform(0, -1 / scale, -1 / scale, 0, 0, 0);
    context.font = '12px system-ui, sans-serif';
    context.lineWidth = 3;
    context.strokeStyle = colour('--cell-unknown');
    context.fillStyle = colour('--cell-ink');
    context.strokeText(text, 3, -3);
    context.fillText(text, 3, -3);
    context.restore();
  }

  /** A dot where a camera is, its name, and the sides of its field of view. */
  #drawView(context, { name, x, y, right, left }, scale) {
    const length = this.#ringStep() / 3;
    const middle = (right + left) / 2;
    context.strokeStyle = context.fillStyle = colour('--accent');
    context.lineWidth = 1.5 / scale;
    context.beginPath();
    context.moveTo(x, y);
    context.arc(x, y, length, right, left);
    context.closePath();
    context.stroke();
    this.#drawDot(context, x, y, scale);
    this.#write(context, [x + length * Math.cos(middle), y + length * Math.sin(middle)], scale, name);
  }

  #drawDot(context, x, y, scale) {
    context.beginPath();
    context.arc(x, y, 3.5 / scale, 0, 2 * Math.PI);
    context.fill();
  }

  /** Outline, so that the cells under it are visible, and a dot where the camera is. */
  #drawVehicle(context, scale) {
    const share = Math.min(1, this.metres / (margin * 20));
    context.strokeStyle = context.fillStyle = colour('--accent');
    context.lineWidth = 2 / scale;
    context.beginPath();
    for (const [x, y] of vehicle) context.lineTo(share * x, share * y);
    context.closePath();
    context.stroke();
    if (this.views.length === 0) this.#drawDot(context, 0, 0, scale);
  }

  #drawLayer(context) {
    const { corner, resolution, width, height, frame } = this.layer;
    context.save();
    if (frame === this.worldFrame) this.#enterWorld(context);
    context.imageSmoothingEnabled = false;
    context.drawImage(this.#bitmap, corner[0], corner[1], width * resolution, height * resolution);
    context.restore();
  }

  #ringStep() {
    return this.metres < 6 ? 2 : 10;
  }

  /** Ahead; all around with several cameras. */
  #drawRings(context, scale) {
    const step = this.#ringStep();
    const side = this.views.length > 0 ? Math.PI : 1.2;
    for (let radius = step; radius <= 6 * step; radius += step) {
      context.strokeStyle = colour('--ring');
      context.lineWidth = 1 / scale;
      context.beginPath();
      context.arc(0, 0, radius, -side, side);
      context.stroke();
      this.#write(context, [radius, 0], scale, `${radius} m`);
    }
  }

  #drawObstacle(context, { id, kind, outline, position, velocity }, scale) {
    const strong = id === this.highlighted;
    context.strokeStyle = colour(strong ? '--highlight' : `--obstacle-${kind}`);
    context.lineWidth = (strong ? 4 : 2) / scale;
    context.beginPath();
    for (const { x, y } of outline) context.lineTo(x, y);
    if (kind === 'moving' && position) { // predicted position in a second
      context.moveTo(position.x, position.y);
      context.lineTo(position.x + velocity.x, position.y + velocity.y);
    }
    context.stroke();
  }

  #vehiclePoint({ offsetX, offsetY }) {
    const { width, height } = this.canvas.getBoundingClientRect();
    const scale = this.#scale(width, height);
    return [this.centre[0] - (offsetY - height / 2) / scale, this.centre[1] - (offsetX - width / 2) / scale];
  }

  #worldPoint([x, y]) {
    const [c, s] = [Math.cos(this.pose[2]), Math.sin(this.pose[2])];
    return [this.pose[0] + c * x - s * y, this.pose[1] + s * x + c * y];
  }

  #inVehicle([x, y]) {
    const [c, s] = [Math.cos(this.pose[2]), Math.sin(this.pose[2])];
    const [dx, dy] = [x - this.pose[0], y - this.pose[1]];
    return [c * dx + s * dy, c * dy - s * dx];
  }

  #obstacleAt(point) {
    const [x, y] = this.#worldPoint(point);
    const reach = (one) => Math.max(Math.abs(x - one.position.x) - one.size.x / 2, Math.abs(y - one.position.y) - one.size.y / 2);
    const near = this.obstacles.filter((one) => one.position && reach(one) < 0.5).sort((a, b) => reach(a) - reach(b));
    return near[0]?.id ?? null;
  }

  /** Description of a point. */
  textAt(point) {
    const [x, y] = point;
    const side = Math.abs(y) < 0.05 ? '' : `, ${Math.abs(y).toFixed(1)} m ${y > 0 ? 'left' : 'right'}`;
    const place = `${x.toFixed(1)} m ahead${side}`;
    if (!this.layer) return place;
    const { corner, resolution, width, height, frame, textOf } = this.layer;
    const [u, v] = frame === this.worldFrame ? this.#worldPoint(point) : point;
    const [column, row] = [Math.floor((u - corner[0]) / resolution), Math.floor((v - corner[1]) / resolution)];
    const inside = column >= 0 && column < width && row >= 0 && row < height;
    return `${place}: ${inside ? textOf(row * width + column) : 'outside the grid'}`;
  }

  #press(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.#ruler = this.measures ? [this.#vehiclePoint(event), this.#vehiclePoint(event)] : null;
    this.redraw();
    this.#pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
  }

  #move(event) {
    const before = this.#pointers.get(event.pointerId);
    const point = this.#vehiclePoint(event);
    if (!before) {
      this.onPoint(this.textAt(point));
      this.onHover(this.#obstacleAt(point));
      return;
    }
    if (this.#ruler) {
      this.#ruler[1] = point;
      return this.redraw();
    }
    const now = [event.offsetX, event.offsetY];
    const others = [...this.#pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const count = others.length + 1;
    this.#pan((now[0] - before[0]) / count, (now[1] - before[1]) / count);
    if (others.length > 0) { // two fingers
      const distance = (at) => Math.hypot(at[0] - others[0][0], at[1] - others[0][1]);
      this.#zoomBy(distance(now) / Math.max(1, distance(before)));
    }
    this.#pointers.set(event.pointerId, now);
  }

  #pan(right, down) {
    const { width, height } = this.canvas.getBoundingClientRect();
    const scale = this.#scale(width, height);
    this.centre = [this.centre[0] + down / scale, this.centre[1] + right / scale];
    this.#share();
  }

  #zoomBy(factor) {
    this.zoom = Math.min(20, Math.max(0.3, this.zoom * factor));
    this.#share();
  }

  #wheel(event) {
    event.preventDefault();
    const before = this.#vehiclePoint(event);
    this.#zoomBy(Math.exp(-event.deltaY / 500));
    const after = this.#vehiclePoint(event); // the point under the pointer stays
    this.centre = this.centre.map((value, i) => value + before[i] - after[i]);
    this.#share();
  }

  #key(event) {
    const step = 40; // px
    const actions = {
      ArrowUp: () => this.#pan(0, step), ArrowDown: () => this.#pan(0, -step),
      ArrowLeft: () => this.#pan(step, 0), ArrowRight: () => this.#pan(-step, 0),
      '+': () => this.#zoomBy(1.25), '=': () => this.#zoomBy(1.25), '-': () => this.#zoomBy(0.8), 0: () => this.home(),
    };
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in actions)) return;
    event.preventDefault();
    event.stopPropagation(); // they do not step through the frames here
    actions[event.key]();
    this.onPoint(this.textAt(this.centre));
  }
}

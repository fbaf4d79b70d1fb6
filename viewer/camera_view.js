// SPDX-License-Identifier: Apache-2.0
import { planePose } from './layers.js';
import { colour, fitCanvas } from './theme.js';

const nearest = 0.3; // m in front of the camera; nearer points are not drawn

/** Columns of the rotation matrix of a geometry_msgs/Quaternion: the child's axes in the parent. */
const axesOf = ({ x, y, z, w }) => [
  [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
  [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
  [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
];

/** p in the parent's frame → the child's, of a geometry_msgs/Transform that places the child in the parent. */
function intoChild({ translation, rotation }) {
  const axes = axesOf(rotation);
  return (point) => {
    const moved = [point[0] - translation.x, point[1] - translation.y, point[2] - translation.z];
    return axes.map((axis) => axis[0] * moved[0] + axis[1] * moved[1] + axis[2] * moved[2]);
  };
}

const mountingOf = (info, mountings) => mountings.find((one) => one.child_frame_id === info?.header.frame_id)?.transform;

/**
 * Place and field of view of a camera in the vehicle frame, m and rad: {x, y, right, left}; null: unknown. `info`: a
 * sensor_msgs/CameraInfo; `mountings`: transforms of a tf2_msgs/TFMessage.
 */
export function viewOf(info, mountings) {
  const mounting = mountingOf(info, mountings);
  if (!mounting) return null;
  const { translation: { x, y }, rotation } = mounting;
  const axis = axesOf(rotation)[2];
  const heading = Math.atan2(axis[1], axis[0]);
  const { p, width } = info;
  return { x, y, right: heading - Math.atan((width - p[2]) / p[0]), left: heading + Math.atan(p[2] / p[0]) };
}

/** Shows JPEGs one after the other in `image`, and `around` once there is one. */
export function imageShower(image, around) {
  let shown = '';
  return (message) => {
    const address = URL.createObjectURL(new Blob([message.data], { type: 'image/jpeg' }));
    const before = shown;
    shown = address;
    image.onload = () => URL.revokeObjectURL(before);
    image.src = address;
    around.hidden = false;
  };
}

/** Where an obstacle stands: the corners of its box, else the points of its line; in the world, m. */
function footprint({ box, outline, size }) {
  if (!box) return { base: outline.map(({ x, y }) => [x, y]), height: size?.z ?? 0, isClosed: false };
  const [x, y, yaw] = planePose(box.pose);
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  const base = [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([along, across]) => {
    const [ahead, left] = [(along * box.scale.x) / 2, (across * box.scale.y) / 2];
    return [x + c * ahead - s * left, y + s * ahead + c * left];
  });
  return { base, height: box.scale.z, isClosed: true };
}

/** Obstacles as they stand in the left camera's image: things as boxes, boundaries as lines on the road and at their height. */
export class CameraView {
  obstacles = [];
  pose = [0, 0, 0]; // pose of the vehicle in the world
  highlighted = null;
  #info = null;
  #intoCamera = null;

  constructor(image, canvas, { onHover, onPick }) {
    Object.assign(this, { image, canvas });
    canvas.addEventListener('pointermove', (event) => onHover(this.#obstacleAt(event)));
    canvas.addEventListener('pointerleave', () => onHover(null));
    canvas.addEventListener('click', (event) => onPick(this.#obstacleAt(event)));
    new ResizeObserver(() => this.redraw()).observe(image);
  }

  /** `info`, `mountings`: as of viewOf(). */
  place(info, mountings) {
    this.#info = info;
    const mounting = mountingOf(info, mountings);
    this.#intoCamera = mounting ? intoChild(mounting) : null;
    this.redraw();
  }

  redraw() {
    const { context, width, height } = fitCanvas(this.canvas);
    if (!this.#intoCamera) return;
    context.scale(width / this.#info.width, height / this.#info.height);
    for (const obstacle of this.obstacles) this.#draw(context, obstacle, this.#info.width / width);
  }

  #inCamera(x, y, z) {
    const [c, s] = [Math.cos(this.pose[2]), Math.sin(this.pose[2])];
    const [dx, dy] = [x - this.pose[0], y - this.pose[1]];
    return this.#intoCamera([c * dx + s * dy, c * dy - s * dx, z]);
  }

  #pixel([x, y, z]) {
    const { p } = this.#info;
    return [(p[0] * x) / z + p[2], (p[5] * y) / z + p[6]];
  }

  /** Edges of an obstacle in pixels, each from one end to the other, as far as they lie before the camera. */
  #edges(obstacle) {
    const { base, height, isClosed } = footprint(obstacle);
    const below = base.map(([x, y]) => this.#inCamera(x, y, 0));
    const above = base.map(([x, y]) => this.#inCamera(x, y, height));
    const pairs = [];
    below.forEach((point, i) => {
      const isCorner = isClosed || i === 0 || i === below.length - 1;
      if (isCorner) pairs.push([point, above[i]]);
      const before = i > 0 ? i - 1 : isClosed ? below.length - 1 : null;
      if (before !== null) pairs.push([below[before], point], [above[before], above[i]]);
    });
    return pairs.map(([from, to]) => {
      if (from[2] < nearest && to[2] < nearest) return null;
      const cut = (inside, outside) => {
        if (outside[2] >= nearest) return outside;
        const share = (inside[2] - nearest) / (inside[2] - outside[2]);
        return inside.map((value, i) => value + share * (outside[i] - value));
      };
      return [this.#pixel(cut(to, from)), this.#pixel(cut(from, to))];
    }).filter(Boolean);
  }

  #draw(context, obstacle, pixelsPerCssPixel) {
    const strong = obstacle.id === this.highlighted;
    context.strokeStyle = colour(strong ? '--highlight' : `--on-image-${obstacle.kind}`);
    context.lineWidth = (strong ? 3 : obstacle.kind === 'other' ? 1 : 1.5) * pixelsPerCssPixel;
    context.beginPath();
    for (const [from, to] of this.#edges(obstacle)) {
      context.moveTo(...from);
      context.lineTo(...to);
    }
    context.stroke();
  }

  /** The nearest thing whose edges are around the pointer. */
  #obstacleAt({ offsetX, offsetY }) {
    if (!this.#intoCamera) return null;
    const { width, height } = this.canvas.getBoundingClientRect();
    const [u, v] = [(offsetX * this.#info.width) / width, (offsetY * this.#info.height) / height];
    const found = this.obstacles.filter((one) => !['other', 'drop'].includes(one.kind) && one.position).filter((one) => {
      const ends = this.#edges(one).flat();
      const [us, vs] = [ends.map((end) => end[0]), ends.map((end) => end[1])];
      return u >= Math.min(...us) && u <= Math.max(...us) && v >= Math.min(...vs) && v <= Math.max(...vs);
    });
    const away = ({ position }) => Math.hypot(position.x - this.pose[0], position.y - this.pose[1]);
    return found.sort((a, b) => away(a) - away(b))[0]?.id ?? null;
  }
}

/** Images of a run's cameras: one is large, the others stand below it until a click makes them so. */
export class CameraStrip {
  #tiles = []; // {camera, element, name, view, show}
  #large = null; // a camera
  mountings = []; // transforms of the run

  /** `list`: receives the images; `disparities`: function that shows those of the large camera, or none. */
  constructor(list, disparities, handlers) {
    Object.assign(this, { list, disparities, handlers });
  }

  get views() {
    return this.#tiles.map(({ view }) => view);
  }

  /** Shows cameras {name, info, image, disparities} of a run; those that have not come are undefined. */
  follow(cameras, mountings) {
    if (this.#tiles.length !== cameras.length || this.#tiles.some(({ camera }, i) => camera !== cameras[i])) {
      this.#tiles = cameras.map((camera) => this.#newTile(camera));
      this.list.replaceChildren(...this.#tiles.map(({ element }) => element));
      for (const { name } of this.#tiles) name.hidden = cameras.length === 1;
      this.#enlarge(cameras.includes(this.#large) ? this.#large : cameras[0]);
    }
    this.mountings = mountings;
    for (const camera of cameras) for (const key of ['info', 'image', 'disparities']) this.receive(key, camera);
  }

  /** After a new `camera[key]`. */
  receive(key, camera) {
    const tile = this.#tiles.find((one) => one.camera === camera);
    if (!tile) return;
    if (key === 'info') tile.view.place(camera.info, this.mountings);
    if (key === 'image' && camera.image) tile.show(camera.image);
    if (key === 'disparities' && camera === this.#large) this.disparities(camera.disparities);
  }

  #newTile(camera) {
    const element = document.createElement('div');
    element.className = 'camera';
    element.innerHTML = `<button type="button"></button><div class="picture" hidden><img><canvas aria-hidden="true"></canvas></div>`;
    const [name, picture] = element.children;
    const [image, canvas] = picture.children;
    name.textContent = camera.name;
    name.onclick = () => this.#enlarge(camera);
    image.alt = `The ${camera.name || 'left'} camera's image, obstacles drawn where they stand`;
    const { onHover, onPick } = this.handlers;
    const pick = (id) => (camera === this.#large ? onPick(id) : this.#enlarge(camera));
    const view = new CameraView(image, canvas, { onHover, onPick: pick });
    return { camera, element, name, view, show: imageShower(image, picture) };
  }

  #enlarge(large) {
    this.#large = large;
    for (const { camera, element, name } of this.#tiles) {
      element.classList.toggle('large', camera === large);
      name.setAttribute('aria-pressed', camera === large);
    }
    this.disparities(large?.disparities);
    this.handlers.onEnlarge();
  }
}

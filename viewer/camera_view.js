// SPDX-License-Identifier: Apache-2.0
import { planePose } from './layers.js';
import { colour, fitCanvas } from './theme.js';

const nearest = 0.3; // m in front of the camera; nearer points are not drawn

/** p in the parent's frame → the child's, of a geometry_msgs/Transform that places the child in the parent. */
function intoChild({ translation, rotation }) {
  const { x, y, z, w } = rotation;
  const columns = [ // columns of the rotation matrix: the child's axes in the parent
    [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
    [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
    [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
  ];
  return (point) => {
    const moved = [point[0] - translation.x, point[1] - translation.y, point[2] - translation.z];
    return columns.map((axis) => axis[0] * moved[0] + axis[1] * moved[1] + axis[2] * moved[2]);
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
  #mountings = [];

  constructor(image, canvas, { onHover, onPick }) {
    Object.assign(this, { image, canvas });
    canvas.addEventListener('pointermove', (event) => onHover(this.#obstacleAt(event)));
    canvas.addEventListener('pointerleave', () => onHover(null));
    canvas.addEventListener('click', (event) => onPick(this.#obstacleAt(event)));
    new ResizeObserver(() => this.redraw()).observe(image);
  }

  /** A sensor_msgs/CameraInfo of the image. */
  calibrate(info) {
    this.#info = info;
    this.#mount();
  }

  /** A tf2_msgs/TFMessage with the camera's extrinsics. */
  place({ transforms }) {
    this.#mountings = transforms;
    this.#mount();
  }

  #mount() {
    const mounting = this.#mountings.find((one) => one.child_frame_id === this.#info?.header.frame_id);
    this.#intoCamera = mounting ? intoChild(mounting.transform) : null;
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

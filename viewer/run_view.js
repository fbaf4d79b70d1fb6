// SPDX-License-Identifier: Apache-2.0
import { viewOf } from './camera_view.js';
import { GridView } from './grid_view.js';
import { occupancyLayer, packedLayer, planePose } from './layers.js';
import { joined } from './obstacles.js';

export const packedKinds = { velocity: 'Velocity', moving: 'Moving', age: 'Age', elevation: 'Elevation', terrain: 'Terrain', witness: 'Witness' };

/** Nodes that have grids, in the order of their topics. */
export const nodesOf = (topics) =>
  topics.filter((topic) => topic.endsWith('/occupancy_grid')).map((topic) => topic.replace(/\/occupancy_grid$/, ''));

/** Names of a node's cameras; ['']: it has one. */
export function camerasOf(topics, node) {
  const names = topics.filter((topic) => topic.startsWith(`${node}/`))
    .map((topic) => /^(?:(\w+)\/)?left\/(?:camera_info|image_annotated\/compressed)$/.exec(topic.slice(node.length + 1)))
    .filter(Boolean).map(([, name]) => name ?? '');
  return [...new Set(names)];
}

/**
 * The grid of a node, and its last messages. Calls `onPoint(text)`, `onHover(run, id | null)` and `onPick(run, id)` as
 * GridView does, `onMessage(run, key)` when `latest[key]` has changed, and `onCamera(run, key, camera)` when `camera[key]`
 * has.
 */
export class RunView {
  latest = {}; // messages by what they are for
  cameras = []; // {name, info, image, disparities}
  mountings = []; // transforms of a tf2_msgs/TFMessage
  stamp = 0; // s, of the last message
  node = '';
  #kind = '';
  #layerTopic = '';

  constructor(figure, connection, { onPoint, onHover, onPick, onMessage, onCamera }) {
    Object.assign(this, { figure, connection, onMessage, onCamera });
    this.grid = new GridView(figure.querySelector('canvas'), {
      onPoint, onHover: (id) => onHover(this, id), onPick: (id) => onPick(this, id),
    });
  }

  /** NAME of "/NAME/stereo_grid", or the node without one. */
  get name() {
    return (this.node.replace(/\/[^/]*$/, '') || this.node).slice(1);
  }

  follow(node) {
    this.node = node;
    const { grid } = this;
    const obstacles = () => {
      grid.obstacles = joined(this.latest.markers, this.latest.obstacles);
      grid.redraw();
    };
    this.#receive('markers', `${node}/obstacle_markers`, obstacles);
    this.#receive('obstacles', `${node}/obstacles`, obstacles);
    this.#receive('pose', `${node}/odometry`, (message) => {
      grid.place(planePose(message.pose.pose), message.header.frame_id, this.stamp);
      grid.redraw();
    });
    this.#receive('status', `${node}/status`);
    if (this.name) this.connection.subscribe(`/${this.name}/tf_static`, (message) => this.mount(message));
    this.cameras = [];
  }

  /** Subscribes to the cameras that are new; others stay, or go. */
  followCameras(names) {
    const added = names.filter((name) => !this.cameras.some((camera) => camera.name === name)).map((name) => ({ name }));
    this.cameras = [...this.cameras.filter(({ name }) => names.includes(name)), ...added];
    for (const camera of added) {
      const below = `${this.node}/${camera.name && `${camera.name}/`}`;
      const receive = (key, topic) => this.connection.subscribe(below + topic, (message) => {
        camera[key] = message;
        if (key === 'info') this.#placeCameras();
        this.onCamera(this, key, camera);
      });
      receive('info', 'left/camera_info');
      receive('image', 'left/image_annotated/compressed');
      receive('disparities', 'u_disparity/compressed');
    }
  }

  /** A tf2_msgs/TFMessage with the extrinsics of the cameras. */
  mount({ transforms }) {
    this.mountings = transforms;
    this.#placeCameras();
    for (const camera of this.cameras) this.onCamera(this, 'info', camera);
  }

  // One camera is the vehicle's dot.
  #placeCameras() {
    this.grid.views = this.cameras.length < 2 ? [] : this.cameras.map(({ name, info }) => {
      const view = viewOf(info, this.mountings);
      return view && { name, ...view };
    }).filter(Boolean);
    this.grid.redraw();
  }

  #receive(key, topic, use = () => {}) {
    this.connection.subscribe(topic, (message, stamp) => {
      this.latest[key] = message;
      this.stamp = stamp;
      use(message);
      this.onMessage(this, key);
    });
  }

  /** Shows a layer: its kind and its topic below the node. Returns whether it had to be subscribed to. */
  choose(kind, name) {
    this.#kind = kind;
    const topic = name ? `${this.node}/${name}` : '';
    const isNew = topic !== this.#layerTopic;
    if (isNew) {
      if (this.#layerTopic) this.connection.unsubscribe(this.#layerTopic);
      this.latest.layer = null;
      this.#layerTopic = topic;
      if (topic) this.#receive('layer', topic, () => this.#show());
    }
    this.#show();
    return isNew;
  }

  #show() {
    const message = this.latest.layer;
    const kind = this.#kind;
    if (message) this.grid.show(() => (kind in packedKinds ? packedLayer(message, kind) : occupancyLayer(message)));
  }
}

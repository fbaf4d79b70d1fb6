// SPDX-License-Identifier: Apache-2.0
import { GridView } from './grid_view.js';
import { occupancyLayer, packedLayer, planePose } from './layers.js';
import { joined } from './obstacles.js';

export const packedKinds = { velocity: 'Velocity', moving: 'Moving', age: 'Age', elevation: 'Elevation', terrain: 'Terrain', witness: 'Witness' };

/** Nodes that have grids, in the order of their topics. */
export const nodesOf = (topics) =>
  topics.filter((topic) => topic.endsWith('/occupancy_grid')).map((topic) => topic.replace(/\/occupancy_grid$/, ''));

/**
 * The grid of a node, and its last messages. Calls `onPoint(text)`, `onHover(run, id | null)` and `onPick(run, id)` as
 * GridView does, and `onMessage(run, key)` when `latest[key]` has changed.
 */
export class RunView {
  latest = {}; // messages by what they are for
  stamp = 0; // s, of the last message
  node = '';
  #kind = '';
  #layerTopic = '';

  constructor(figure, connection, { onPoint, onHover, onPick, onMessage }) {
    Object.assign(this, { figure, connection, onMessage });
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
    this.#receive('image', `${node}/left/image_annotated/compressed`);
    this.#receive('disparities', `${node}/u_disparity/compressed`);
    this.#receive('info', `${node}/left/camera_info`);
    if (this.name) this.#receive('mounting', `/${this.name}/tf_static`);
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

// SPDX-License-Identifier: Apache-2.0
import { CameraView } from './camera_view.js';
import { Connection } from './connection.js';
import { recordClips, saveSnapshot } from './grid_tools.js';
import { GridView } from './grid_view.js';
import { showLegend, turnLegend } from './legend.js';
import { legendOf, occupancyLayer, packedLayer, planePose } from './layers.js';
import { ObstacleTable, joined } from './obstacles.js';
import { Player, playerParameters } from './player.js';
import { Recording } from './recording.js';
import { StatusPanel } from './status_panel.js';
import { onThemeChange } from './theme.js';

const element = (id) => document.getElementById(id);
const packedKinds = { velocity: 'Velocity', moving: 'Moving', age: 'Age', elevation: 'Elevation', terrain: 'Terrain', witness: 'Witness' };

const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
const recorded = element('recording'); // frames of `stereogrid export --web`; a server's page has none
export const connection = recorded ? new Recording(JSON.parse(recorded.textContent))
                                   : new Connection(`${scheme}://${location.host}/${location.search}`);
const latest = {}; // messages by what they are for
let picked = null;

function highlight(id) {
  const shown = id ?? picked;
  if (grid.highlighted === shown) return;
  for (const view of [grid, camera]) {
    view.highlighted = shown;
    view.redraw();
  }
  table.highlight(shown);
}

function pick(id) {
  picked = picked === id ? null : id;
  highlight(id);
}

const grid = new GridView(element('grid'), {
  onPoint: (text) => { element('cell').textContent = text || 'Point at a cell to read it.'; },
  onHover: highlight,
  onPick: pick,
});
const camera = new CameraView(element('camera'), element('outlines'), { onHover: highlight, onPick: pick });
const table = new ObstacleTable(element('obstacles').tBodies[0], { onHover: highlight, onPick: pick });
const status = new StatusPanel({
  chart: element('chart'), stageList: element('stages'), rate: element('rate'), dropped: element('dropped'),
  obstacles: element('count'), message: element('message'), latency: element('latency'),
  speedLimit: element('speed-limit'),
});
const player = new Player({
  bar: element('player'), play: element('play'), back: element('back'), forward: element('forward'),
  slider: element('slider'), speed: element('speed'), place: element('place'),
}, (name, value) => connection.setParameter(name, value));

function showObstacles() {
  const obstacles = joined(latest.markers, latest.obstacles);
  Object.assign(camera, { obstacles, pose: grid.pose });
  grid.obstacles = obstacles;
  table.show(obstacles, grid.pose);
  table.highlight(grid.highlighted);
  grid.redraw();
  camera.redraw();
}

function showPose(message, stamp) {
  grid.place(planePose(message.pose.pose), message.header.frame_id, stamp);
  turnLegend(element('legend'), grid.pose[2]);
  showObstacles();
}

/** Shows JPEGs one after the other in `image`, and `around` once there is one. */
function imageShower(image, around) {
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
const showImage = imageShower(element('camera'), element('picture'));
const showDisparities = imageShower(element('u-disparity'), element('u-disparity'));

/** Of all nodes the first that has grids. */
const nodeOf = (topics) => topics.find((topic) => topic.endsWith('/occupancy_grid'))?.replace(/\/occupancy_grid$/, '');

/** [value, text, topic] of each layer that the topics give. */
function layersOf(topics, node) {
  const has = (name) => topics.includes(`${node}/${name}`);
  const made = [];
  if (has('occupancy_grid')) made.push(['occupancy', 'Occupancy', 'occupancy_grid']);
  if (has('observed_grid')) made.push(['observed', 'Observed', 'observed_grid']);
  for (const topic of topics.filter((one) => one.startsWith(`${node}/predicted_grid_`)).sort()) {
    const seconds = topic.split('predicted_grid_')[1];
    made.push([seconds, `In ${seconds.replace('_', '.')} s`, `predicted_grid_${seconds}`]);
  }
  if (has('packed_grid')) {
    for (const [kind, text] of Object.entries(packedKinds)) made.push([kind, text, 'packed_grid']);
  }
  return made.map(([value, text, name]) => ({ value, text, topic: `${node}/${name}` }));
}

let layerTopic = '';
function showLayer() {
  const message = latest.layer;
  if (!message) return;
  const kind = element('layer').value;
  grid.show(() => (kind in packedKinds ? packedLayer(message, kind) : occupancyLayer(message)));
}

function chooseLayer() {
  const topic = element('layer').selectedOptions[0]?.dataset.topic ?? '';
  if (topic !== layerTopic) {
    if (layerTopic) connection.unsubscribe(layerTopic);
    latest.layer = null;
    layerTopic = topic;
    if (topic) connection.subscribe(topic, (message) => { latest.layer = message; showLayer(); });
    player.repeat();
  }
  showLegend(element('legend'), legendOf(element('layer').value));
  showLayer();
}

let node = '';
function subscribeTo(name) {
  node = name;
  const take = { markers: 'obstacle_markers', obstacles: 'obstacles' };
  for (const [key, topic] of Object.entries(take)) {
    connection.subscribe(`${node}/${topic}`, (message) => { latest[key] = message; showObstacles(); });
  }
  connection.subscribe(`${node}/odometry`, showPose);
  connection.subscribe(`${node}/status`, (message, stamp) => status.show(message, stamp));
  connection.subscribe(`${node}/left/image_annotated/compressed`, showImage);
  connection.subscribe(`${node}/u_disparity/compressed`, showDisparities);
  connection.subscribe(`${node}/left/camera_info`, (message) => camera.calibrate(message));
  connection.subscribe('/tf_static', (message) => camera.place(message));
}

connection.addEventListener('channels', ({ detail: topics }) => {
  const found = nodeOf(topics);
  if (found === undefined) return;
  if (found !== node) subscribeTo(found);
  const options = layersOf(topics, node).map(({ value, text, topic }) => {
    const option = new Option(text, value);
    option.dataset.topic = topic;
    return option;
  });
  const chosen = element('layer').value;
  element('layer').replaceChildren(...options);
  if (options.some((option) => option.value === chosen)) element('layer').value = chosen;
  chooseLayer();
});
connection.addEventListener('state', ({ detail: state }) => {
  element('state').textContent = state;
  element('state').className = state;
  element('name').textContent = connection.name;
  if (state === 'connected' && connection.name) player.follow();
  if (state === 'disconnected') status.reset();
});
connection.addEventListener('parameter', ({ detail: parameter }) => player.take(parameter));
connection.addEventListener('fault', ({ detail: sentence }) => { element('fault').textContent = sentence; });

element('layer').addEventListener('change', chooseLayer);
element('home').addEventListener('click', () => grid.home());
element('ruler').addEventListener('click', () => {
  grid.measures = !grid.measures;
  element('ruler').setAttribute('aria-pressed', grid.measures);
});
const pictureName = () => `${connection.name || 'stereogrid'}-${element('layer').value}${location.hash.replace('#', '-').replace('=', '-')}`;
element('snapshot').addEventListener('click', () => saveSnapshot(element('grid'), pictureName()));
recordClips(element('clip'), element('grid'), pictureName);
element('help-button').addEventListener('click', () => element('help').showModal());
document.addEventListener('keydown', (event) => { if (event.key === '?') element('help').showModal(); });
onThemeChange(() => { chooseLayer(); grid.redraw(); camera.redraw(); });
setInterval(() => status.showRate(), 500);
connection.watchParameters(playerParameters);
connection.open();

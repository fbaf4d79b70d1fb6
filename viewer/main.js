// SPDX-License-Identifier: Apache-2.0
import { CameraStrip, imageShower } from './camera_view.js';
import { Connection } from './connection.js';
import { recordClips, saveSnapshot } from './grid_tools.js';
import { legendOf, showLegend, turnLegend } from './layers.js';
import { ObstacleTable } from './obstacles.js';
import { Player, playerParameters } from './player.js';
import { Recording } from './recording.js';
import { RunView, camerasOf, nodesOf, packedKinds } from './run_view.js';
import { StatusPanel } from './status_panel.js';
import { onThemeChange } from './theme.js';

const element = (id) => document.getElementById(id);

const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
const recorded = element('recording'); // frames of `stereogrid export --web`; a server's page has none
export const connection = recorded ? new Recording(JSON.parse(recorded.textContent))
                            : new Connection(`${scheme}://${location.host}/${location.search}`);
let picked = null;

function highlight(id) {
  const highlighted = id ?? picked;
  if (shown.grid.highlighted === highlighted) return;
  for (const view of [shown.grid, ...cameras.views]) {
    view.highlighted = highlighted;
    view.redraw();
  }
  table.highlight(highlighted);
}

function pick(id) {
  picked = picked === id ? null : id;
  highlight(id);
}

const showDisparities = imageShower(element('u-disparity'), element('u-disparity'));
const cameras = new CameraStrip(element('cameras'), (message) => {
  if (message) showDisparities(message);
  else element('u-disparity').hidden = true;
}, { onHover: highlight, onPick: pick, onEnlarge: showObstacles });
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
  const { obstacles, pose, highlighted } = shown.grid;
  table.show(obstacles, pose);
  table.highlight(highlighted);
  for (const view of cameras.views) {
    Object.assign(view, { obstacles, pose });
    view.redraw();
  }
}

// Functions of the other panels, by message of the run that they show.
const panels = {
  markers: showObstacles,
  obstacles: showObstacles,
  pose: () => { turnLegend(element('legend'), shown.grid.pose[2]); showObstacles(); },
  status: (message) => status.show(message, shown.stamp),
};

function newRun(figure) {
  const run = new RunView(figure, connection, {
    onPoint: (text) => { element('cell').textContent = text || 'Point at a cell to read it.'; },
    onHover: (from, id) => { if (from === shown) highlight(id); },
    onPick: (from, id) => { select(from); pick(id); },
    onMessage: (from, key) => { if (from === shown) panels[key]?.(from.latest[key]); },
    onCamera: (from, key, camera) => {
      if (from !== shown) return;
      cameras.mountings = from.mountings;
      cameras.receive(key, camera);
    },
  });
  if (mounting) run.mount(mounting);
  figure.querySelector('button').onclick = () => select(run);
  return run;
}

/** Shows a run in the other panels. */
function select(run) {
  if (shown === run) return;
  pick(picked); // none
  shown = run;
  status.reset();
  showCameras();
  for (const [key, message] of Object.entries(run.latest)) panels[key]?.(message);
  for (const one of runs) one.figure.querySelector('button').setAttribute('aria-pressed', one === shown);
}

let mounting = null; // the last message on /tf_static
const runs = [newRun(document.querySelector('#grids figure'))];
let shown = runs[0];

function showCameras() {
  cameras.follow(shown.cameras, shown.mountings);
  element('camera-title').textContent = shown.cameras.length > 1 ? 'Cameras' : 'Left camera';
  showObstacles();
}

/** A grid for each node, side by side. */
function follow(nodes, topics) {
  for (const run of runs.splice(nodes.length)) run.figure.remove();
  while (runs.length < nodes.length) {
    const figure = runs[0].figure.cloneNode(true);
    figure.querySelector('canvas').removeAttribute('id');
    element('grids').append(figure);
    runs.push(newRun(figure));
  }
  if (!runs.includes(shown)) select(runs[0]);
  runs.forEach((run, i) => {
    if (run.node !== nodes[i]) run.follow(nodes[i]);
    run.followCameras(camerasOf(topics, nodes[i]));
    run.grid.linked = runs.filter((other) => other !== run).map((other) => other.grid);
    const caption = run.figure.querySelector('figcaption');
    caption.hidden = runs.length === 1;
    caption.firstChild.textContent = run.name;
    caption.firstChild.setAttribute('aria-pressed', run === shown);
  });
  showCameras();
}

/** [value, text, topic below the node] of each layer that the topics give. */
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
  return made;
}

function chooseLayer() {
  const kind = element('layer').value;
  const topic = element('layer').selectedOptions[0]?.dataset.topic ?? '';
  const subscribed = runs.map((run) => run.choose(kind, topic));
  if (subscribed.includes(true)) player.repeat();
  showLegend(element('legend'), legendOf(kind));
  turnLegend(element('legend'), shown.grid.pose[2]);
}

connection.addEventListener('channels', ({ detail: topics }) => {
  const nodes = nodesOf(topics);
  if (nodes.length === 0) return;
  follow(nodes, topics);
  const options = layersOf(topics, nodes[0]).map(([value, text, topic]) => {
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
element('home').addEventListener('click', () => shown.grid.home());
element('ruler').addEventListener('click', () => {
  const measures = !shown.grid.measures;
  for (const { grid } of runs) grid.measures = measures;
  element('ruler').setAttribute('aria-pressed', measures);
});
const pictureName = () => `${connection.name || 'stereogrid'}-${element('layer').value}${location.hash.replace('#', '-').replace('=', '-')}`;
element('snapshot').addEventListener('click', () => saveSnapshot(shown.grid.canvas, pictureName()));
recordClips(element('clip'), () => shown.grid.canvas, pictureName);
element('help-button').addEventListener('click', () => element('help').showModal());
document.addEventListener('keydown', (event) => { if (event.key === '?') element('help').showModal(); });
connection.subscribe('/tf_static', (message) => {
  mounting = message;
  for (const run of runs) run.mount(message);
});
onThemeChange(() => { chooseLayer(); for (const { grid } of runs) grid.redraw(); for (const view of cameras.views) view.redraw(); });
setInterval(() => status.showRate(), 500);
connection.watchParameters(playerParameters);
connection.open();

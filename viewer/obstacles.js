// SPDX-License-Identifier: Apache-2.0

const lineStrip = 4; // visualization_msgs/Marker
const idBits = 0x7fffffff;

/** The last bytes of the UUID are the obstacle's number, as its markers have it. */
function idOf({ uuid: { uuid } }) {
  return new DataView(uuid.buffer, uuid.byteOffset + 12, 4).getUint32(0) & idBits;
}

/** Obstacles with outlines, from the last message on either topic. */
export function joined(markers, array) {
  const made = new Map();
  const having = (id) => made.get(id) ?? made.set(id, { id, kind: 'other', outline: [] }).get(id);
  for (const marker of markers?.markers ?? []) {
    if (['outlines', 'drops'].includes(marker.ns) && marker.type === lineStrip) having(marker.id).outline = marker.points;
    if (marker.ns === 'drops') having(marker.id).kind = 'drop';
    if (marker.ns === 'boxes') {
      having(marker.id).box = { pose: marker.pose, scale: marker.scale };
      if (having(marker.id).kind === 'other') having(marker.id).kind = 'thing';
    }
    if (marker.ns === 'speeds') having(marker.id).kind = 'moving';
  }
  for (const { uuid, position, velocity, size, score } of array?.obstacles ?? []) {
    Object.assign(having(idOf({ uuid })), { position, velocity, size, score });
  }
  return [...made.values()];
}

const kindNames = { moving: 'moving', thing: 'standing', other: 'boundary', drop: 'drop' };

/** Rows in the order of distance. Each can be focused and hovered (`onHover(id | null)`) and picked (`onPick(id)`). */
export class ObstacleTable {
  constructor(body, { onHover, onPick }) {
    Object.assign(this, { body, onHover, onPick });
    body.addEventListener('pointerover', (event) => onHover(this.#idOf(event)));
    body.addEventListener('pointerleave', () => onHover(null));
    body.addEventListener('click', (event) => onPick(this.#idOf(event)));
    body.addEventListener('focusin', (event) => onHover(this.#idOf(event)));
    body.addEventListener('focusout', () => onHover(null));
    body.addEventListener('keydown', (event) => {
      if (event.key === 'Enter') onPick(this.#idOf(event));
    });
  }

  #idOf(event) {
    const row = event.target.closest('tr');
    return row ? Number(row.dataset.id) : null;
  }

  /** `pose`: of the vehicle. */
  show(obstacles, [x, y, yaw]) {
    const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
    const rows = obstacles.filter((one) => one.position).map((one) => {
      const [dx, dy] = [one.position.x - x, one.position.y - y];
      return { ...one, ahead: c * dx + s * dy, left: c * dy - s * dx };
    });
    rows.sort((a, b) => Math.hypot(a.ahead, a.left) - Math.hypot(b.ahead, b.left));
    while (this.body.rows.length > rows.length) this.body.deleteRow(-1);
    rows.forEach((row, index) => this.#fill(this.body.rows[index] ?? this.#newRow(), row));
  }

  #newRow() {
    const row = this.body.insertRow();
    row.tabIndex = 0;
    for (let i = 0; i < 6; ++i) row.insertCell();
    return row;
  }

  #fill(row, { id, kind, ahead, left, velocity, size, score }) {
    row.dataset.id = id;
    const speed = Math.hypot(velocity.x, velocity.y); // 0 until motion is certain
    const name = kindNames[kind];
    const texts = [id, name === 'standing' && speed > 0 ? 'slow' : name, ahead.toFixed(1), left.toFixed(1), speed > 0 ? speed.toFixed(1) : '–', `${(100 * score).toFixed(0)} %`];
    texts.forEach((text, i) => { row.cells[i].textContent = text; });
    row.cells[1].className = `kind ${kind}`;
    row.title = `box ${size.x.toFixed(1)} × ${size.y.toFixed(1)} m, ${size.z.toFixed(1)} m high`;
  }

  highlight(id) {
    for (const row of this.body.rows) row.classList.toggle('highlighted', Number(row.dataset.id) === id);
  }
}

// SPDX-License-Identifier: Apache-2.0

export const playerParameters = ['frame', 'time_s', 'playing', 'speed', 'frames', 'duration_s'].map((name) => `player.${name}`);
const pauseMs = 40; // between two settings while the slider is dragged: servers take 100 requests a second

/** "#frame=17" or "#t=1.5" as {name, value}; null: neither. */
function linked(hash) {
  const match = /^#(frame|t)=(\d+(?:\.\d+)?)$/.exec(hash);
  if (!match) return null;
  return match[1] === 'frame' ? { name: 'player.frame', value: Math.floor(Number(match[2])) }
                              : { name: 'player.time_s', value: Number(match[2]) };
}

/** Controls of a server that plays a recording; hidden where there is none. */
export class Player {
  #state = {};
  #pending = null;
  #settled = -Infinity; // when the slider was last dragged
  #linkMade = '';

  constructor(elements, set) {
    this.elements = elements;
    this.set = set;
    elements.play.onclick = () => this.#toggle();
    elements.back.onclick = () => this.#step(-1);
    elements.forward.onclick = () => this.#step(1);
    elements.slider.oninput = () => this.#seek(Number(elements.slider.value));
    elements.speed.onchange = () => this.set('player.speed', Number(elements.speed.value));
    document.addEventListener('keydown', (event) => this.#key(event));
    window.addEventListener('hashchange', () => this.follow());
  }

  /** Goes to the frame that the address names. */
  follow() {
    const link = linked(location.hash);
    if (!link || location.hash === this.#linkMade) return;
    this.set('player.playing', false);
    this.set(link.name, link.value);
  }

  /** Requests the frame again: a new subscription has none of it while the player stands. */
  repeat() {
    if (this.#state.playing === false) this.set('player.frame', this.#state.frame);
  }

  take({ name, value }) {
    this.#state[name.replace('player.', '')] = value;
    this.#show();
  }

  #show() {
    const { frame, frames, time_s, playing, speed } = this.#state;
    if (Object.keys(this.#state).length < playerParameters.length) return;
    const { bar, play, slider, place } = this.elements;
    bar.hidden = frames < 2;
    slider.max = frames - 1;
    if (performance.now() - this.#settled > 300) slider.value = frame; // not while it is dragged
    slider.setAttribute('aria-valuetext', `frame ${frame} of ${frames - 1}`);
    place.textContent = `${frame} / ${frames - 1} · ${time_s.toFixed(1)} s`;
    play.textContent = playing ? '❚❚' : '▶';
    play.setAttribute('aria-label', playing ? 'Pause' : 'Play');
    this.elements.speed.value = String(speed);
    if (!playing) this.#link(frame);
  }

  #link(frame) {
    this.#linkMade = `#frame=${frame}`;
    history.replaceState(null, '', this.#linkMade);
  }

  #toggle() {
    this.set('player.playing', !this.#state.playing);
  }

  #step(by) {
    if (this.#state.playing) this.set('player.playing', false);
    this.#seek(this.#state.frame + by);
  }

  #seek(frame) {
    const within = Math.min(this.#state.frames - 1, Math.max(0, frame));
    this.#settled = performance.now();
    this.#state.frame = this.elements.slider.value = within;
    if (this.#pending === null) setTimeout(() => {
      this.set('player.frame', this.#pending);
      this.#pending = null;
    }, pauseMs);
    this.#pending = within;
  }

  #key(event) {
    const control = event.target.closest('input, select, button, textarea');
    if (this.elements.bar.hidden || event.ctrlKey || event.metaKey || event.altKey) return;
    if (control && (event.key === ' ' || control.matches('input, select'))) return;
    const far = event.shiftKey ? 10 : 1;
    const actions = {
      ' ': () => this.#toggle(), ArrowLeft: () => this.#step(-far), ArrowRight: () => this.#step(far),
      Home: () => this.#seek(0), End: () => this.#seek(this.#state.frames - 1),
    };
    if (!(event.key in actions)) return;
    event.preventDefault();
    actions[event.key]();
  }
}

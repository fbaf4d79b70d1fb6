// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers of `stereogrid batch status`, asked for again and again.

const every_ms = 3000;
const states = [
  ["done", "done"],
  ["running", "running"],
  ["stopped", "begun, nobody works on it"],
  ["missing", "missing"],
  ["poison", "poison: bad input or wrong usage"],
  ["given_up", "given up after crashes"],
];
const at = (id) => document.getElementById(id);

function element(name, text, of_class = "") {
  const made = document.createElement(name);
  made.textContent = text;
  made.className = of_class;
  return made;
}

function row(name, ...values) {
  const made = document.createElement("tr");
  made.append(name, ...values.map((value) => element("td", value, "number")));
  return made;
}

function duration(seconds) {
  if (seconds < 120) return `${Math.round(seconds)} s`;
  if (seconds < 7200) return `${Math.round(seconds / 60)} min`;
  return seconds < 172800 ? `${(seconds / 3600).toFixed(1)} h` : `${(seconds / 86400).toFixed(1)} days`;
}

const whole = (number) => number.toLocaleString("en");
const share = (part, all) => `${((100 * part) / Math.max(all, 1)).toFixed(1)} %`;

function show_states(found) {
  const status = { ...found, given_up: found.failed - found.poison };
  at("bar").replaceChildren(...states.map(([key]) => {
    const part = element("span", "", key);
    part.style.flexGrow = status[key];
    return part;
  }));
  at("states").replaceChildren(...states.map(([key, text]) => {
    const name = element("td", text);
    name.prepend(element("i", "", key));
    return row(name, whole(status[key]), share(status[key], status.shards));
  }));
}

function show_speed(status) {
  const of_one = status.frames_per_second_of_a_runner;
  const unknown = "not known yet";
  at("speed").replaceChildren(
    row(element("td", "done"), `${whole(status.frames_done)} of ${whole(status.frames)}`),
    row(element("td", "skipped"), whole(status.frames_skipped)),
    row(element("td", "a second, of one runner"), of_one > 0 ? of_one.toFixed(2) : unknown),
    row(element("td", "a second, of those running"), of_one > 0 ? (of_one * status.running).toFixed(2) : unknown),
    row(element("td", "time left"), status.seconds_left > 0 ? `about ${duration(status.seconds_left)}` : unknown));
}

function show_failures(failures) {
  at("none").hidden = failures.length > 0;
  at("failure-table").hidden = failures.length === 0;
  at("failures").replaceChildren(...failures.map((failure) => {
    const made = document.createElement("tr");
    made.append(...[failure.shard, failure.exit_code, failure.host, failure.message].map((value) => element("td", value)));
    return made;
  }));
}

function show(answer) {
  at("name").textContent = answer.plan;
  at("fault").textContent = answer.fault;
  at("state").textContent = `${duration(answer.age_s)} ago`;
  at("state").className = "connected";
  show_states(answer.status);
  show_speed(answer.status);
  show_failures(answer.status.failures);
}

async function refresh() {
  try {
    const reply = await fetch("status.json", { cache: "no-store" });
    if (!reply.ok) throw new Error(`${reply.status} ${reply.statusText}`);
    show(await reply.json());
  } catch (error) {
    at("state").textContent = `no answer (${error.message})`;
    at("state").className = "disconnected";
  }
  setTimeout(refresh, every_ms);
}

refresh();

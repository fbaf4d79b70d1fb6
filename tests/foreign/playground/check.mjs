// SPDX-License-Identifier: Apache-2.0
//
// Usage: node check.mjs STEREOGRID CHROMIUM FOLDER. Computes pairs in FOLDER/page/index.html and with the tool. Prints the
// largest difference and the time, and leaves screenshots in FOLDER.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, rmSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import * as zstd from "@foxglove/wasm-zstd";
import { McapIndexedReader } from "@mcap/core";
import { chromium } from "playwright-core";

await zstd.isLoaded;
const [stereogrid, browserProgram, folder] = process.argv.slice(2);
const differenceMax = 1e-6;
const secondsMax = 1;
const bytesMax = 4e6; // compressed
const topics = ["grid_map", "occupancy_grid", "observed_grid", "packed_grid", "obstacles"].map((name) => `/stereo_grid/${name}`);
const tool = (...words) => execFileSync(stereogrid, [...words, "--quiet"], { stdio: "ignore" });

/** A pair of a scene: {left, right, calibration}, names of files. */
function simulated(scene, name) {
  rmSync(`${folder}/${name}`, { recursive: true, force: true });
  tool("simulate", scene, "--out", `${folder}/${name}`, "--no-truth");
  const [left, right] = ["left", "right"].map((side) => `${folder}/${name}/${side}/000008.png`);
  return { left, right, calibration: `${folder}/${name}/calibration.yaml` };
}

/** The tool's messages of a pair, decoded, by topic; and the readers. */
async function toolMessages({ left, right, calibration }, options) {
  for (const old of ["run", "run.mcap"]) rmSync(`${folder}/${old}`, { recursive: true, force: true });
  tool("run", left, right, "--calibration", calibration, "--poses", "none", "--set", "tracking.confirm_frames=1",
    "--out", `${folder}/run`, "--mcap", `${folder}/run.mcap`, ...options);
  const bytes = readFileSync(`${folder}/run.mcap`);
  const mcap = await McapIndexedReader.Initialize({
    readable: {
      size: async () => BigInt(bytes.byteLength),
      read: async (offset, length) => bytes.subarray(Number(offset), Number(offset + length)),
    },
    decompressHandlers: { zstd: (packed, size) => new Uint8Array(zstd.decompress(packed, Number(size))) },
  });
  const found = {};
  for await (const { channelId, data } of mcap.readMessages({ topics })) {
    const { topic, schemaId } = mcap.channelsById.get(channelId);
    const reader = new MessageReader(parse(new TextDecoder().decode(mcap.schemasById.get(schemaId).data), { ros2: true }));
    found[topic] = { reader, message: reader.readMessage(data) };
  }
  return found;
}

/** Runs in the page, before its scripts: keeps a copy of each message of the pipeline, by topic. */
function watchPipeline() {
  const { instantiate } = WebAssembly;
  WebAssembly.instantiate = async (module, { page, ...others }) => {
    const names = [];
    globalThis.sent = {};
    const latin1At = (at, size) => new Uint8Array(instance.exports.memory.buffer, at, size)
      .reduce((text, byte) => text + String.fromCharCode(byte), "");
    const add = (...texts) => {
      names.push(latin1At(texts[0], texts[1]));
      page.add(...texts);
    };
    const send = (channel, at, size) => {
      globalThis.sent[names[channel]] = latin1At(at, size);
      page.send(channel, at, size);
    };
    const instance = await instantiate(module, { page: { ...page, add, send }, ...others });
    return instance;
  };
}

/** Presses a button; returns the text below it when the computation has ended. */
async function outcomeOf(page, button) {
  const outcome = page.locator("#outcome");
  await outcome.evaluate((element) => { element.textContent = "Computing"; });
  await page.getByRole("button", { name: button, exact: true }).click();
  await page.waitForFunction(() => !document.getElementById("outcome").textContent.startsWith("Computing"));
  return outcome.textContent();
}

const secondsIn = (outcome) => Number(/^Computed in (\d+\.\d+) s/.exec(outcome)?.[1] ?? assert.fail(outcome));

/** Largest difference of numbers in two messages; infinite if anything else differs. */
function difference(a, b) {
  if (typeof a !== "object") return Object.is(a, b) ? 0 : Math.abs(a - b) || Infinity;
  if (a.length !== b.length) return Infinity;
  return Object.keys(a).reduce((most, key) => Math.max(most, difference(a[key], b[key])), 0);
}

/** Compares the page's last messages with the tool's. */
async function compare(page, pair, ...options) {
  const ofTool = await toolMessages(pair, options);
  const ofPage = await page.evaluate(() => globalThis.sent);
  const differences = topics.map((topic) => {
    const { reader, message } = ofTool[topic];
    return difference(message, reader.readMessage(Uint8Array.from(Buffer.from(ofPage[topic], "latin1"))));
  });
  assert.ok(Math.max(...differences) <= differenceMax, `${pair.left}: ${differences}`);
  const layer = ofTool[topics[0]].message.data[0].data;
  assert.ok(new Set(layer).size > 100, "the grid is not empty");
  console.log(`${layer.length} cells, ${ofTool[topics[4]].message.obstacles.length} obstacles: largest difference ${Math.max(...differences)}`);
}

async function checkSample(page) {
  await page.locator("#obstacles tbody tr").first().waitFor();
  await page.screenshot({ path: `${folder}/playground-tool.png` });
  const seconds = [];
  for (let i = 0; i < 5; ++i) seconds.push(secondsIn(await outcomeOf(page, "Sample pair")));
  console.log(`512 × 320 px: ${Math.min(...seconds)} s, the first time ${seconds[0]} s`);
  assert.ok(Math.min(...seconds) <= secondsMax);
  await compare(page, simulated("scene:street?width=512&height=320&frames=12", "street"));
  assert.ok(await page.locator("#obstacles tbody tr").count() > 1);
  await page.screenshot({ path: `${folder}/playground.png` });
}

/** Files of a robot's camera, with extrinsics that are estimated. */
async function checkFiles(page) {
  const pair = simulated("scene:terrain?kind=ditch&camera=robot&frames=12", "ditch");
  writeFileSync(pair.calibration, readFileSync(pair.calibration, "utf8").replace(/^mount:.*\n/m, ""));
  for (const name of ["left", "right", "calibration"]) await page.locator(`[name=${name}]`).setInputFiles(pair[name]);
  await page.waitForFunction(() => document.querySelector("[name=camera_height_m]").value === "");
  await page.locator("[name=preset]").selectOption("robot");
  secondsIn(await outcomeOf(page, "Compute"));
  await compare(page, pair, "--preset", "robot");
  assert.strictEqual(await page.textContent("#name"), "000008.png");
  await page.locator("#layer").selectOption("elevation");
  await page.screenshot({ path: `${folder}/playground-ditch.png` });
}

/** Files that are dropped: the images in the order of their names. */
async function checkDrop(page) {
  const { left, right, calibration } = simulated("scene:crossing?width=400&height=300&frames=9", "crossing");
  const files = Object.entries({ "r.png": right, "l.png": left, "calibration.yaml": calibration })
    .map(([name, path]) => ({ name, base64: readFileSync(path).toString("base64") }));
  await page.evaluate(async (dropped) => {
    const dataTransfer = new DataTransfer();
    for (const { name, base64 } of dropped) {
      dataTransfer.items.add(new File([await (await fetch(`data:;base64,${base64}`)).blob()], name));
    }
    document.body.dispatchEvent(new DragEvent("drop", { bubbles: true, cancelable: true, dataTransfer }));
  }, files);
  await page.waitForFunction(() => document.getElementById("outcome").textContent === "l.png, r.png");
  await page.locator("[name=preset]").selectOption("default");
  secondsIn(await outcomeOf(page, "Compute"));
  await compare(page, { left, right, calibration });
}

/** KITTI's calibration, and messages of errors: of the page and of the library. */
async function checkFields(page) {
  const value = (name) => page.locator(`[name=${name}]`).inputValue();
  const kitti = "P0: 700 0 600 0 0 700 180 0 0 0 1 0\nP1: 700 0 600 -378 0 700 180 0 0 0 1 0\n";
  await page.locator("[name=calibration]").setInputFiles({ name: "calib.txt", mimeType: "text/plain", buffer: Buffer.from(kitti) });
  await page.waitForFunction(() => document.querySelector("[name=focal_px]").value === "700");
  assert.deepStrictEqual(await Promise.all(["cx_px", "cy_px", "baseline_m"].map(value)), ["600", "180", "0.54"]);
  await page.locator("[name=baseline_m]").fill("540");
  assert.match(await outcomeOf(page, "Compute"), /rig: .*baseline/i);
  const yaml = "image: {width_px: 640, height_px: 480}\nfocal_px: 700\ncx_px: 320\nbaseline_m: 0.54\nmount: {camera_roll_rad: 0.01}\n";
  const give = (text) => page.locator("[name=calibration]").setInputFiles({ name: "c.yaml", mimeType: "text/plain", buffer: Buffer.from(text) });
  await give(yaml);
  await page.waitForFunction(() => /has neither cy_px, as/.test(document.getElementById("outcome").textContent));
  await give(`${yaml}cy_px: 240\n`);
  await page.waitForFunction(() => document.querySelector("[name=camera_roll_rad]").value === "0.01");
  assert.match(await outcomeOf(page, "Compute"), /for 640 × 480 px, the images have 400 × 300 px/);
  await page.locator("[name=baseline_m]").fill("0.5"); // fields are for any size
  assert.match(await outcomeOf(page, "Compute"), /Give the height of the camera/);
  await page.locator("[name=baseline_m]").fill("");
  assert.match(await outcomeOf(page, "Compute"), /Give the focal length and the baseline/);
  secondsIn(await outcomeOf(page, "Sample pair")); // an error leaves the page usable
}

const browser = await chromium.launch({ executablePath: browserProgram, args: ["--no-sandbox"] });
const page = await browser.newPage({ viewport: { width: 1280, height: 900 } });
const faults = [];
page.on("console", (message) => { if (message.type() === "error") faults.push(message.text()); });
page.on("pageerror", (error) => faults.push(String(error)));
page.on("request", (request) => { if (/^http/.test(request.url())) faults.push(`request to ${request.url()}`); });
await page.addInitScript(watchPipeline);
await page.goto(`file://${folder}/page/index.html`);
const compressed = gzipSync(readFileSync(`${folder}/page/index.html`)).length;
console.log(`${(compressed / 1e6).toFixed(2)} MB compressed`);
assert.ok(compressed <= bytesMax);
await checkSample(page);
await checkFiles(page);
await checkDrop(page);
await checkFields(page);
assert.deepStrictEqual(faults, []);
await browser.close();
console.log("The playground works in Chromium.");

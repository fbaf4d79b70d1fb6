// SPDX-License-Identifier: Apache-2.0
//
// Usage: node check.js STEREOGRID CHROMIUM FOLDER. Opens the pages of `stereogrid view FOLDER/street.mcap`, `stereogrid live`
// and `stereogrid export FOLDER/run --web`, uses them, and leaves screenshots in FOLDER.
"use strict";

const assert = require("node:assert");
const { spawn, spawnSync } = require("node:child_process");
const { mkdirSync, readFileSync, rmSync } = require("node:fs");
const { chromium } = require("playwright-core");

const [stereogrid, browserProgram, folder] = process.argv.slice(2);
const recording = `${folder}/street.mcap`;
const started = [];

/** Starts a program; returns the address of its page. */
function serve(program, ...words) {
  const child = spawn(program, words, { stdio: ["pipe", "pipe", "inherit"] });
  started.push(child);
  return new Promise((resolve, reject) => {
    let output = "";
    child.stdout.on("data", (text) => {
      output += text;
      const address = /http:\S+/.exec(output);
      if (address) resolve({ address: address[0], child });
    });
    child.on("exit", (code) => reject(new Error(`${program} ended with ${code}`)));
  });
}

/** What a canvas shows, as a hash, and how many colours it has. */
function look(page, place = "#grid") {
  return page.evaluate((selector) => {
    const canvas = document.querySelector(selector);
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const pixels = new Uint32Array(data.buffer);
    return { colours: new Set(pixels).size, digest: pixels.reduce((hash, pixel) => Math.imul(hash ^ pixel, 0x01000193)) };
  }, place);
}

/** What the grid looks like once it has changed and changes no more. */
async function changedLook(page, before) {
  let digest = before;
  for (let i = 0; i < 100; ++i) {
    const last = digest;
    await page.waitForTimeout(200);
    digest = (await look(page)).digest;
    if (digest !== before && digest === last) break;
  }
  return digest;
}

async function opened(browser, address, options = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, ...options });
  const faults = [];
  page.on("console", (message) => { if (message.type() === "error") faults.push(message.text()); });
  page.on("pageerror", (error) => faults.push(String(error)));
  await page.goto(address);
  return { page, faults };
}

/** Waits until a function says yes in the page. (The page's security policy forbids playwright's waitForFunction.) */
async function until(page, isSo, argument) {
  const end = Date.now() + 20000;
  while (!await page.evaluate(isSo, argument)) {
    assert.ok(Date.now() < end, `not in time: ${isSo} ${argument}`);
    await page.waitForTimeout(50);
  }
}

const atFrame = (page, frame) => until(
  page, (wanted) => document.getElementById("place").textContent.startsWith(`${wanted} /`), frame);

async function settled(page) {
  await until(page, () => document.querySelectorAll("#obstacles tbody tr").length > 0);
  await page.waitForTimeout(400);
}

async function checkPlayer(browser, address) {
  const { page, faults } = await opened(browser, `${address}#frame=17`);
  await atFrame(page, 17);
  await settled(page);
  const there = await look(page);
  assert.ok(there.colours > 20, `the grid has ${there.colours} colours`);
  for (const place of [".large img", "#u-disparity"]) {
    assert.ok(await page.evaluate((one) => document.querySelector(one).naturalWidth > 100, place), `no ${place}`);
  }
  assert.ok((await look(page, ".large canvas")).colours > 2, "no obstacle in the camera's image");
  assert.strictEqual(await page.textContent("#state"), "connected");
  await page.screenshot({ path: `${folder}/view-light.png` });

  await page.keyboard.press("ArrowLeft");
  await atFrame(page, 16);
  await page.keyboard.press("Home");
  await atFrame(page, 0);
  assert.strictEqual(await page.locator("#slider").inputValue(), "0");
  await page.locator("#slider").fill("25");
  await atFrame(page, 25);
  await settled(page);
  assert.notStrictEqual((await look(page)).digest, there.digest);
  assert.match(page.url(), /#frame=25$/);
  await page.evaluate(() => { location.hash = "#frame=17"; });
  await atFrame(page, 17);
  await page.waitForTimeout(400);
  assert.strictEqual((await look(page)).digest, there.digest, "a frame looks the same when one comes back to it");

  await page.locator("#speed").selectOption("5");
  await page.locator("#grid-title").click();
  await page.keyboard.press("Space");
  await atFrame(page, 29); // and stands there
  await until(page, () => document.getElementById("play").getAttribute("aria-label") === "Play");
  await checkLayers(page);
  await checkObstacles(page);
  assert.deepStrictEqual(faults, []);
  await page.close();
}

async function checkLayers(page) {
  const values = await page.locator("#layer option").evaluateAll((options) => options.map((option) => option.value));
  assert.deepStrictEqual(values, ["occupancy", "observed", "0_5", "velocity", "moving", "age", "elevation", "terrain", "witness"]);
  const seen = new Set();
  let digest = null;
  for (const value of values) {
    await page.locator("#layer").selectOption(value);
    seen.add(digest = await changedLook(page, digest));
    await page.locator("#grid").hover({ position: { x: 300, y: 200 } });
    assert.match(await page.textContent("#legend"), value === "witness" ? /nonepassablegroundmemorysource/ : /unknown/);
    assert.match(await page.textContent("#cell"), /m ahead.*: (unknown|occupied|never observed|outside)/);
  }
  assert.strictEqual(seen.size, values.length);
  await page.locator("#layer").selectOption("occupancy");
}

/** What each layer looks like, a frame on: velocities are those between neighbours. */
async function layersAfter(page, frame) {
  await atFrame(page, frame);
  await settled(page);
  await page.keyboard.press("ArrowRight");
  await atFrame(page, frame + 1);
  await settled(page);
  await page.locator("#home").click();
  const values = await page.locator("#layer option").evaluateAll((options) => options.map((option) => option.value));
  const looks = {};
  let digest = null;
  for (const value of values) {
    await page.locator("#layer").selectOption(value);
    looks[value] = digest = await changedLook(page, digest);
  }
  return looks;
}

/** One file, opened from disk, shows what the served page shows, and plays. */
async function checkExport(browser) {
  rmSync(`${folder}/web`, { recursive: true, force: true });
  const { status, stderr } = spawnSync(stereogrid, ["export", `${folder}/run`, "--web", `${folder}/web`], { encoding: "utf8" });
  assert.strictEqual(status, 0, stderr);
  assert.match(stderr, /web\/index.html: 30 frames, \d+\.\d MB/);
  const { address, child } = await serve(stereogrid, "view", `${folder}/run`, "--listen", ":0");
  const served = await opened(browser, `${address}#frame=16`);
  const { page, faults } = await opened(browser, `file://${folder}/web/index.html#frame=16`);
  const looks = await layersAfter(page, 16);
  assert.deepStrictEqual(Object.keys(looks), ["occupancy", "observed", "velocity", "moving", "age", "elevation", "terrain", "witness"]);
  assert.deepStrictEqual(looks, await layersAfter(served.page, 16));
  await page.screenshot({ path: `${folder}/export.png` });
  await page.locator("#speed").selectOption("5");
  await page.locator("#grid-title").click();
  await page.keyboard.press("Space");
  await atFrame(page, 29); // and stands there
  await until(page, () => document.getElementById("play").getAttribute("aria-label") === "Play");
  assert.deepStrictEqual(faults, []);
  await checkTools(page);
  child.removeAllListeners("exit");
  child.kill("SIGINT");
}

/** Two runs: one slider and one part of the world for both grids, the panels of either. */
async function checkSideBySide(browser) {
  const other = `${folder}/paper`;
  rmSync(other, { recursive: true, force: true });
  const { status, stderr } = spawnSync(stereogrid, ["run", "scene:street?frames=30", "--preset", "paper", "--out", other, "-q"],
    { encoding: "utf8" });
  assert.strictEqual(status, 0, stderr);
  const { address, child } = await serve(stereogrid, "view", `${folder}/run`, other, "--listen", ":0");
  const { page, faults } = await opened(browser, `${address}#frame=17`);
  await atFrame(page, 17);
  await settled(page);
  const captions = page.locator("figcaption button");
  assert.deepStrictEqual(await captions.allTextContents(), ["run", "paper"]);
  const looks = () => page.locator("#grids canvas").evaluateAll((all) => all.map((canvas) => canvas.toDataURL()));
  const untilBothDiffer = (before) => until(page,
    (old) => [...document.querySelectorAll("#grids canvas")].every((canvas, i) => canvas.toDataURL() !== old[i]), before);
  const before = await looks();
  assert.notStrictEqual(before[0], before[1]);
  await page.locator("#grid").focus();
  await page.keyboard.press("+");
  await untilBothDiffer(before);
  await page.keyboard.press("0");
  await page.locator("#grid-title").click();
  await page.keyboard.press("ArrowRight");
  await atFrame(page, 18);
  await untilBothDiffer(before);
  const table = await page.textContent("#obstacles tbody");
  await captions.nth(1).click();
  assert.strictEqual(await captions.nth(1).getAttribute("aria-pressed"), "true");
  assert.notStrictEqual(await page.textContent("#obstacles tbody"), table);
  await page.screenshot({ path: `${folder}/side-by-side.png` });
  assert.deepStrictEqual(faults, []);
  await page.close();
  child.removeAllListeners("exit");
  child.kill("SIGINT");
}

/** A live server with two presets. */
async function checkLiveBeside(browser) {
  const { address, child } = await serve(stereogrid, "live", "scene:street?frames=30", "--loop", "--beside", "paper", "--listen", ":0");
  const { page, faults } = await opened(browser, address);
  await until(page, () => document.querySelectorAll("#grids canvas").length === 2);
  assert.deepStrictEqual(await page.locator("figcaption button").allTextContents(), ["stereo_grid", "paper"]);
  await until(page, () => new Set([...document.querySelectorAll("#grids canvas")].map((canvas) => canvas.toDataURL())).size === 2);
  assert.deepStrictEqual(faults, []);
  await page.close();
  child.removeAllListeners("exit");
  child.kill("SIGINT");
}

/** Ruler, snapshot, clip and keys. */
async function checkTools(page) {
  const before = (await look(page)).digest;
  await page.locator("#ruler").click();
  const { x, y } = await page.locator("#grid").boundingBox();
  await page.mouse.move(x + 200, y + 150);
  await page.mouse.down();
  await page.mouse.move(x + 300, y + 250);
  await page.mouse.up();
  await page.waitForTimeout(300);
  assert.notStrictEqual((await look(page)).digest, before);
  const saved = async (id) => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.locator(id).click()]);
    return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
  };
  const picture = await saved("#snapshot");
  assert.strictEqual(picture.name, "run-witness-frame-29.png");
  assert.strictEqual(picture.bytes.toString("latin1", 1, 4), "PNG");
  await page.locator("#clip").click();
  await page.locator("#slider").fill("5");
  await atFrame(page, 5);
  await page.waitForTimeout(300);
  const clip = await saved("#clip");
  assert.match(clip.name, /\.webm$/);
  assert.strictEqual(clip.bytes.readUInt32BE(0), 0x1a45dfa3);
  await page.keyboard.press("?");
  assert.ok(await page.locator("#help").isVisible());
  await page.close();
}

async function checkObstacles(page) {
  const rows = page.locator("#obstacles tbody tr");
  assert.ok(await rows.count() > 1);
  assert.match((await rows.first().innerText()).replace(/\s+/g, " "), /^\d+ (moving|slow|standing|boundary) -?\d/);
  await page.mouse.move(5, 5);
  await page.waitForTimeout(300);
  const before = [(await look(page)).digest, (await look(page, ".large canvas")).digest];
  await rows.first().hover();
  await page.waitForTimeout(300);
  assert.notStrictEqual((await look(page)).digest, before[0], "the row's obstacle is highlighted in the grid");
  assert.notStrictEqual((await look(page, ".large canvas")).digest, before[1], "and in the image");
  assert.strictEqual(await page.locator("tr.highlighted").count(), 1);
  await page.locator("#grid").focus();
  const unzoomed = (await look(page)).digest;
  await page.keyboard.press("+");
  await page.waitForTimeout(300);
  assert.notStrictEqual((await look(page)).digest, unzoomed);
}

/** Text against what it stands on: 4.5 to 1 (WCAG 2, AA). */
async function checkContrast(page, name) {
  const poor = await page.evaluate(() => {
    const luminance = (text) => text.match(/[0-9.]+/g).slice(0, 3).map(Number).map((value) => value / 255)
      .map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4))
      .reduce((sum, value, i) => sum + value * [0.2126, 0.7152, 0.0722][i], 0);
    const behind = (one) => {
      const colour = getComputedStyle(one).backgroundColor;
      return /, 0\)$/.test(colour) && one.parentElement ? behind(one.parentElement) : colour;
    };
    const hasText = (one) => [...one.childNodes].some((child) => child.nodeType === Node.TEXT_NODE && child.data.trim());
    return [...document.querySelectorAll("body *")].filter((one) => hasText(one) && one.checkVisibility()).map((one) => {
      const [a, b] = [getComputedStyle(one).color, behind(one)].map(luminance).sort((x, y) => y - x);
      return { text: one.textContent.trim().slice(0, 30), contrast: (a + 0.05) / (b + 0.05) };
    }).filter(({ contrast }) => contrast < 4.5);
  });
  assert.deepStrictEqual(poor, [], name);
}

async function photograph(browser, address, name, options) {
  const { page, faults } = await opened(browser, `${address}#frame=17`, options);
  await atFrame(page, 17);
  await settled(page);
  assert.strictEqual(await page.locator("#slider").inputValue(), "17", `${name}: the slider stands elsewhere`);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  assert.ok(wide <= 0, `${name}: the page is ${wide} px too wide`);
  const cut = await page.evaluate(() => {
    const { scrollWidth, clientWidth } = document.querySelector("#obstacle-panel .scroll");
    return scrollWidth - clientWidth;
  });
  assert.ok(cut <= 0, `${name}: ${cut} px of the table are cut off`);
  await checkContrast(page, name);
  await page.screenshot({ path: `${folder}/${name}.png` });
  assert.deepStrictEqual(faults, []);
  await page.close();
}

/** On an address other than loopback access is denied without the token. */
async function checkToken(browser) {
  const { address, child } = await serve(stereogrid, "view", recording, "--listen", "0.0.0.0:0");
  const local = address.replace(/\/\/[^:/]+/, "//127.0.0.1");
  assert.match(local, /token=/);
  const bare = local.replace(/\?.*/, "");
  for (const wrong of [bare, `${bare}?token=${"x".repeat(27)}`, `${bare}main.js`]) {
    assert.strictEqual((await fetch(wrong)).status, 401);
  }
  const { page, faults } = await opened(browser, `${local}#frame=17`);
  await until(page, () => document.getElementById("state").textContent === "connected");
  await settled(page);
  assert.deepStrictEqual(faults, []);
  await page.close();
  child.removeAllListeners("exit");
  const ended = new Promise((resolve) => child.on("exit", resolve));
  child.kill("SIGINT");
  assert.strictEqual(await ended, 0);
}

/** Without a player; the page reconnects to a new server. */
async function checkLive(browser) {
  const { address, child } = await serve(stereogrid, "live", "scene:street?frames=30", "--loop", "--listen", ":0");
  const { page, faults } = await opened(browser, address);
  await settled(page);
  assert.ok((await look(page)).colours > 20);
  assert.ok(await page.locator("#player").isHidden());
  assert.match(await page.textContent("#latency"), /^\d+ \(99 %: \d+\)$/);
  await page.screenshot({ path: `${folder}/live.png` });
  assert.deepStrictEqual(faults, []);
  child.removeAllListeners("exit");
  child.kill("SIGINT");
  await until(page, () => document.getElementById("state").textContent !== "connected");
  await serve(stereogrid, "view", recording, "--listen", new URL(address).host);
  await until(page, () => document.getElementById("state").textContent === "connected");
  await page.locator("#player").waitFor({ state: "visible" });
  await page.close();
}

/** What cannot be shown is refused with words that help. */
function checkRefusals(address) {
  mkdirSync(`${folder}/empty`, { recursive: true });
  const taken = new URL(address).host;
  const refusals = [
    [[`${folder}/empty`], 65, /neither a run nor a recording.*run INPUT --out DIR/],
    [[`${folder}/none.mcap`], 65, /none\.mcap/],
    [[recording, "--listen", "nowhere"], 64, /'nowhere' is not a place to listen.*ADDRESS:PORT/],
    [[recording, "--listen", "::1:8765"], 64, /not a place to listen/],
    [[recording, "--listen", taken], 75, /--listen :0/],
  ];
  for (const [words, code, error_text] of refusals) {
    const { status, stderr } = spawnSync(stereogrid, ["view", ...words], { encoding: "utf8", timeout: 20000 });
    assert.strictEqual(status, code, stderr);
    assert.match(stderr, error_text);
  }
}

async function main() {
  const browser = await chromium.launch({ executablePath: browserProgram, args: ["--no-sandbox"] });
  const { address } = await serve(stereogrid, "view", recording, "--listen", ":0");
  checkRefusals(address);
  await checkPlayer(browser, address);
  await photograph(browser, address, "view-dark", { colorScheme: "dark" });
  await photograph(browser, address, "view-small", { viewport: { width: 1024, height: 700 } });
  await photograph(browser, address, "view-phone", { viewport: { width: 390, height: 844 }, hasTouch: true });
  await checkToken(browser);
  await checkLive(browser);
  await checkExport(browser);
  await checkSideBySide(browser);
  await checkLiveBeside(browser);
  await browser.close();
  console.log("The page works in Chromium.");
}

function end(code) {
  for (const child of started) {
    child.removeAllListeners("exit");
    child.kill();
  }
  process.exit(code);
}

main().then(() => end(0), (error) => {
  console.error(error);
  end(1);
});

// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Usage: NODE_PATH=…/node_modules node viewer.js STEREOGRID RECORDING.mcap [CHROMIUM]. Plays a recording of 10 frames a
// second five times as fast in a browser for 20 s while the pointer moves over the grid, and prints the frame rates.
// Needs playwright-core (tests/foreign installs it).
"use strict";

const { spawn } = require("node:child_process");
const { chromium } = require("playwright-core");

const [stereogrid, recording, executablePath = "/usr/bin/chromium"] = process.argv.slice(2);
const seconds = 20;

function serve() {
  const child = spawn(stereogrid, ["view", recording, "--listen", ":0"], { stdio: ["ignore", "pipe", "inherit"] });
  return new Promise((resolve) => child.stdout.on("data", (text) => {
    const address = /http:\S+/.exec(text);
    if (address) resolve({ address: address[0], child });
  }));
}

/** In the page: counts images of the grid, and how long each move of the pointer waits for the next one. */
function watch() {
  const seen = { frames: 0, waits: [], long: 0 };
  window.seen = seen;
  const { putImageData } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.putImageData = function put(...rest) {
    ++seen.frames;
    seen.size = `${rest[0].width} × ${rest[0].height}`;
    return putImageData.apply(this, rest);
  };
  document.getElementById("grid").addEventListener("pointermove", (event) => {
    requestAnimationFrame(() => seen.waits.push(performance.now() - event.timeStamp));
  });
  new PerformanceObserver((list) => { seen.long += list.getEntries().length; }).observe({ entryTypes: ["longtask"] });
}

async function main() {
  const { address, child } = await serve();
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
  console.log("| layer | grid | frames/s sent | grids/s drawn | pointer moves | answered | p50 ms | p99 ms | tasks over 50 ms |");
  console.log("|---|---|---|---|---|---|---|---|---|");
  for (const layer of ["occupancy", "velocity"]) {
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    await page.goto(address);
    await page.locator("#player").waitFor({ state: "visible" });
    await page.locator("#layer").selectOption(layer);
    await page.locator("#speed").selectOption("5");
    await page.evaluate(watch);
    const before = Date.now();
    let moves = 0;
    while (Date.now() - before < 1000 * seconds) {
      if (await page.locator("#play").getAttribute("aria-label") === "Play") await page.locator("#play").click();
      for (let i = 0; i < 10; ++i, ++moves) await page.mouse.move(100 + 5 * (moves % 60), 200 + (moves % 37));
      await page.waitForTimeout(50);
    }
    const time = (Date.now() - before) / 1000;
    const { frames, waits, long, size } = await page.evaluate(() => window.seen);
    waits.sort((a, b) => a - b);
    const at = (share) => waits[Math.floor((waits.length - 1) * share)].toFixed(0);
    console.log(`| ${layer} | ${size} | 50 | ${(frames / time).toFixed(1)} | ${moves} | ${waits.length} | ${at(0.5)} | ${at(0.99)} | ${long} |`);
    await page.close();
  }
  await browser.close();
  child.kill();
}

main();

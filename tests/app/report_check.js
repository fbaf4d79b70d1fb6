#!/usr/bin/env node
// SPDX-License-Identifier: Apache-2.0
// Runs the script of a report of `evaluate` or `compare` without a browser and looks at what it puts into the page.
// Usage: report_check.js REPORT.html
'use strict';
const fs = require('fs');
const vm = require('vm');
const assert = require('assert').strict;

const page = fs.readFileSync(process.argv[2], 'utf8');
const scripts = [...page.matchAll(/<script([^>]*)>([\s\S]*?)<\/script>/g)];
const json = scripts.find(script => script[1].includes('application/json'))[2];
// no module here: exported names are used in the same script
const code = scripts.filter(script => script[1].includes('module')).map(script => script[2].replace(/^export /gm, '')).join('\n');
const data = JSON.parse(json);

// as much of a document as the script uses; ids that the page does not have are an error, as in a browser
const elements = new Map();
for (const [, id] of page.matchAll(/\sid="([^"]+)"/g)) {
  elements.set(id, {innerHTML: '', textContent: id === 'data' ? json : '', listeners: {},
                    addEventListener(event, run) { this.listeners[event] = run; }});
}
const buttons = new Map();
const document = {
  getElementById: id => elements.get(id) ?? null,
  querySelectorAll(selector) {
    assert.equal(selector, '#bands button');
    return [...elements.get('bands').innerHTML.matchAll(/data-band="([^"]+)"/g)].map(([, band]) => {
      if (!buttons.has(band)) {
        buttons.set(band, {dataset: {band}, pressed: null, setAttribute(name, value) { this.pressed = value; }});
      }
      return buttons.get(band);
    });
  },
};
vm.runInNewContext(code, {document});

const html = id => elements.get(id).innerHTML;
const text = id => html(id).replace(/<[^>]*>/g, ' ');
const rounded = value => value === null ? '–' : value.toFixed(3).replace('-', '−');

/** Every element that is opened is closed, in order. */
function expectWellFormed(id) {
  const open = [];
  for (const [, closing, name, empty] of html(id).matchAll(/<(\/?)([a-zA-Z0-9]+)[^>]*?(\/?)>/g)) {
    if (closing) assert.equal(open.pop(), name, `#${id}`);
    else if (!empty && name !== 'br') open.push(name);
  }
  assert.deepEqual(open, [], `#${id} leaves elements open`);
}

function expectNumbers(id) {
  for (const word of ['NaN', 'undefined', 'Infinity', 'null', '[object']) {
    assert.ok(!html(id).includes(word), `#${id} shows ${word}`);
  }
}

const names = Object.keys(data.series);
const bands = names.length ? Object.keys(data.series[names[0]].bands) : [];

function expectBand(band) {
  for (const id of elements.keys()) {
    expectNumbers(id);
    expectWellFormed(id);
  }
  for (const name of names) {
    for (const metric of data.metrics) {
      const {value} = data.series[name].bands[band][metric.name];
      assert.ok(text('table').includes(rounded(value)), `${name}, ${band}: ${metric.name} ${value} is not in the table`);
    }
    const losses = data.series[name].frames[band].filter(frame => frame.balanced_log_loss !== null);
    for (const {name: frame, balanced_log_loss: loss} of losses) {
      assert.ok(html('frames').includes(`${frame}: ${loss.toFixed(3)}`), `frame ${frame} has no bar`);
    }
    const paths = (html('roc').match(/stroke="var\(--s\d/g) ?? []).length;
    const curves = names.filter(one => data.series[one].bands[band].roc.length).length;
    assert.equal(paths, curves, `${band}: a curve for each series`);
  }
  const bins = names.flatMap(name => data.series[name].bands[band].reliability).filter(bin => bin.cells > 0).length;
  assert.equal((html('reliability').match(/<circle/g) ?? []).length, bins, `${band}: a point for each bin`);
  assert.equal([...buttons.values()].filter(button => button.pressed).map(button => button.dataset.band).join(), band);
}

if (data.obstacles) {
  for (const id of ['about', 'obstacles']) {
    expectNumbers(id);
    expectWellFormed(id);
  }
  for (const value of [data.obstacles.separate, data.obstacles.tracking.idr, data.obstacles.errors.centre_m]) {
    assert.ok(text('obstacles').includes(rounded(value)), `${value} is not among the obstacles`);
  }
}
if (!names.length && data.obstacles) {
  assert.equal(html('figures'), '');
  console.log('obstacles only: the page is filled');
  process.exit(0);
}
assert.ok(names.length > 0 && bands.length > 0);
for (const name of names) assert.ok(text('legend').includes(name), `${name} is not in the legend`);
for (const key of Object.keys(data.about)) assert.ok(text('about').includes(key), `${key} is not at the top`);
assert.ok(html('cards').split('class="card"').length - 1 >= 5);
assert.ok(html('overview').includes('<table>'));
expectBand('3-20');
for (const band of bands) {
  elements.get('bands').listeners.click({target: {dataset: {band}}});
  expectBand(band);
}
console.log(`${names.length} series, ${bands.length} ranges: the page is filled`);

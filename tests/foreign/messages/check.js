// SPDX-License-Identifier: Apache-2.0
//
// Usage: node check.js SAMPLES.json. Foxglove's own code reads what message_samples has written: every value has to be
// the one that was written, and its writer has to make the same bytes of it. Definitions are compared with ROS's.
const fs = require("fs");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader, MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { ros2humble, ros2jazzy } = require("@foxglove/rosmsg-msgs-common");

// in none of ROS's own repositories, so not among these definitions
const elsewhere = /^(foxglove_msgs|grid_map_msgs|nav2_dynamic_msgs|vision_msgs)\//;
let compared = 0;

function fail(text) {
  console.error(text);
  process.exit(1);
}

function plain(value) {
  if (typeof value === "number" && !Number.isFinite(value)) return Number.isNaN(value) ? "nan" : value < 0 ? "-inf" : "inf";
  if (ArrayBuffer.isView(value)) return Array.from(value, plain);
  return value;
}

// Foxglove calls nanoseconds of a time "nsec".
function compare(read, written, where) {
  const found = plain(read);
  if (Array.isArray(written)) {
    if (!Array.isArray(found) || found.length !== written.length) fail(`${where}: ${found} is not ${written}`);
    written.forEach((element, i) => compare(found[i], element, `${where}[${i}]`));
  } else if (typeof written === "object") {
    for (const [name, element] of Object.entries(written)) {
      const there = name in found ? name : name === "nanosec" ? "nsec" : name;
      compare(found[there], element, `${where}.${name}`);
    }
  } else {
    ++compared;
    // NaN may have come with a sign
    if (!Object.is(found, written) && !(found === 0 && written === 0) && !(found === "nan" && written === "-nan")) {
      fail(`${where}: ${found} is not ${written}`);
    }
  }
}

function fields(definition) {
  return definition.definitions.filter((field) => !field.isConstant)
    .map(({ name, type, isArray = false, arrayLength }) => `${type} ${name} ${isArray} ${arrayLength ?? ""}`).join("\n");
}

function compareDefinitions(definitions, type) {
  for (const definition of definitions) {
    const name = (definition.name ?? type).replace("/msg/", "/");
    for (const known of [ros2humble, ros2jazzy]) {
      if (!known[name] && !elsewhere.test(name)) fail(`ROS does not know ${name}`);
      if (known[name] && fields(known[name]) !== fields(definition)) {
        fail(`${name} is not as in ROS:\n${fields(definition)}\nbut\n${fields(known[name])}`);
      }
    }
  }
}

const samples = JSON.parse(fs.readFileSync(process.argv[2]));
for (const { type, definition, messages } of samples) {
  const definitions = parse(definition, { ros2: true });
  compareDefinitions(definitions, type);
  const reader = new MessageReader(definitions);
  const writer = new MessageWriter(definitions);
  messages.forEach(({ cdr, value }, i) => {
    const bytes = Buffer.from(cdr, "hex");
    const read = reader.readMessage(bytes);
    compare(read, value, `${type} ${i}`);
    const written = Buffer.from(writer.writeMessage(read));
    if (!written.equals(bytes)) fail(`${type} ${i}: is written as\n${written.toString("hex")} but by us as\n${cdr}`);
  });
}
console.log(`${samples.length} types, ${samples.reduce((sum, one) => sum + one.messages.length, 0)} messages, ` +
            `${compared} values are read as they were written`);

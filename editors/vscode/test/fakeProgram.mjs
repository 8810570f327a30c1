#!/usr/bin/env node
// Stands for `revolve`: prints its arguments, its working folder and REVOLVE_UNTRUSTED as JSON. REVOLVE_LACKS lists commands
// that it does not know. `report` writes a page, and `view` prints an address and waits.

import { mkdirSync, writeFileSync } from "node:fs";
import path from "node:path";

const words = process.argv.slice(2);
const [command] = words;
if (command === "--version") {
  console.log("revolve 0.0.1 (test)");
  process.exit(0);
}
if ((process.env.REVOLVE_LACKS ?? "").split(",").includes(command)) {
  console.error(`error: unrecognized subcommand '${command}'`);
  process.exit(2);
}
if (words.includes("--help")) {
  process.exit(0);
}
const deck = words.at(-1);
if (command === "run") {
  const out = words.indexOf("--out");
  mkdirSync(out < 0 ? path.join("out", path.parse(deck).name) : words[out + 1], { recursive: true });
}
if (command === "report") {
  writeFileSync(path.join(deck, "report.html"), `<html><head><title>${path.basename(deck)}</title></head></html>`);
}
console.log(JSON.stringify({ words, cwd: process.cwd(), untrusted: process.env.REVOLVE_UNTRUSTED ?? "" }));
if (command === "view") {
  if (deck.includes("faulty")) {
    console.error("error[D101]: unknown keyword *FAULTY");
    process.exit(2);
  }
  writeFileSync("view process", JSON.stringify({ id: process.pid, words }));
  console.log("live view at http://127.0.0.1:4711/?key=a%20b&n=1");
  setInterval(() => {}, 1000);
}

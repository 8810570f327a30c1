// Output of the program that the extension reads: messages, and the page of a report. REVOLVE names the program.

import * as assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import * as path from "node:path";
import { after, test } from "node:test";
import * as manifest from "../package.json";
import { deckCommandLine, resultFolders } from "../src/commandLine";
import { securedPage } from "../src/report";
import { insertedText } from "./snippetText";

const root = process.env.EXTENSION_ROOT ?? ".";
const folder = mkdtempSync(path.join(tmpdir(), "revolve program "));
after(() => rmSync(folder, { recursive: true }));

/** Runs the program with a command line of the extension. */
function call({ words, cwd }: { words: string[]; cwd: string }) {
  return spawnSync(process.env.REVOLVE ?? "revolve", words, { cwd, encoding: "utf8" });
}

test("results are where the report looks for them, and its page allows one script by a hash", () => {
  const deck = path.join(folder, "elastic bar.inp");
  const decks = JSON.parse(readFileSync(path.join(root, "snippets/decks.json"), "utf8"));
  writeFileSync(deck, insertedText(decks["Deck: minimal"]) + "\n");
  const run = call(deckCommandLine("run", deck, ["--quiet"]));
  assert.equal(run.status, 0, run.stderr);
  const [results] = resultFolders(deck, []);
  const report = call({ words: ["report", "--quiet", results], cwd: folder });
  assert.equal(report.status, 0, report.stderr);
  const page = readFileSync(path.join(results, "report.html"), "utf8");
  assert.equal(securedPage(page), page);
  const policy = /http-equiv="Content-Security-Policy" content="([^"]*)"/.exec(page)?.[1] ?? "";
  assert.match(policy, /^default-src 'none';.* script-src 'sha256-[^' ]*';/);
});

test("problem matchers read the place, code and text of a message", () => {
  const deck = path.join(folder, "a faulty deck.inp");
  writeFileSync(deck, "*Heading\n title\n*Nod\n 1, 0., 0.\n");
  const { status, stdout, stderr } = call(deckCommandLine("check", deck));
  assert.equal(status, 2);
  const lines = (stdout + stderr).split("\n");
  const [first, second] = manifest.contributes.problemMatchers[0].pattern.map((line) => new RegExp(line.regexp));
  const at = lines.findIndex((line) => first.test(line));
  assert.deepEqual(first.exec(lines[at])?.slice(1, 3), ["error", "D102"]);
  assert.deepEqual(second.exec(lines[at + 1])?.slice(1, 4), ["a faulty deck.inp", "3", "1"]);
});

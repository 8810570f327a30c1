// Snippets: decks are complete, cards are valid in the decks of `hosts`. REVOLVE names the program.

import * as assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import * as path from "node:path";
import { after, test } from "node:test";
import { insertedText, Snippet } from "./snippetText";

const root = process.env.EXTENSION_ROOT ?? ".";
const program = process.env.REVOLVE ?? "revolve";
const folder = mkdtempSync(path.join(tmpdir(), "revolve snippets "));
after(() => rmSync(folder, { recursive: true }));

const read = (file: string) => JSON.parse(readFileSync(path.join(root, "snippets", file), "utf8")) as Record<string, Snippet>;
const [decks, cards] = [read("decks.json"), read("cards.json")];

/** Checks a deck with the program; errors and warnings fail. */
function checkDeck(name: string, text: string): void {
  const file = path.join(folder, `${name}.inp`);
  writeFileSync(file, text + "\n");
  const { status, stdout, stderr } = spawnSync(program, ["check", "--json", file], { encoding: "utf8" });
  const result = JSON.parse(stdout || "{}") as { accepted?: boolean; diagnostics?: unknown[] };
  assert.deepEqual([status, result.accepted, result.diagnostics], [0, true, []], `${name}: ${stderr}\n${text}`);
}

for (const [title, snippet] of Object.entries(decks)) {
  test(`${title} passes revolve check`, () => checkDeck(snippet.prefix, insertedText(snippet)));
}

test("all decks have tab stops, and a title as description", () => {
  assert.ok(Object.keys(decks).length >= 4);
  for (const { body, description } of Object.values(decks)) {
    assert.ok(body.join("\n").includes("${1:"), description);
    assert.equal(body[1].trim(), description);
  }
});

const used = new Set<string>();
const hosts = path.join(root, "test", "hosts");
for (const host of readdirSync(hosts).filter((name) => name !== "mesh.inp")) {
  test(`cards in ${host} are valid`, () => {
    copyFileSync(path.join(hosts, "mesh.inp"), path.join(folder, "mesh.inp"));
    const text = readFileSync(path.join(hosts, host), "utf8").replace(/^>> (.*)$/gm, (_, title: string) => {
      assert.ok(title in cards, `${host}: no snippet ${title}`);
      used.add(title);
      // The host ends the step itself.
      return insertedText(cards[title]).replace(/\n+\*End Step$/, "");
    });
    checkDeck(path.parse(host).name, text);
  });
}

test("every card is in a host", () => {
  assert.deepEqual(Object.keys(cards).filter((title) => !used.has(title)), []);
});

test("prefixes are distinct, and each card begins with the keyword of its prefix", () => {
  const prefixes = [...Object.values(decks), ...Object.values(cards)].map((snippet) => snippet.prefix);
  assert.equal(new Set(prefixes).size, prefixes.length);
  for (const { prefix, body } of Object.values(cards)) {
    const keyword = insertedText({ prefix, description: "", body }).split("\n").map((line) => line.split(",")[0]);
    assert.ok(keyword.some((name) => name.startsWith("*") && prefix.startsWith(name)), prefix);
  }
});

// The tutorial docs/tutorials/editor.md with the program and its language server: each step gives what the page says.

import * as assert from "node:assert/strict";
import { ChildProcess, spawn, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import * as path from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { createMessageConnection, MessageConnection, StreamMessageReader, StreamMessageWriter } from "vscode-jsonrpc/node";
import * as manifest from "../package.json";

interface Diagnostic {
  code: string;
  message: string;
  range: { start: { line: number }; end: { line: number } };
}

const program = process.env.REVOLVE ?? "revolve";
const page = readFileSync(path.join(process.env.EXTENSION_ROOT ?? ".", "../../docs/tutorials/editor.md"), "utf8");
const folder = mkdtempSync(path.join(tmpdir(), "revolve tutorial "));
const deck = path.join(folder, "rod_plate.inp");
const uri = pathToFileURL(deck).toString();

let lines: string[];
let server: ChildProcess;
let connection: MessageConnection;
let version = 0;

/** Sends a text of the deck. */
function send(text: string): void {
  version += 1;
  const document = { uri, version, languageId: "abaqus", text };
  const change = { textDocument: { uri, version }, contentChanges: [{ text }] };
  void (version === 1
    ? connection.sendNotification("textDocument/didOpen", { textDocument: document })
    : connection.sendNotification("textDocument/didChange", change));
}

/** Sends a text of the deck, which must change the diagnostics, and returns those of this version. */
function diagnostics(text: string): Promise<Diagnostic[]> {
  const sent = version + 1;
  const published = new Promise<Diagnostic[]>((resolve) =>
    connection.onNotification("textDocument/publishDiagnostics", (found: { version: number; diagnostics: Diagnostic[] }) => {
      if (found.version === sent) {
        resolve(found.diagnostics);
      }
    }),
  );
  send(text);
  return published;
}

/** Returns the text of the deck with another line; lines count from 1, as in the page. */
const withLine = (number: number, text: string) => lines.map((line, i) => (i === number - 1 ? text : line)).join("\n");

before(async () => {
  assert.equal(spawnSync(program, ["new", "plate"], { cwd: folder }).status, 0);
  lines = readFileSync(deck, "utf8").split("\n");
  server = spawn(program, ["lsp"], { stdio: ["pipe", "pipe", "inherit"] });
  const [input, output] = [server.stdin ?? assert.fail(), server.stdout ?? assert.fail()];
  connection = createMessageConnection(new StreamMessageReader(output), new StreamMessageWriter(input));
  connection.listen();
  await connection.sendRequest("initialize", { processId: process.pid, rootUri: null, capabilities: {} });
  await connection.sendNotification("initialized", {});
});

after(async () => {
  await connection.sendRequest("shutdown");
  await connection.sendNotification("exit");
  connection.dispose();
  server.kill();
  rmSync(folder, { recursive: true });
});

test("commands and settings of the page exist", () => {
  const titles = manifest.contributes.commands.map(({ category, title }) => `${category}: ${title}`);
  const named = [...page.matchAll(/\*\*(Revolve: [^*]*)\*\*/g)].map((found) => found[1]);
  assert.ok(named.length >= 4);
  assert.deepEqual(named.filter((title) => !titles.includes(title)), []);
  const settings = [...page.matchAll(/`(revolve\.[a-z]+)`/gi)].map((found) => found[1]);
  assert.ok(settings.length > 0 && settings.every((name) => name in manifest.contributes.configuration.properties));
});

test("the misspelled keyword is an error with code D101, and the quick fix corrects it", async () => {
  assert.match(page, /Change line 86 to .* `\*Rate Dependant`/);
  assert.match(lines[85], /^\*Rate Dependent,/);
  const [found, ...others] = await diagnostics(withLine(86, lines[85].replace("Dependent", "Dependant")));
  assert.deepEqual([found.code, found.range.start.line, others], ["D101", 85, []]);
  assert.match(found.message, /^unknown keyword \*Rate Dependant/);
  const context = { diagnostics: [found] };
  const [action] = (await connection.sendRequest("textDocument/codeAction", { textDocument: { uri }, range: found.range, context })) as {
    title: string;
    edit: { changes: Record<string, { newText: string }[]> };
  }[];
  assert.equal(action.title, "Write `*Rate Dependent`");
  assert.deepEqual(Object.values(action.edit.changes)[0].map((edit) => edit.newText), ["*Rate Dependent"]);
  assert.deepEqual(await diagnostics(withLine(86, lines[85].replace("Rate Dependent", "rate dependent"))), []);
});

test("the pointer shows the card of line 84 and the names of line 69", async () => {
  send(lines.join("\n"));
  /** Asserts the text at a word. Numbers of the model are there as soon as the deck has been checked. */
  const shows = async (number: number, word: string, expected: RegExp) => {
    const position = { line: number - 1, character: lines[number - 1].indexOf(word) };
    let shown = "";
    for (let i = 0; i < 600 && !expected.test(shown); i += 1) {
      await new Promise((resolve) => setTimeout(resolve, i === 0 ? 0 : 50));
      const answer = await connection.sendRequest("textDocument/hover", { textDocument: { uri }, position });
      shown = (answer as { contents: { value: string } } | null)?.contents.value ?? "";
    }
    assert.match(shown, expected);
  };
  await shows(84, "*Plastic", /\*PLASTIC\*\*: Metal plasticity\.[^]*- `HARDENING`/);
  await shows(69, "STEEL", /Young's modulus 207000/);
  await shows(69, "ROD", /80 elements/);
});

test("completion offers the words that the page names", async () => {
  const offered = async (number: number, text: string) => {
    send(withLine(number, text));
    const position = { line: number - 1, character: text.length };
    const list = (await connection.sendRequest("textDocument/completion", { textDocument: { uri }, position })) as { items: { label: string }[] };
    return list.items.map((item) => item.label);
  };
  assert.equal(lines[117], " U2, V2");
  assert.ok((await offered(118, " U2, V2, A")).includes("A"));
  assert.deepEqual((await offered(69, "*Solid Section, elset=")).sort(), ["PLATE", "ROD"]);
});

test("the run of the extended deck makes the number of new meshes that the page states", () => {
  writeFileSync(deck, withLine(118, " U2, V2, A"));
  const run = spawnSync(program, ["run", path.basename(deck)], { cwd: folder, encoding: "utf8" });
  const [, count] = /\nThe plate had (\d+) new meshes/.exec(page) ?? assert.fail("no number");
  assert.match(run.stdout + run.stderr, new RegExp(`\\nnew meshes: ${count} `));
});

// Commands, tasks, panels and the start of the server, with fakes of VS Code and of the program. All paths contain blanks.

import * as assert from "node:assert/strict";
import { chmodSync, copyFileSync, existsSync, mkdirSync, mkdtempSync, readFileSync, realpathSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import * as path from "node:path";
import { after, before, beforeEach, test } from "node:test";
import { activate } from "../src/extension";
import { createDeckTask, DeckTaskDefinition, DeckTaskProvider } from "../src/tasks";
import { clients, LanguageClient } from "./fakeClient";
import * as fake from "./fakeVscode";
import { recorded } from "./fakeVscode";

const root = process.env.EXTENSION_ROOT ?? ".";
const folder = realpathSync(mkdtempSync(path.join(tmpdir(), "revolve 'commands' & ")));
const program = path.join(folder, "my program.mjs");
const deck = path.join(folder, "models 1", 'long "rod" $HOME.inp');

const subscriptions: { dispose(): void }[] = [];
const workspaceFolder = { uri: fake.Uri.file(folder) };

/** Starts a command of the extension. */
const command = (name: string, ...words: unknown[]) => Promise.resolve(recorded.commands.get(`revolve.${name}`)?.(...words));

/** Waits until a condition holds. */
async function until(condition: () => boolean): Promise<void> {
  for (let i = 0; i < 500 && !condition(); i += 1) {
    await new Promise((resolve) => setTimeout(resolve, 10));
  }
  assert.ok(condition(), condition.toString());
}

before(async () => {
  copyFileSync(path.join(root, "test", "fakeProgram.mjs"), program);
  chmodSync(program, 0o755);
  mkdirSync(path.dirname(deck));
  writeFileSync(deck, "*Heading\n title\n*Node\n 1, 0., 0.\n");
  recorded.settings.path = program;
  activate({ subscriptions } as never);
  await until(() => clients.length === 1);
});

beforeEach(() => {
  Object.assign(recorded, { messages: [], panels: [], tasks: [], answer: undefined, executed: [], saved: 0 });
  Object.assign(recorded.settings, { path: program, mode: "auto" });
  Object.assign(fake.workspace, { textDocuments: [], isTrusted: true, workspaceFolders: [workspaceFolder] });
  rmSync(path.join(path.dirname(deck), "out"), { recursive: true, force: true });
  delete process.env.REVOLVE_LACKS;
  fake.openDocument(deck);
});

after(() => rmSync(folder, { recursive: true }));

test("all commands of the package are registered, and only these", async () => {
  const { default: manifest } = await import("../package.json");
  const contributed = manifest.contributes.commands.map((entry) => entry.command);
  assert.deepEqual([...recorded.commands.keys()].sort(), contributed.sort());
});

test("run and check pass the name of the deck as one argument, in its folder", async () => {
  for (const name of ["run", "check"]) {
    assert.equal(await command(name), 0);
    const { task, output } = recorded.tasks.at(-1) ?? assert.fail("no task");
    const received = JSON.parse(output);
    assert.deepEqual(received, { words: [name, path.basename(deck)], cwd: path.dirname(deck), untrusted: "" });
    assert.deepEqual([task.execution.process, task.source], [program, "revolve"]);
  }
  assert.deepEqual(recorded.messages, []);
});

test("without a workspace folder the deck and its results have absolute paths", async () => {
  fake.workspace.workspaceFolders = undefined;
  const results = path.join(path.dirname(deck), "out", path.parse(deck).name);
  assert.deepEqual([await command("run"), await command("check")], [0, 0]);
  const words = recorded.tasks.map(({ output }) => JSON.parse(output).words);
  assert.deepEqual(words, [["run", "--out", results, deck], ["check", deck]]);
});

test("a deck with changes is saved first, and a deck from the explorer is used", async () => {
  fake.openDocument(path.join(folder, "other.inp"), true);
  await command("check", fake.Uri.file(deck));
  assert.equal(recorded.saved, 0);
  assert.deepEqual(JSON.parse(recorded.tasks[0].output).words, ["check", path.basename(deck)]);
  fake.workspace.textDocuments.length = 0;
  fake.openDocument(deck, true);
  await command("check");
  assert.equal(recorded.saved, 1);
});

test("without a deck on a disk a message says what to do", async () => {
  fake.window.activeTextEditor = undefined;
  await command("run");
  await command("run", fake.Uri.parse("untitled:Untitled-1"));
  assert.match(recorded.messages[0], /No deck is open/);
  assert.match(recorded.messages[1], /Save it first/);
  assert.equal(recorded.tasks.length, 0);
});

test("a missing program is reported, with a way to the setting", async () => {
  recorded.settings.path = path.join(folder, "no such program");
  recorded.answer = "Open settings";
  for (const name of ["run", "liveView"]) {
    assert.equal(await command(name), undefined);
    await until(() => recorded.executed.length === 1);
    assert.match(recorded.messages.pop() ?? "", /no such program` was not found.*revolve\.path/);
    assert.equal(recorded.executed.pop(), "workbench.action.openSettings revolve.path");
  }
  assert.equal(recorded.tasks.length, 0);
});

test("tasks of tasks.json have further arguments before the deck and keep their definition", () => {
  const definition: DeckTaskDefinition = {
    type: "revolve",
    command: "run",
    deck: "models 1/a b.inp",
    arguments: ["--user", "my law.f", "--set", "V=500"],
  };
  const task = new DeckTaskProvider(() => false).resolveTask({ definition, scope: workspaceFolder } as never) as never as fake.Task;
  assert.deepEqual(task.execution.args, ["run", "--user", "my law.f", "--set", "V=500", "a b.inp"]);
  assert.equal(task.execution.options.cwd, path.join(folder, "models 1"));
  assert.equal(task.definition, definition);
  const unknown = { definition: { type: "revolve", command: "mesh", deck: "a.inp" }, scope: workspaceFolder };
  assert.equal(new DeckTaskProvider(() => false).resolveTask(unknown as never), undefined);
});

test("both commands are offered as tasks for the deck in the editor", () => {
  const offered = new DeckTaskProvider(() => true).provideTasks() as never as fake.Task[];
  assert.deepEqual(offered.map((task) => task.definition), ["run", "check"].map((name) => ({
    type: "revolve",
    command: name,
    deck: path.relative(folder, deck),
  })));
});

test("output becomes diagnostics only without the server", () => {
  const definition: DeckTaskDefinition = { type: "revolve", command: "check", deck };
  const matchers = (serverRuns: boolean) => createDeckTask(definition, undefined, serverRuns).problemMatchers;
  assert.deepEqual([matchers(true), matchers(false)], [[], ["$revolve"]]);
});

test("a report offers to run the deck, and its panel is used again", async () => {
  await command("report");
  assert.match(recorded.messages[0], /has no results/);
  assert.equal(recorded.panels.length, 0);
  recorded.answer = "Run the deck";
  await command("report");
  await command("report");
  const [panel] = recorded.panels;
  assert.deepEqual([recorded.panels.length, panel.reveals, recorded.tasks.length], [1, 1, 1]);
  // The fake page has no policy of its own.
  assert.match(panel.webview.html, /^<html><head><meta http-equiv="Content-Security-Policy" content="default-src 'none';/);
  assert.ok(panel.webview.html.includes('<title>long "rod" $HOME</title>'));
  assert.deepEqual(panel.options.localResourceRoots, []);
  panel.dispose();
  await command("report");
  assert.equal(recorded.panels.length, 2);
});

test("results of runs in a workspace folder are found", async () => {
  const results = path.join(folder, "out", path.parse(deck).name);
  mkdirSync(results, { recursive: true });
  await command("report");
  assert.ok(existsSync(path.join(results, "report.html")));
  assert.equal(recorded.panels.length, 1);
  rmSync(path.join(folder, "out"), { recursive: true });
});

/** Returns number and arguments of the process of the last live view, which the fake program writes. */
const viewProcess = (): { id: number; words: string[] } =>
  JSON.parse(readFileSync(path.join(path.dirname(deck), "view process"), "utf8"));

/** Returns whether the process of the last live view runs. */
function runs(): boolean {
  try {
    return process.kill(viewProcess().id, 0);
  } catch {
    return false;
  }
}

test("a live view shows the printed address and ends with its panel", async () => {
  await command("liveView");
  const [panel] = recorded.panels;
  assert.match(panel.webview.html, /<iframe src="http:\/\/127\.0\.0\.1:4711\/\?key=a%20b&#38;n=1"/);
  assert.match(panel.webview.html, /content="default-src &#39;none&#39;; .*frame-src http:\/\/127\.0\.0\.1:4711"/);
  assert.doesNotMatch(panel.webview.html, /script-src|<script/);
  assert.deepEqual(recorded.messages, []);
  assert.equal(runs(), true);
  // The page is in the panel, so no browser opens.
  assert.deepEqual(viewProcess().words, ["view", "--no-browser", path.basename(deck)]);
  panel.dispose();
  await until(() => !runs());
});

test("a live view that fails shows the output of the program", async () => {
  const faulty = path.join(path.dirname(deck), "faulty deck.inp");
  writeFileSync(faulty, "*Faulty\n");
  await command("liveView", fake.Uri.file(faulty));
  assert.match(recorded.messages[0], /revolve view faulty deck\.inp: .*error\[D101\]/s);
  assert.equal(recorded.panels.length, 0);
});

test("a program without the command `view` is reported with its version", async () => {
  process.env.REVOLVE_LACKS = "view";
  await command("liveView");
  await until(() => recorded.messages.length === 1);
  assert.match(recorded.messages[0], /revolve 0\.0\.1 \(test\) does not know the command `revolve view`, so there is no live view/);
  assert.equal(recorded.panels.length, 0);
});

test("the server is started with standard input and output and the mode of the settings", async () => {
  recorded.settings.mode = "revolve";
  const earlier = clients.at(-1);
  await command("restartServer");
  const client = clients.at(-1) ?? assert.fail("no client");
  assert.equal(earlier?.isRunning(), false);
  assert.deepEqual([client.server.command, client.server.args, client.server.transport], [program, ["lsp"], undefined]);
  assert.deepEqual(client.options.initializationOptions, { mode: "revolve" });
  assert.equal(client.server.options.env.REVOLVE_UNTRUSTED, undefined);
});

test("a change of the settings and a grant of trust restart the server", async () => {
  fake.workspace.isTrusted = false;
  const count = clients.length;
  fake.settingsChange.fire({ affectsConfiguration: (name: string) => name === "editor" });
  fake.settingsChange.fire({ affectsConfiguration: (name: string) => name === "revolve" });
  await until(() => clients.length === count + 1);
  assert.equal(clients.at(-1)?.server.options.env.REVOLVE_UNTRUSTED, "1");
  fake.workspace.isTrusted = true;
  fake.trustGrant.fire(undefined);
  await until(() => clients.length === count + 2);
  assert.equal(clients.at(-1)?.server.options.env.REVOLVE_UNTRUSTED, undefined);
});

test("tasks of an untrusted workspace restrict the deck", async () => {
  fake.workspace.isTrusted = false;
  await command("check");
  assert.equal(JSON.parse(recorded.tasks[0].output).untrusted, "1");
});

test("without the command `lsp` the extension folds and says what is missing", async () => {
  const folding = recorded.providers.get("folding") as { provideFoldingRanges(document: unknown): unknown[] };
  const ranges = () => folding.provideFoldingRanges(fake.openDocument(deck)).length;
  LanguageClient.capabilities = { foldingRangeProvider: true };
  await command("restartServer");
  assert.equal(ranges(), 0);
  process.env.REVOLVE_LACKS = "lsp";
  await command("restartServer");
  assert.equal(ranges(), 2);
  await until(() => recorded.messages.length === 1);
  assert.match(recorded.messages[0], /does not know the command `revolve lsp`/);
});

// The last test: afterwards nothing is subscribed.
test("a live view ends with the extension", async () => {
  await command("liveView");
  assert.equal(runs(), true);
  subscriptions.forEach((item) => item.dispose());
  await until(() => !runs());
});

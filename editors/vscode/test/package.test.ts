// The package: its files, and the bundle with the real language client. Run `npm run package` before.

import * as assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import Module, { createRequire } from "node:module";
import * as path from "node:path";
import { test } from "node:test";
import { listFiles, PackageManager } from "@vscode/vsce";
import * as manifest from "../package.json";
import * as fake from "./fakeVscode";

const root = process.env.EXTENSION_ROOT ?? ".";

test("the package contains these files only", async () => {
  const files = await listFiles({ cwd: root, packageManager: PackageManager.None });
  assert.deepEqual(files.sort(), [
    "README.md",
    "dist/LIBRARIES.txt",
    "dist/LICENSE-APACHE",
    "dist/LICENSE-MIT",
    "dist/extension.js",
    "language-configuration.json",
    "package.json",
    "snippets/cards.json",
    "snippets/decks.json",
    "syntaxes/abaqus.tmLanguage.json",
  ]);
  assert.ok(readdirSync(root).includes(`${manifest.name}-${manifest.version}.vsix`));
});

test("the bundle needs only VS Code, and registers the commands", async () => {
  // Classes and functions that the fake lacks, for the language client.
  const vscode = new Proxy(fake, { get: (known, name) => Reflect.get(known, name) ?? class Unknown {} });
  const loader = Module as unknown as { _load(name: string, ...rest: unknown[]): unknown };
  const load = loader._load;
  const loaded = new Set<string>();
  loader._load = (name, ...rest) => {
    loaded.add(name);
    return name === "vscode" ? vscode : load(name, ...rest);
  };
  try {
    const extension = createRequire(__filename)(path.join(root, "dist/extension.js"));
    const known = new Set(Module.builtinModules);
    const others = [...loaded].filter((name) => !path.isAbsolute(name) && !known.has(name.replace(/^node:/, "")));
    assert.deepEqual(others, ["vscode"]);
    fake.recorded.settings.path = path.join(root, "no such program");
    extension.activate({ subscriptions: [] });
    assert.ok(fake.recorded.commands.has("revolve.run"));
    await extension.deactivate();
  } finally {
    loader._load = load;
  }
});

test("each bundled library is in the list of licences", () => {
  const bundle = readFileSync(path.join(root, "dist/LIBRARIES.txt"), "utf8");
  for (const name of ["vscode-languageclient", "vscode-jsonrpc", "minimatch"]) {
    assert.match(bundle, new RegExp(`^${name} [0-9.]+ \\(`, "m"));
  }
});

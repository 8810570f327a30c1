// Bundles the tests with fakes of `vscode` and of the language client, and runs them with node's test runner.

import { spawnSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const root = fileURLToPath(new URL("..", import.meta.url));
const outdir = mkdtempSync(path.join(tmpdir(), "revolve-vscode-"));
try {
  const names = readdirSync(path.join(root, "test")).filter((name) => name.endsWith(".test.ts"));
  await build({
    entryPoints: names.map((name) => path.join(root, "test", name)),
    outdir,
    bundle: true,
    platform: "node",
    target: "node20",
    sourcemap: "inline",
    logLevel: "warning",
    external: ["@vscode/vsce", "vscode-oniguruma", "vscode-textmate"],
    alias: {
      vscode: path.join(root, "test", "fakeVscode.ts"),
      "vscode-languageclient/node": path.join(root, "test", "fakeClient.ts"),
    },
  });
  const files = names.map((name) => path.join(outdir, name.replace(/\.ts$/, ".js")));
  const env = { ...process.env, EXTENSION_ROOT: root, NODE_PATH: path.join(root, "node_modules") };
  const words = ["--enable-source-maps", "--test", "--test-timeout=120000", "--test-reporter=spec", ...files];
  process.exitCode = spawnSync(process.execPath, words, { stdio: "inherit", env }).status ?? 1;
} finally {
  rmSync(outdir, { recursive: true });
}

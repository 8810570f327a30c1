// Writes `dist`: the bundled extension, the licences of the project and of the bundled libraries, and the grammar as a
// property list for editors that do not read JSON.

import { copyFileSync, mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { build as buildPlist } from "plist";

const root = fileURLToPath(new URL("..", import.meta.url));
const dist = path.join(root, "dist");
/** Licences that bundled libraries may have. */
const LICENCES = ["0BSD", "Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "BlueOak-1.0.0", "ISC", "MIT"];

/** Returns the folders of the libraries in a bundle. */
function bundledLibraries(metafile) {
  const folders = Object.keys(metafile.inputs).map((file) => /^(?:.*\/)?node_modules\/(?:@[^/]+\/)?[^/]+/.exec(file)?.[0]);
  return [...new Set(folders.filter(Boolean))].sort();
}

/** Returns the name, version and licence text of a library. */
function licence(folder) {
  const { name, version, license } = JSON.parse(readFileSync(path.join(root, folder, "package.json"), "utf8"));
  const file = readdirSync(path.join(root, folder)).find((candidate) => /^licen[cs]e(\.\w+)?$/i.test(candidate));
  if (file === undefined || !LICENCES.includes(license)) {
    throw new Error(`${name} ${version} (${license}): needs a licence text and one of the licences ${LICENCES.join(", ")}`);
  }
  return `${name} ${version} (${license})\n\n${readFileSync(path.join(root, folder, file), "utf8").trim()}\n`;
}

rmSync(dist, { recursive: true, force: true });
mkdirSync(dist);
const { metafile } = await build({
  absWorkingDir: root,
  entryPoints: ["src/extension.ts"],
  outfile: "dist/extension.js",
  bundle: true,
  platform: "node",
  format: "cjs",
  target: "node20",
  external: ["vscode"],
  minify: true,
  metafile: true,
  logLevel: "warning",
});
const separator = `\n${"-".repeat(80)}\n\n`;
writeFileSync(path.join(dist, "LIBRARIES.txt"), bundledLibraries(metafile).map(licence).join(separator));
for (const name of ["LICENSE-MIT", "LICENSE-APACHE"]) {
  copyFileSync(path.join(root, "../..", name), path.join(dist, name));
}
const grammar = JSON.parse(readFileSync(path.join(root, "syntaxes/abaqus.tmLanguage.json"), "utf8"));
writeFileSync(path.join(dist, "abaqus.tmLanguage"), buildPlist(grammar) + "\n");

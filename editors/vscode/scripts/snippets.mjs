// Writes snippets/decks.json: complete decks with tab stops at their parameters. The decks are snippets/minimal.inp and the
// examples of `revolve new`. With --check it writes nothing and fails if the file is not current.
// REVOLVE names the program.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";

const FILE = new URL("../snippets/decks.json", import.meta.url);
const MINIMAL = new URL("../snippets/minimal.inp", import.meta.url);
/** Examples of `revolve new` that are one file. */
const EXAMPLES = ["taylor", "ogive", "plate"];

/** Returns the text of an example. */
function example(name) {
  const folder = mkdtempSync(path.join(tmpdir(), "revolve-snippets-"));
  try {
    execFileSync(process.env.REVOLVE ?? "revolve", ["new", name, "--quiet", "--out", folder]);
    const files = readdirSync(folder);
    if (files.length !== 1) {
      throw new Error(`revolve new ${name} wrote ${files.join(", ")}, expected one deck`);
    }
    return readFileSync(path.join(folder, files[0]), "utf8");
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** Returns the lines of a snippet: the values of *PARAMETER are tab stops, up to the comment `# derived`. */
function withTabStops(text) {
  let stops = 0;
  let isInput = false;
  return text.trimEnd().split("\n").map((line) => {
    const escaped = line.replace(/[\\$}]/g, "\\$&");
    if (/^\*(?!\*)/.test(line)) {
      isInput = /^\*parameter\s*$/i.test(line);
    }
    isInput &&= !line.startsWith("# derived");
    const definition = isInput && /^(\w+\s*=\s*)(.*\S)\s*$/.exec(escaped);
    return definition ? `${definition[1]}\${${++stops}:${definition[2]}}` : escaped;
  });
}

/** Returns the snippet of a deck; its description is the title of the deck. */
function snippet(name, text) {
  const title = text.split("\n")[1].trim();
  return { prefix: `deck-${name}`, description: title, body: [...withTabStops(text), "$0"] };
}

const decks = { minimal: readFileSync(MINIMAL, "utf8") };
for (const name of EXAMPLES) {
  decks[name] = example(name);
}
const snippets = Object.entries(decks).map(([name, text]) => [`Deck: ${name}`, snippet(name, text)]);
const json = JSON.stringify(Object.fromEntries(snippets), null, 2) + "\n";
if (!process.argv.includes("--check")) {
  writeFileSync(FILE, json);
} else if (readFileSync(FILE, "utf8") !== json) {
  console.error("snippets/decks.json is not current: run `npm run snippets`");
  process.exit(1);
}

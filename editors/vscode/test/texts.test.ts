// Functions without VS Code: command lines, addresses, paths, folding, content security policies, the manifest.

import * as assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import * as path from "node:path";
import { test } from "node:test";
import * as manifest from "../package.json";
import { deckCommandLine, printedAddress, resultFolders } from "../src/commandLine";
import { foldingRanges } from "../src/folding";
import { resolvePath } from "../src/program";
import { securedPage } from "../src/report";

const root = process.env.EXTENSION_ROOT ?? ".";

test("a deck name that looks like an option is passed as a path", () => {
  assert.deepEqual(deckCommandLine("check", "/a b/-q.inp").words, ["check", "./-q.inp"]);
});

test("results are in `out`, in the folder of the deck first", () => {
  assert.deepEqual(resultFolders("/w/input/a b.c.inp", ["/w", "/w/input"]), ["/w/input/out/a b.c", "/w/out/a b.c"]);
});

test("only complete addresses of this machine are accepted", () => {
  assert.equal(printedAddress("view: http://127.0.0.1:80/x?key=1\n"), "http://127.0.0.1:80/x?key=1");
  assert.equal(printedAddress("\x1b[1mhttp://[::1]:80/\x1b[0m"), "http://[::1]:80/");
  assert.equal(printedAddress("http://localhost:8080 "), "http://localhost:8080");
  assert.equal(printedAddress("http://127.0.0.1:80"), undefined);
  assert.equal(printedAddress("http://127.0.0.1.example.com/ https://example.com/\n"), undefined);
});

test("paths of the program are resolved", () => {
  const resolve = (setting: string) => resolvePath(setting, "/home/a b", "/project");
  assert.deepEqual(["revolve", "~/bin/revolve", "target/revolve", "/opt/revolve"].map(resolve), [
    "revolve",
    "/home/a b/bin/revolve",
    "/project/target/revolve",
    "/opt/revolve",
  ]);
});

test("cards, steps and comments are folded", () => {
  const lines = [
    "*Heading", // 0
    " title",
    "** one", // 2
    "** two",
    "*Part, name=A", // 4
    "*Node,",
    " nset=ALL",
    "  1, 0., 0.",
    "",
    "** of the next card", // 9
    "*End Part",
    "*STEP", // 11
    "*Boundary",
    " 1, 1",
    "*end step",
    "*End Assembly",
    "*Density",
    " 1.,",
  ];
  const ranges = foldingRanges(lines.join("\r\n")).map(({ start, end, isComment }) => [start, end, isComment]);
  assert.deepEqual(ranges, [
    [0, 1, false],
    [2, 3, true],
    [4, 10, false],
    [5, 7, false],
    [11, 14, false],
    [12, 13, false],
    [16, 17, false],
  ]);
});

test("the page of `revolve report` keeps its policy, which allows one script by its hash", () => {
  const page = `<head><meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'sha256-x'"></head>`;
  assert.equal(securedPage(page), page);
  assert.match(securedPage("<p>"), /^<meta http-equiv="Content-Security-Policy" content="default-src 'none'; /);
});

test("the first line of a deck is detected", () => {
  const first = new RegExp(manifest.contributes.languages[0].firstLine);
  const grammar = JSON.parse(readFileSync(path.join(root, "syntaxes/abaqus.tmLanguage.json"), "utf8"));
  const ofGrammar = new RegExp(grammar.firstLineMatch.replace("(?i)", ""), "i");
  for (const expression of [first, ofGrammar]) {
    const matches = (line: string) => expression.test(line);
    assert.ok(["*Heading", " *HEADING", "*node, nset=ALL", "* Part, name=A", "*Include, input=a.inp"].every(matches));
    assert.ok(!["*Nodes", "* a list item", "/*", "[TITLE]", "** comment", "*Heading of a list"].some(matches));
  }
});

test("patterns of the grammar work in the engines of other editors", () => {
  const grammar = readFileSync(path.join(root, "syntaxes/abaqus.tmLanguage.json"), "utf8");
  const patterns = [...grammar.matchAll(/"(?:match|begin|end)": (".*")/g)].map((found) => JSON.parse(found[1]) as string);
  assert.ok(patterns.length > 30);
  for (const pattern of patterns) {
    // The syntax that Oniguruma, PCRE and JavaScript share: no \G, and lookbehind of fixed length.
    assert.doesNotThrow(() => new RegExp(pattern.replace(/^\(\?i\)/, "")), pattern);
    assert.doesNotMatch(pattern, /\\G|\(\?<[=!][^)]*[*+?{|]/);
  }
});

test("files of the manifest exist, and its version is that of the program", () => {
  const { languages, grammars, snippets } = manifest.contributes;
  const files = [...languages.map((l) => l.configuration), ...grammars.map((g) => g.path), ...snippets.map((s) => s.path)];
  assert.deepEqual(files.filter((file) => !existsSync(path.join(root, file))), []);
  const cargo = readFileSync(path.join(root, "../../Cargo.toml"), "utf8");
  const [, version] = /\[workspace\.package\]\nversion = "(.*)"/.exec(cargo) ?? [];
  assert.equal(manifest.version, version);
});

test("words of decks are words of the editor", () => {
  const { wordPattern } = JSON.parse(readFileSync(path.join(root, "language-configuration.json"), "utf8"));
  const words = (line: string) => line.match(new RegExp(wordPattern, "g"));
  assert.deepEqual(words("PART-1.FOOT, 2, -1.5e-3"), ["PART-1.FOOT", "2", "1.5e-3"]);
  assert.deepEqual(words("v = 2*n + U2@TIP + .5D3"), ["v", "2", "n", "U2@TIP", ".5D3"]);
});

// Command lines of the program and places of its results, without the interface of VS Code.

import * as path from "node:path";

/** Arguments and working folder of a call. */
export interface CommandLine {
  words: string[];
  cwd: string;
}

/** Returns the call of a command for a deck. It runs in the folder of the deck, so results are in `out` there. */
export function deckCommandLine(command: string, deck: string, further: string[] = []): CommandLine {
  const name = path.basename(deck);
  // A name that begins with `-` would be read as an option.
  const argument = name.startsWith("-") ? `.${path.sep}${name}` : name;
  return { words: [command, ...further, argument], cwd: path.dirname(deck) };
}

/**
 * Returns a call that gives the same results in any working folder. In a window without a folder VS Code starts processes of
 * tasks in the home folder only.
 */
export function absoluteCommandLine(command: string, deck: string, further: string[] = []): string[] {
  const place = command === "run" ? ["--out", resultFolders(deck, [])[0]] : [];
  return [command, ...place, ...further, deck];
}

/** Returns the folders that may contain the results of a deck: that of runs in the folder of the deck comes first. */
export function resultFolders(deck: string, workspaceFolders: string[]): string[] {
  const name = path.parse(deck).name;
  const folders = [path.dirname(deck), ...workspaceFolders].map((folder) => path.join(folder, "out", name));
  return [...new Set(folders)];
}

/** Returns the first address of this machine in the output of `revolve view`. */
export function printedAddress(output: string): string | undefined {
  // Colours of a terminal end an address as well.
  const address = /http:\/\/(?:127\.0\.0\.1|localhost|\[::1\])(?::\d+)?(?:\/[^\s"'<>\x1b]*)?(?=[\s"'<>\x1b])/;
  return address.exec(output)?.[0];
}

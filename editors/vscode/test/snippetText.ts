// Text of a snippet as VS Code inserts it, with the defaults of all tab stops.

/** Snippet as in the files of `snippets`. */
export interface Snippet {
  prefix: string;
  description: string;
  body: string[];
}

/** Returns the inserted text. Known are `$1`, `${1:default}` with nested tab stops, `${1|first,second|}` and escapes. */
export function insertedText(snippet: Snippet): string {
  const text = snippet.body.join("\n");
  let at = 0;
  const until = (end: string): string => {
    let out = "";
    while (at < text.length && !text.startsWith(end, at)) {
      out += piece();
    }
    at += end.length;
    return out;
  };
  const choice = (): string => {
    let all = "";
    while (!text.startsWith("|}", at)) {
      all += text[at] === "\\" ? text[at++] + text[at++] : text[at++];
    }
    at += 2;
    return (/^(?:\\.|[^,\\])*/.exec(all)?.[0] ?? "").replace(/\\(.)/g, "$1");
  };
  const piece = (): string => {
    if (text[at] === "\\") {
      at += 2;
      return text[at - 1];
    }
    const stop = /^\$(?:\{(\d+)([:|}])|\d+)/.exec(text.slice(at));
    if (stop === null) {
      if (text[at] === "$") {
        throw new Error(`unknown syntax at ${text.slice(at, at + 20)}`);
      }
      return text[at++];
    }
    at += stop[0].length;
    return stop[2] === ":" ? until("}") : stop[2] === "|" ? choice() : "";
  };
  let out = "";
  while (at < text.length) {
    out += piece();
  }
  return out.trimEnd();
}

// Folding without the language server: cards with their data lines, `*NAME` to `*END NAME`, and blocks of comments.

/** Range of lines, first and last included, counted from 0. */
export interface LineRange {
  start: number;
  end: number;
  isComment: boolean;
}

/** Returns the folding ranges of a text, at most one for each first line. */
export function foldingRanges(text: string): LineRange[] {
  return new FoldingScan().scan(text.split("\n"));
}

class FoldingScan {
  private readonly ranges = new Map<number, LineRange>();
  /** Keyword line of the current card, and the last of its data lines. */
  private card: { start: number; end: number } | undefined;
  /** First line of the current block of comments. */
  private comment: number | undefined;
  /** Keyword lines with their names, for `*END NAME`. */
  private open: { name: string; line: number }[] = [];

  scan(lines: string[]): LineRange[] {
    lines.forEach((line, at) => this.line(line.trim(), at));
    this.endComment(lines.length);
    this.endCard();
    return [...this.ranges.values()].sort((a, b) => a.start - b.start);
  }

  private line(line: string, at: number): void {
    if (line.startsWith("**")) {
      this.comment ??= at;
      return;
    }
    this.endComment(at);
    if (line.startsWith("*")) {
      this.endCard();
      this.keyword(line, at);
    } else if (line !== "" && this.card !== undefined) {
      this.card.end = at;
    }
  }

  private keyword(line: string, at: number): void {
    const name = line.slice(1).split(",")[0].replace(/\s/g, "").toUpperCase();
    this.card = { start: at, end: at };
    if (!name.startsWith("END")) {
      this.open.push({ name, line: at });
      return;
    }
    const begin = this.open.findLastIndex((candidate) => candidate.name === name.slice(3));
    if (begin >= 0) {
      this.add(this.open[begin].line, at, false);
      this.open.length = begin;
    }
  }

  private endCard(): void {
    if (this.card !== undefined) {
      this.add(this.card.start, this.card.end, false);
    }
    this.card = undefined;
  }

  private endComment(next: number): void {
    if (this.comment !== undefined) {
      this.add(this.comment, next - 1, true);
    }
    this.comment = undefined;
  }

  /** Adds a range; of two with the same first line the longer one is kept. */
  private add(start: number, end: number, isComment: boolean): void {
    const known = this.ranges.get(start);
    if (end > start && (known === undefined || known.end < end)) {
      this.ranges.set(start, { start, end, isComment });
    }
  }
}

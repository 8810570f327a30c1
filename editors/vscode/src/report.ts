// Side panel with the HTML page that `revolve report` writes.

import { existsSync } from "node:fs";
import { readFile } from "node:fs/promises";
import * as path from "node:path";
import * as vscode from "vscode";
import { resultFolders } from "./commandLine";
import { capture, configuredProgram, reportMissing } from "./program";

/** Content security policy of a page that states none: no scripts, and nothing from other places. */
const STRICT_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";

/**
 * Returns the page for a panel. The page of `revolve report` states its own content security policy, which allows its one
 * script by a hash and nothing from other places; it is kept. A page without a policy gets one that allows no script.
 */
export function securedPage(html: string): string {
  if (/<meta\s[^>]*http-equiv=["']?Content-Security-Policy["'\s]/i.test(html)) {
    return html;
  }
  const policy = `<meta http-equiv="Content-Security-Policy" content="${STRICT_POLICY}">`;
  return /<head[^>]*>/i.test(html) ? html.replace(/<head[^>]*>/i, (head) => head + policy) : policy + html;
}

/** Panels with reports, one for each folder of results. */
export class ReportPanels {
  private readonly panels = new Map<string, vscode.WebviewPanel>();

  /** Writes the report of a deck and shows it; `run` runs the deck if there are no results. */
  async show(deck: string, run: () => Promise<number | undefined>): Promise<void> {
    const workspaceFolders = (vscode.workspace.workspaceFolders ?? []).map((folder) => folder.uri.fsPath);
    const candidates = resultFolders(deck, workspaceFolders);
    let folder = candidates.find((candidate) => existsSync(candidate));
    if (folder === undefined) {
      const start = "Run the deck";
      const text = `${path.basename(deck)} has no results: ${candidates[0]} does not exist.`;
      if ((await vscode.window.showInformationMessage(text, start)) !== start || (await run()) !== 0) {
        return;
      }
      folder = candidates[0];
    }
    const page = await this.write(folder);
    if (page !== undefined) {
      this.open(folder, page);
    }
  }

  /** Runs `revolve report` and returns the page; `undefined` after a message. */
  private async write(folder: string): Promise<string | undefined> {
    const program = configuredProgram();
    const { status, stderr } = await capture(program, ["report", "--quiet", folder]);
    if (status === "missing") {
      void reportMissing(program);
      return undefined;
    }
    if (status !== 0) {
      void vscode.window.showErrorMessage(`revolve report ${folder}: ${stderr.trim() || `exit status ${status}`}`);
      return undefined;
    }
    return securedPage(await readFile(path.join(folder, "report.html"), "utf8"));
  }

  private open(folder: string, page: string): void {
    let panel = this.panels.get(folder);
    if (panel === undefined) {
      const place = { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true };
      // No files can be loaded: the page is self-contained.
      const options = { enableScripts: true, localResourceRoots: [], enableFindWidget: true };
      panel = vscode.window.createWebviewPanel("revolve.report", `Report: ${path.basename(folder)}`, place, options);
      panel.onDidDispose(() => this.panels.delete(folder));
      this.panels.set(folder, panel);
    } else {
      panel.reveal(undefined, true);
    }
    panel.webview.html = page;
  }
}

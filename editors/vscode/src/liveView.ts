// Live view: starts `revolve view` for a deck, which opens no browser, and shows the page at the address that it prints.

import { ChildProcess, spawn } from "node:child_process";
import * as path from "node:path";
import * as vscode from "vscode";
import { deckCommandLine, printedAddress } from "./commandLine";
import { configuredProgram, environment, hasCommand, reportMissing, reportUnknownCommand } from "./program";

/** Returns the page that shows an address in a frame: it has no script, and only that address can be loaded. */
export function framePage(address: string, title: string): string {
  const escape = (text: string) => text.replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`);
  const policy = `default-src 'none'; style-src 'unsafe-inline'; frame-src ${new URL(address).origin}`;
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="${escape(policy)}">
<style>html, body, iframe { margin: 0; padding: 0; border: 0; width: 100%; height: 100%; display: block; }</style>
</head>
<body><iframe src="${escape(address)}" title="${escape(title)}" sandbox="allow-scripts allow-same-origin allow-forms allow-downloads"></iframe></body>
</html>
`;
}

/** Waits for the address in the output of a process; rejects with the output if the process ends without one. */
export function waitForAddress(process: ChildProcess, log: (text: string) => void): Promise<string> {
  return new Promise((resolve, reject) => {
    let output = "";
    const read = (data: Buffer) => {
      output += data.toString();
      log(data.toString());
      const address = printedAddress(output);
      if (address !== undefined) {
        resolve(address);
      }
    };
    process.stdout?.on("data", read);
    process.stderr?.on("data", read);
    process.on("error", reject);
    process.on("close", (status) => reject(new Error(output.trim() || `it ended with exit status ${status}`)));
  });
}

/** Live views of this window. A program ends with its panel, and all end with the extension. */
export class LiveViews implements vscode.Disposable {
  private readonly processes = new Set<ChildProcess>();

  constructor(private readonly log: vscode.LogOutputChannel) {}

  /** Starts the live view of a deck in a panel. */
  async show(deck: string): Promise<void> {
    const program = configuredProgram();
    const known = await hasCommand(program, "view");
    if (known === "missing") {
      return reportMissing(program);
    }
    if (!known) {
      return reportUnknownCommand(program, "view", "there is no live view");
    }
    const { words, cwd } = deckCommandLine("view", deck, ["--no-browser"]);
    const process = spawn(program.path, words, { cwd, env: environment(program), stdio: ["ignore", "pipe", "pipe"] });
    this.processes.add(process);
    process.on("close", () => this.processes.delete(process));
    try {
      const address = await waitForAddress(process, (text) => this.log.info(text.trimEnd()));
      const forwarded = await vscode.env.asExternalUri(vscode.Uri.parse(address, true));
      openPanel(path.basename(deck), forwarded.toString(true), process);
    } catch (error) {
      process.kill();
      void vscode.window.showErrorMessage(`revolve view ${path.basename(deck)}: ${(error as Error).message}`);
    }
  }

  dispose(): void {
    this.processes.forEach((process) => process.kill());
  }
}

function openPanel(name: string, address: string, process: ChildProcess): void {
  const title = `Live view: ${name}`;
  // Frames have no scripts in a panel without scripts; the policy of the page forbids its own.
  const options = { enableScripts: true, localResourceRoots: [], retainContextWhenHidden: true };
  const panel = vscode.window.createWebviewPanel("revolve.liveView", title, vscode.ViewColumn.Beside, options);
  panel.webview.html = framePage(address, title);
  panel.onDidDispose(() => process.kill());
}

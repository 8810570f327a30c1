// Language server `revolve lsp`: start, restart and stop.

import * as vscode from "vscode";
import { LanguageClient, LanguageClientOptions, ServerOptions } from "vscode-languageclient/node";
import { configuredProgram, hasCommand, reportMissing, reportUnknownCommand, RevolveProgram, environment } from "./program";

/** The C library of Linux returns the memory of arrays above this size to the system. By default the limit grows to 32 MB,
 * and the server would keep much of the memory that the check of a large deck needs for a moment. */
const MEMORY = { MALLOC_MMAP_THRESHOLD_: "1048576" };

/** Returns how the server is started: standard input and output, no further argument. */
export function serverOptions(program: RevolveProgram): ServerOptions {
  return { command: program.path, args: ["lsp"], options: { env: { ...MEMORY, ...environment(program) } } };
}

/** Returns the options of the client: the settings go to the server when it starts. */
export function clientOptions(mode: string, log: vscode.LogOutputChannel): LanguageClientOptions {
  return {
    documentSelector: [
      { scheme: "file", language: "abaqus" },
      { scheme: "untitled", language: "abaqus" },
    ],
    initializationOptions: { mode },
    outputChannel: log,
  };
}

/** The language server of this window. */
export class DeckServer implements vscode.Disposable {
  private client: LanguageClient | undefined;
  /** Start or stop that is in progress; the next one waits for it. */
  private pending: Promise<void> = Promise.resolve();

  constructor(private readonly log: vscode.LogOutputChannel) {}

  /** Whether the server runs. */
  get runs(): boolean {
    return this.client?.isRunning() ?? false;
  }

  /** Whether the server computes folding ranges. */
  get folds(): boolean {
    return this.runs && Boolean(this.client?.initializeResult?.capabilities.foldingRangeProvider);
  }

  /** Starts the server with the current settings, after stopping the one that runs. */
  restart(): Promise<void> {
    this.pending = this.pending.then(() => this.stopClient()).then(() => this.startClient());
    return this.pending;
  }

  /** Stops the server. */
  stop(): Promise<void> {
    this.pending = this.pending.then(() => this.stopClient());
    return this.pending;
  }

  dispose(): void {
    void this.stop();
  }

  private async startClient(): Promise<void> {
    const program = configuredProgram();
    const known = await hasCommand(program, "lsp");
    if (known === "missing") {
      return void reportMissing(program);
    }
    if (!known) {
      return void reportUnknownCommand(program, "lsp", "there are no diagnostics while you type");
    }
    const mode = vscode.workspace.getConfiguration("revolve").get<string>("mode", "auto");
    const client = new LanguageClient("revolve", "Revolve", serverOptions(program), clientOptions(mode, this.log));
    try {
      await client.start();
      this.client = client;
    } catch (error) {
      this.log.error(`revolve lsp did not start: ${(error as Error).message}`);
      void vscode.window.showErrorMessage("The language server `revolve lsp` did not start. See the output of Revolve.");
    }
  }

  private async stopClient(): Promise<void> {
    const client = this.client;
    this.client = undefined;
    await client?.stop().catch((error: Error) => this.log.warn(`revolve lsp did not stop: ${error.message}`));
  }
}
